"""sprung: writes an experiment file and reads identification.json. `SPRUNG` names the program."""
import json, os, subprocess, sys
from pathlib import Path

folder, out = Path(sys.argv[1]), Path(sys.argv[2])
task = json.loads((folder / "task.json").read_text())
joints, columns = task["joints"], task["columns"]
lines = ["format = 1", "[robot]", 'urdf = "robot.urdf"', f"gravity_m_per_s2 = {task['gravity']}"]
for i, joint in enumerate(joints, 1):
    lines += ["[[robot.joint]]", f'name = "joint{i}"', f"coulomb_sharpness_s_per_rad = {task['sharpness_s_per_rad']:.1f}"]
    lines += ['transmission = "rigid"', 'motor_friction = ["viscous", "coulomb", "offset"]'] if joint.get("rigid") else ['transmission = "flexible"']
unit = ("m", "force_n") if joints[0].get("prismatic") else ("rad", "torque_nm")
names = lambda kind: json.dumps([name for name in columns if name.startswith(kind)])
lines += ["[log]", 'file = "train.csv"', 'time_s = "t"', f"motor_{unit[1]} = {names('tau')}"]
lines += [f"motor_position_{unit[0]} = {names('phi')}"]
if names("q") != "[]":
    lines.append(f"link_position_{unit[0]} = {names('q')}")
if any(joint.get("rigid") for joint in joints):             # the default of rigid robots; the file has no further laws for these
    lines += ["[identify]", 'estimator = "least-squares"', 'laws = "declared"']
experiment = folder / "sprung.toml"
experiment.write_text("\n".join(lines) + "\n")
results = folder / "sprung-out"
subprocess.run([os.environ.get("SPRUNG", "sprung"), "identify", experiment, "--out", results, "--quiet"], stdout=subprocess.DEVNULL)
result = json.loads((results / "identification.json").read_text())["results"][0]
own = {p["name"]: [p["value"], p.get("standard_error")] for p in result["parameters"] if p.get("value") is not None}
standard = {p["name"]: [p["value"], p.get("standard_error")] for p in result["standard_parameters"] if p["value"] is not None}
keys = ["stiffness", "rotor_inertia", "motor_viscous", "motor_coulomb", "link_viscous", "link_coulomb", "motor_offset"]
wanted = [f"joint{i}.{key}" for i in range(1, len(joints) + 1) for key in keys]
values = {name: (own | {k: v for k, v in standard.items() if k not in own})[name] for name in wanted if name in own or name in standard}
for i in range(1, len(joints) + 1):
    if f"joint{i}.motor_load" in own:                       # its coefficient times the stiffness
        values[f"joint{i}.load_friction"] = [own[f"joint{i}.motor_load"][0] / own[f"joint{i}.stiffness"][0], None]
    if width := result.get("hysteresis_width", {}).get(f"joint{i}"):  # elements by the share of the widest one's width
        elements = enumerate([0.015, 0.04, 0.1, 0.25, 0.5, 1.0], 1)
        stiff = sum(own[f"joint{i}.spring_hysteresis_{k}"][0] / (share * width) for k, share in elements)
        values[f"joint{i}.hysteresis"] = [stiff / own[f"joint{i}.stiffness"][0], None]
body = ["m", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz"]
bodies = {f"link{i}": [standard[f"link{i}.{key}"][0] for key in body] for i in range(1, len(joints) + 1)}
out.write_text(json.dumps({"tool": "sprung", "verdict": result["verdict"], "parameters": values, "bodies": bodies}))
