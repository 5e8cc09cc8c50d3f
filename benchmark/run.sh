#!/usr/bin/env bash
# Makes the tasks, runs all adapters and prints the table: run.sh [--write] [TOOL…]
#   BENCHMARK_OUT    folder of tasks and results       [benchmark/out]
#   BENCHMARK_LOGS   folder with logs of real machines [benchmark/logs]
#   SPRUNG           the program sprung                [sprung]
set -euo pipefail
cd "$(dirname "$0")"
out=${BENCHMARK_OUT:-$PWD/out}
python=python3
if ! $python -c "import numpy, scipy" 2>/dev/null; then
    # Without a network this names what is missing and ends.
    [ -x "$out/venv/bin/python" ] || python3 -m venv "$out/venv"
    python=$out/venv/bin/python
    $python -c "import numpy, scipy" 2>/dev/null || $python -m pip install --quiet numpy scipy ||
        { echo "the benchmark needs NumPy and SciPy, and pip cannot install them" >&2 && exit 1; }
fi
# More threads make small matrices slower.
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
mkdir -p "$out"
$python simulate.py "$out"
$python real.py "$out" "${BENCHMARK_LOGS:-$PWD/logs}"
$python run.py "$out" "$@"
