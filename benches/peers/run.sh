#!/usr/bin/env bash
# Times target/release/sprung against NumPy and Numba on the same logs.
#
#   cargo build --release && benches/peers/run.sh [FOLDER]
#
# FOLDER keeps the virtual environment and the logs; it is temporary by default.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
sprung=${SPRUNG:-$here/../../target/release/sprung}
if [ $# -gt 0 ]; then
    work=$1
    mkdir -p "$work"
    work=$(cd "$work" && pwd)
else
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
fi

if [ ! -x "$work/venv/bin/python" ]; then
    python3 -m venv "$work/venv"
    "$work/venv/bin/pip" install --quiet -r "$here/requirements.txt"
fi
python=$work/venv/bin/python

# sprung computes on one thread; so do its peers.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1

# Runs a command and sets `seconds` (the best of three) and `mebibytes`.
measure() {
    local start end kibibytes status
    seconds=""
    for _ in 1 2 3; do
        status=0
        start=$EPOCHREALTIME
        /usr/bin/time -q -f %M -o "$work/time" "$@" >"$work/output" || status=$?
        end=$EPOCHREALTIME
        # 1 says that a result is unusable, not that it is missing.
        [ "$status" -le 1 ] || return "$status"
        read -r kibibytes <"$work/time"
        mebibytes=$((kibibytes / 1024))
        seconds=$(awk -v a="$start" -v b="$end" -v best="${seconds:-1e9}" \
            'BEGIN { t = b - a; printf "%.3f", (t < best ? t : best) }')
    done
}

# Largest relative difference between the peer's parameters and ours.
compare() {
    "$python" - "$1" "$2" <<'EOF'
import json, sys
result = json.load(open(sys.argv[1]))["results"][0]
ours = [p["value"] for p in result["parameters"]]
theirs = [float(l.split()[1]) for l in open(sys.argv[2]) if l.startswith("theta")]
assert len(ours) == len(theirs) == 15
print(f"{max(abs(a / b - 1) for a, b in zip(theirs, ours)):.1e}")
EOF
}

"$sprung" demo --quiet --out "$work/demo" || [ $? -eq 1 ]
"$sprung" simulate "$work/demo/experiment.toml" --quiet \
    --set simulate.duration_s=1000 --out "$work/long"

printf '%-10s %-8s %9s %9s\n' log program seconds MiB
for log in "10 s:$work/demo" "1000 s:$work/long"; do
    name=${log%%:*}
    file=${log#*:}/identification.csv
    measure "$sprung" identify "$work/demo/experiment.toml" --quiet \
        --set "log.file=$file" --set 'identify.estimator=["least-squares"]' \
        --out "$work/found"
    ours=$seconds
    printf '%-10s %-8s %9s %9s\n' "$name" sprung "$seconds" "$mebibytes"
    measure "$python" "$here/identify_numpy.py" "$file"
    printf '%-10s %-8s %9s %9s\n' "$name" NumPy "$seconds" "$mebibytes"
    printf '%-10s %s in the process\n' "" "$(tail -1 "$work/output")"
    printf '%-10s its process takes %s times as long; parameters differ by %s\n' "" \
        "$(awk "BEGIN { printf \"%.1f\", $seconds / $ours }")" \
        "$(compare "$work/found/identification.json" "$work/output")"
done

echo
echo "closed loop of 1000 s:"
measure "$sprung" simulate "$work/demo/experiment.toml" --quiet \
    --set simulate.duration_s=1000 --out "$work/long"
echo "sprung     seconds $seconds, encoders, noise and CSV included"
echo "Numba      $("$python" "$here/simulate_numba.py" 1000 | tr '\n' ';'), the loop alone"
