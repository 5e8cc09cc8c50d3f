#!/usr/bin/env bash
# Times target/release/sprung against NumPy, Numba, Pinocchio and MuJoCo.
#
#   cargo build --release && benches/peers/run.sh [FOLDER]
#
# A program that cannot be installed is skipped. The log of an hour of the arm with seven
# flexible joints takes 1.5 GB on disk.
# FOLDER keeps the virtual environment and the logs; the default is a temporary folder.
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
for peer in pinocchio mujoco; do
    [ -e "$work/venv/has-$peer" ] && continue
    if "$work/venv/bin/pip" install --quiet -r "$here/requirements-$peer.txt"; then
        touch "$work/venv/has-$peer"
    else
        echo "$peer cannot be installed: its comparisons are skipped"
    fi
done

# Succeeds if a program is installed.
has() {
    [ -e "$work/venv/has-$1" ] || { echo "skipped: $1 is not installed"; false; }
}

# Prints the first number divided by the second.
ratio() {
    awk "BEGIN { printf \"%.1f\", $1 / $2 }"
}

# Prints the fastest run of a benchmark of sprung with an argument, in microseconds.
bench() {
    (cd "$here" && cargo bench --quiet -p sprung --bench "$1" -- "$2" 2>/dev/null) |
        LC_ALL=C sed 's/^[^a-z0-9]*//' | awk -v bench="$2" -v name="$3" '
            function take(value, unit) {
                found = value * (unit == "ns" ? 1e-3 : unit == "ms" ? 1e3 : unit == "s" ? 1e6 : 1)
            }
            found { next }
            # The benchmark may print its own text between a name and its times.
            here { take($1, $2); next }
            $1 == bench { inside = 1 }
            inside && $1 == name { if ($2 ~ /^[0-9.]+$/) take($2, $3); else here = 1 }
            END { print found }'
}

# The other programs use one thread. The output states the threads of sprung.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1

# Runs a command and sets `seconds` (the best of `runs`, three) and `mebibytes`.
measure() {
    local start end kibibytes status
    seconds=""
    for _ in $(seq "${runs:-3}"); do
        status=0
        start=$EPOCHREALTIME
        /usr/bin/time -q -f %M -o "$work/time" "$@" >"$work/output" || status=$?
        end=$EPOCHREALTIME
        # Exit code 1 means an unusable result, not a failed run.
        [ "$status" -le 1 ] || return "$status"
        read -r kibibytes <"$work/time"
        mebibytes=$((kibibytes / 1024))
        seconds=$(awk -v a="$start" -v b="$end" -v best="${seconds:-1e9}" \
            'BEGIN { t = b - a; printf "%.3f", (t < best ? t : best) }')
    done
}

# Prints the largest relative difference between the parameters of the other program and of sprung.
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
        "$(ratio "$seconds" "$ours")" \
        "$(compare "$work/found/identification.json" "$work/output")"
done

echo
echo "closed loop of 1000 s:"
measure "$sprung" simulate "$work/demo/experiment.toml" --quiet \
    --set simulate.duration_s=1000 --out "$work/long"
echo "sprung     seconds $seconds, encoders, noise and CSV included"
echo "Numba      $("$python" "$here/simulate_numba.py" 1000 | tr '\n' ';'), the loop alone"

echo
echo "arm with seven flexible joints:"
seven=$here/../../examples/seven-joint-twin

if has pinocchio; then
    ours=$(bench regressor regressor_of_a_sample panda)
    "$python" "$here/regressor_pinocchio.py" >"$work/output"
    theirs=$(awk '/^microseconds/ { print $2 }' "$work/output")
    binding=$(awk '/^binding/ { print $2 }' "$work/output")
    echo "regressor  sprung $ours µs; Pinocchio $theirs µs, about $binding of them its Python" \
        "binding: $(ratio "$theirs" "$ours") times as long"
fi

"$sprung" simulate "$seven" --quiet --out "$work/seven"
log=$work/seven/identification.csv
"$sprung" simulate "$seven" --quiet --set simulate.duration_s=3600 --out "$work/hour"
identify=("$sprung" identify "$seven" --quiet --set identify.position_cutoff_hz=40)
for length in seven hour; do
    for threads in 1 2; do
        measure "${identify[@]}" --threads "$threads" \
            --set "log.file=$work/$length/identification.csv" --out "$work/found-$length"
        echo "identify   sprung, log of $(wc -l <"$work/$length/identification.csv") lines," \
            "--threads $threads: $seconds s, $mebibytes MiB"
        declare "${length}_$threads=$seconds"
    done
done
# shellcheck disable=SC2154
echo "           two threads are $(ratio "$hour_1" "$hour_2") times as fast for the hour"
if has pinocchio; then
    measure "$python" "$here/identify_pinocchio.py" "$log"
    # shellcheck disable=SC2154
    echo "identify   Pinocchio and NumPy, 15 s log: $seconds s, $mebibytes MiB:" \
        "$(ratio "$seconds" "$seven_1") times as long"
    hour=$(sed -n 's/^an hour, extrapolated: seconds \([0-9]*\),.*/\1/p' "$work/output")
    # shellcheck disable=SC2154
    echo "           $(tail -1 "$work/output"):" \
        "$(ratio "$hour" "$hour_1") times as long as on one thread"
fi

if has mujoco; then
    sed -e '/encoder_counts_per_turn/d' -e '/^torque_noise_nm/d' -e '/^motor_encoder_offset/d' \
        -e 's/^duration_s = .*/duration_s = 10.0/' "$seven/experiment.toml" >"$work/seven/exact.toml"
    cp "$seven/truth.toml" "$work/seven/"
    "$sprung" simulate "$work/seven/exact.toml" --quiet --out "$work/exact"
    ours=$(bench simulate closed_loop_of_seven_joints 0.0000001)
    echo "simulate   sprung, 10 s: $(awk "BEGIN { printf \"%.3f\", $ours / 1e6 }") s"
    # Steps of 0.25 ms give about the accuracy of sprung at its tolerance.
    for substeps in 4 10; do
        "$python" "$here/simulate_mujoco.py" "$work/exact/identification.csv" $substeps \
            >"$work/output"
        theirs=$(awk '/^seconds/ { print $2 }' "$work/output")
        echo "simulate   MuJoCo, 10 s: $(tr '\n' ';' <"$work/output")" \
            "$(ratio "$(awk "BEGIN { print 1e6 * $theirs }")" "$ours") times as long"
    done
fi

if has mujoco; then
    echo
    echo "logs of MuJoCo, 10 s, two joints with dry friction and tendons:"
    "$python" "$here/two_joints_mujoco.py" "$work/mujoco" 4
    (cd "$here" && cargo bench --quiet -p sprung --bench accuracy -- \
        --cases mujoco --mujoco "$work/mujoco")
fi
