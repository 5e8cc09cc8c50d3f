"""Identifies the demo's robot from one log with sprung and with other tools, and prints processor time, errors and lines.

usage: run.py [TOOL…]

TOOL is a part of the name of a tool; all tools run without it. Errors are those of the parameters that a tool gives.
"""

import ast
import sys
import time
import warnings
from pathlib import Path

import numpy as np

import sprung

HERE = Path(__file__).resolve().parent
PEERS = HERE.parent / "peers"

sys.path.insert(0, str(HERE.parent))
from figure import note  # noqa: E402

# Values of the maker of the robot, from the demo's experiment; Coulomb friction is not known.
NOMINAL = {
    "link1.inertia_total": 0.190807, "link2.coupling": 0.016474, "link2.inertia": 0.010724,
    "joint1.rotor_inertia": 0.0628, "joint2.rotor_inertia": 0.002575,
    "joint1.link_viscous": 0.070364, "joint2.link_viscous": 0.028211,
    "joint1.motor_viscous": 4.5, "joint2.motor_viscous": 0.5,
    "joint1.stiffness": 9.0, "joint2.stiffness": 4.0,
    "joint1.link_coulomb": 0.01, "joint2.link_coulomb": 0.01,
    "joint1.motor_coulomb": 1.0, "joint2.motor_coulomb": 0.1,
}

SPRUNG = """
import sprung
experiment = sprung.Experiment("experiment.toml")
result = experiment.identify(log)
"""


def by_sprung(estimator):
    def identify(log):
        result = sprung.Experiment.demo({"identify.estimator": estimator}).identify(log, progress=False)
        return result.parameters.values_by_name()

    return identify


def by_numpy(log):
    sys.path.insert(0, str(PEERS))
    import identify_numpy as script

    columns = np.column_stack([log[name] for name in script.COLUMNS])
    period = columns[1, 0]
    x, dx = script.smooth(columns[:, 1:5], period)
    theta = script.solve(x, dx, columns[1:-1, 5:], period)
    return dict(zip(NOMINAL, theta))


def by_figaroh(log):
    import figaroh_rigid

    return figaroh_rigid.identify(log)


def by_mujoco(log):
    import mujoco_sysid

    return mujoco_sysid.identify(log, NOMINAL)


def lines(text):
    """Counts lines of code without blank lines, comments and docstrings."""
    tree = ast.parse(text)
    documented = [node for node in ast.walk(tree) if isinstance(node, ast.Module | ast.FunctionDef)]
    doc = {
        number
        for node in documented
        if ast.get_docstring(node) is not None
        for number in range(node.body[0].lineno, node.body[0].end_lineno + 1)
    }
    numbered = enumerate(text.splitlines(), 1)
    return sum(bool(line.strip()) and not line.strip().startswith("#") and k not in doc for k, line in numbered)


def main():
    warnings.simplefilter("ignore")
    experiment = sprung.Experiment.demo()
    log, truth = experiment.simulate(progress=False), experiment.truth()
    tools = [
        ("sprung, least squares", by_sprung("least-squares"), SPRUNG),
        ("sprung, refinement", by_sprung("prediction-error"), SPRUNG),
        ("NumPy script", by_numpy, (PEERS / "identify_numpy.py").read_text()),
        ("FIGAROH, rigid joints", by_figaroh, (HERE / "figaroh_rigid.py").read_text()),
        ("MuJoCo sysid", by_mujoco, (HERE / "mujoco_sysid.py").read_text()),
    ]
    if sys.argv[1:]:
        tools = [tool for tool in tools if any(word in tool[0] for word in sys.argv[1:])]
    print(f"{'tool':24}{'time, s':>9}{'given':>7}{'median error, %':>17}{'largest, %':>12}  {'of':24}{'lines':>6}")
    for name, identify, script in tools:
        begin = time.process_time()
        found = identify(log)
        seconds = time.process_time() - begin
        size = lines(script)
        errors = {key: 100 * abs(found[key] / value - 1) for key, value in truth.items() if key in found}
        worst = max(errors, key=errors.__getitem__)
        middle = float(np.median(list(errors.values())))
        text = f"{name}: {seconds:.3g} s, {len(errors)} parameters, largest error {errors[worst]:.3g} % (`{worst}`), {size} lines"
        note(name, text, middle, "%", better="lower" if name.startswith("sprung") else "none")
        print(f"{name:24}{seconds:9.2f}{len(errors):7}{middle:17.3f}{errors[worst]:12.2f}  {worst:24}{size:6}", flush=True)


if __name__ == "__main__":
    main()
