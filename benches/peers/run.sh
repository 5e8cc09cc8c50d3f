#!/usr/bin/env bash
# Compares sprung with NumPy, Numba, Pinocchio and MuJoCo; run.py says how.
#
#   benches/peers/run.sh [FOLDER] [--without hour,mujoco]
exec python3 "$(dirname "${BASH_SOURCE[0]}")/run.py" "$@"
