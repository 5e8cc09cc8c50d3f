#!/usr/bin/env bash
# Makes the tasks, runs all adapters and prints the table: run.sh [--write] [TOOL…]
#   BENCHMARK_OUT    folder of tasks and results       [benchmark/out]
#   BENCHMARK_LOGS   folder with logs of real machines [benchmark/logs]
#   SPRUNG           the program sprung                [sprung]
set -euo pipefail
cd "$(dirname "$0")"
out=${BENCHMARK_OUT:-$PWD/out}
python=$out/venv/bin/python
[ -x "$python" ] || python3 -m venv --system-site-packages "$out/venv"
$python -c "import numpy, scipy" 2>/dev/null || $python -m pip install --quiet numpy scipy ||
    { echo "the benchmark needs NumPy and SciPy, and pip cannot install them" >&2 && exit 1; }
# Without a network the rows of these tools say which module is missing.
$python -c "import figaroh, jaxterity, mujoco.sysid" 2>/dev/null || $python -m pip install --quiet -r requirements.txt ||
    echo "some tools of other people are not installed" >&2
# More threads make small matrices slower.
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
mkdir -p "$out"
$python simulate.py "$out"
$python real.py "$out" "${BENCHMARK_LOGS:-$PWD/logs}"
$python run.py "$out" "$@"
