"""Runs all adapters on all tasks and prints the table: `run.py TASKS [--write] [TOOL…]`; --write puts it into README.md."""
import json
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from score import Refused, score
from tasks import TASKS

HERE = Path(__file__).parent
TOOLS = {"sprung": "sprung", "numpy_least_squares": "NumPy least squares", "scipy_output_error": "SciPy output error",
         "mujoco_sysid": "MuJoCo sysid", "figaroh_base": "FIGAROH", "jaxterity_tool": "Jaxterity"}
LIMIT_S = 240


def run(tool, folder):
    """Figures of a tool on a task, with processor seconds; or why there are none."""
    out, log = folder / f"{tool}.json", folder / f"{tool}.log"
    out.unlink(missing_ok=True)
    words = [sys.executable, HERE / "adapters" / f"{tool}.py", folder, out]
    with log.open("w") as errors:
        done = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=errors, start_new_session=True)
    end = threading.Timer(LIMIT_S, os.killpg, (done.pid, signal.SIGKILL))   # with the programs that the adapter started
    end.start()
    _, status, used = os.wait4(done.pid, 0)
    end.cancel()
    done.returncode = os.waitstatus_to_exitcode(status)
    if done.returncode == -signal.SIGKILL:
        return {"absent": f"not done after {LIMIT_S} s"}
    if done.returncode or not out.exists():
        return {"absent": (log.read_text().strip().splitlines() or ["wrote no file"])[-1][:120]}
    try:
        figures = score(folder, json.loads(out.read_text()))
    except (Refused, ValueError) as why:
        return {"absent": f"not scored: {why}"}
    return figures | {"seconds": used.ru_utime + used.ru_stime}


def cell(x, digits=2):
    return "–" if x is None else f"{x:.{digits}g}" if x < 100 else f"{x:.0f}"


def table(results):
    head = "| task | tool | torque | deflection | error % | over bound | coverage % | s |\n|---|---|---|---|---|---|---|---|"
    rows, notes = [head], []
    for (name, tool), f in results.items():
        if "absent" in f:
            notes.append(f"- {TOOLS.get(tool, tool)} on {name}: {f['absent']}")
            continue
        torque = cell(f["torque_over_noise"]) if "torque_over_noise" in f else cell(f["torque_error_percent"]) + (" %" if f["torque_error_percent"] is not None else "")
        keys = ["deflection_over_noise", "error_percent", "error_over_bound", "coverage_percent", "seconds"]
        rows.append("| " + " | ".join([name, TOOLS.get(tool, tool), torque, *(cell(f.get(key)) for key in keys)]) + " |")
        if f["lacking"]:
            notes.append(f"- {TOOLS.get(tool, tool)} on {name} does not give {', '.join(f['lacking'][:4])}{' …' if len(f['lacking']) > 4 else ''}")
    return "\n".join(rows) + ("\n\nAbsent:\n\n" + "\n".join(notes) if notes else "")


def main(tasks, chosen, writes):
    there = [name for name in TASKS if (tasks / name / "task.json").exists()]
    for name in TASKS.keys() - set(there):
        print(f"skipped {name}: {tasks / name} does not exist", file=sys.stderr)
    results = {(name, tool): None for name in there for tool in chosen or TOOLS}

    def found(key):
        results[key] = run(key[1], tasks / key[0])
        print(*key, json.dumps(results[key]), file=sys.stderr, flush=True)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(found, sorted(results, key=lambda key: list(TOOLS).index(key[1]))))
    (tasks / "results.json").write_text(json.dumps({f"{a} {b}": f for (a, b), f in results.items()}, indent=1))
    text = table(results)
    print(text)
    if writes:
        page = (HERE / "README.md").read_text()
        begin, rest = page.split("<!-- results -->")
        end = rest.split("<!-- end -->")[1]
        day = time.strftime("%Y-%m-%d")
        (HERE / "README.md").write_text(f"{begin}<!-- results -->\n\n{text}\n\nMeasured on {day} by `benchmark/run.sh --write`.\n<!-- end -->{end}")


if __name__ == "__main__":
    words = [word for word in sys.argv[2:] if word != "--write"]
    main(Path(sys.argv[1]), words, "--write" in sys.argv)
