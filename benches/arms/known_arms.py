"""A hundred logs of known arms: `sprung new --urdf --log`, then `sprung identify`, without an edit.

    python known_arms.py SPRUNG FOLDER [CASE ...]

The URDFs are those of the package example-robot-data 6.0.0 (BSD-3-Clause; the panda Apache-2.0). `sprung simulate` makes a log of each arm with flexible joints, and one
with rigid joints; a script writes them as the recorders of such robots do:

- units: degrees, with and without a unit in the names, and counts of encoders
- motor: positions and torques of the motors before the gearbox
- rigid: no link encoder
- extra: velocities, commands, currents, temperatures and a counter beside the columns
- german: German names with units, degrees, decimal commas
- gripper: messages whose first names are those of a gripper that moves

The first four kinds change between CSV, Parquet, MCAP and MATLAB, the last two are CSV and MCAP.

Ten recorders write the logs of four of the arms in other shapes (`RECORDERS`): two files, a row of units, blocks without
names, JSON, slow clocks, torque sensors, commands, counters.

A case is wrong if the verdict is good and the torque of a parameter is more than 5 % of its row's off, and more than its
interval says: three standard errors.
"""

import json
import math
import os
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from concurrent.futures import ThreadPoolExecutor

import numpy as np

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from figure import note  # noqa: E402

ROBOTS = pathlib.Path(sys.prefix)
PERIOD, DURATION = 0.002, 12.0
WRONG = 0.05
SURE = 3.0

# Name, URDF, joints of the log, and names of their columns.
ARMS = [
    ("ur3", "ur_description/urdf/ur3_robot.urdf",
     ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"], "short"),
    ("ur5", "ur_description/urdf/ur5_robot.urdf",
     ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint",
      "wrist_2_joint", "wrist_3_joint"], "from_0"),
    ("ur10", "ur_description/urdf/ur10_robot.urdf",
     ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"], "long"),
    ("panda", "panda_description/urdf/panda.urdf",
     [f"panda_joint{k}" for k in (1, 2, 3, 4)], "number"),
    ("kinova", "kinova_description/robots/kinova.urdf",
     [f"j2s6s200_joint_{k}" for k in (1, 2, 3)], "number"),
    ("xarm7", "xarm_description/urdf/xarm7.urdf", ["joint1", "joint2", "joint4"], "long"),
    ("z1", "z1_description/urdf/z1.urdf", [f"joint{k}" for k in range(1, 7)], "from_0"),
    ("tiago", "tiago_description/robots/tiago_no_hand.urdf",
     [f"arm_{k}_joint" for k in (1, 2, 3, 4)], "short"),
    ("talos", "talos_data/robots/talos_left_arm.urdf",
     [f"arm_left_{k}_joint" for k in (2, 3, 4)], "number"),
    ("baxter", "baxter_description/urdf/baxter.urdf",
     ["left_s0", "left_s1", "left_e0", "left_e1"], "long"),
]
KINDS = ["units", "motor", "rigid", "extra"]
FORMATS = ["csv", "parquet", "mcap", "mat"]
FURTHER = {"german": "csv", "gripper": "mcap"}
LEAST_IDENTIFIED = 55
# Of the logs of recorders, those that are identified or refused with the one line that lacks. Blocks do not say which of
# more joints of a URDF they are.
LEAST_RECORDED = 36
GERMAN = {(False, "pos"): "Gelenkposition", (True, "pos"): "Motorposition", (False, "torque"): "Motormoment"}
GEARS = [100, 101, 50, 100, 136, 100, 121, 345, 100, 60.5]


class Arm:
    """A URDF and the twin of its joints."""

    def __init__(self, name, urdf, joints, style):
        found = sorted(ROBOTS.rglob(urdf))
        if not found:
            sys.exit(f"{urdf} is not installed: pip install example-robot-data==6.0.0")
        self.name, self.urdf, self.style = name, found[0], style
        root = ElementTree.parse(self.urdf).getroot()
        every = {joint.get("name"): joint for joint in root.findall("joint")}
        # As in sprung: parents before children.
        depth = lambda name: len(list(self.above(every, name)))
        self.joints = sorted(joints, key=depth)
        moves = lambda name: every[name].get("type") in ("revolute", "prismatic", "continuous")
        fingers = [name for name in every if ("finger" in name or "gripper" in name) and moves(name)]
        self.fingers = sorted(fingers)[:2] or ["gripper_finger_joint"]
        self.limits = [self.limit(every[name]) for name in self.joints]
        self.sizes = [self.size(root, every, name) for name in self.joints]

    @staticmethod
    def above(every, name):
        parent = every[name].find("parent").get("link")
        for other, joint in every.items():
            if joint.find("child").get("link") == parent:
                yield other
                yield from Arm.above(every, other)

    @staticmethod
    def limit(joint):
        limit = joint.find("limit")
        if joint.get("type") == "continuous" or limit is None:
            return -math.pi, math.pi
        return float(limit.get("lower")), float(limit.get("upper"))

    @staticmethod
    def size(root, every, name):
        """Mass beyond a joint, and a length of it."""
        links = {link.get("name"): link for link in root.findall("link")}
        mass, moment, todo = 0.0, 0.0, [(every[name].find("child").get("link"), 0.0)]
        while todo:
            link, reach = todo.pop()
            inertial = links[link].find("inertial")
            if inertial is not None:
                link_mass = float(inertial.find("mass").get("value"))
                origin = inertial.find("origin")
                offset = 0.0
                if origin is not None:
                    xyz = [float(x) for x in origin.get("xyz", "0 0 0").split()]
                    offset = math.hypot(*xyz)
                mass += link_mass
                moment += link_mass * (reach + offset)
            for joint in every.values():
                if joint.find("parent").get("link") == link:
                    origin = joint.find("origin")
                    xyz = [0.0] if origin is None else [
                        float(x) for x in origin.get("xyz", "0 0 0").split()]
                    todo.append((joint.find("child").get("link"), reach + math.hypot(*xyz)))
        return mass, max(moment / mass, 0.02)

    def twin(self, rigid):
        """The experiment of the twin."""
        count = range(len(self.joints))
        lines = ["format = 1", "[robot]", f'name = "{self.name}"', f'urdf = "{self.urdf}"']
        gains, noise, centre, sines = [], [], [], []
        for k, (name, (mass, length)) in enumerate(zip(self.joints, self.sizes)):
            inertia, weight = mass * length**2, 9.81 * mass * length
            rotor = 0.5 * inertia + 1e-3
            stiffness = inertia * (2 * math.pi * 9.0) ** 2 + 10.0 * weight
            nominal = {"rotor_inertia": rotor, "motor_viscous": 0.3 * weight,
                       "motor_coulomb": 0.1 * weight}
            if not rigid:
                nominal |= {"stiffness": stiffness, "link_viscous": 0.03 * weight,
                            "link_coulomb": 0.02 * weight}
            values = ", ".join(f"{key} = {value:.5g}" for key, value in nominal.items())
            lines += ["[[robot.joint]]", f'name = "{name}"',
                      f'transmission = "{"rigid" if rigid else "flexible"}"',
                      f"nominal = {{ {values} }}"]
            whole = rotor + inertia
            gains.append((whole * (2 * math.pi * 2.5) ** 2 + 4 * weight,
                          1.2 * whole * 2 * math.pi * 2.5))
            noise.append(2e-3 * weight)
            lower, upper = (math.degrees(limit) for limit in self.limits[k])
            middle = min(max(0.0, lower + 40.0), upper - 40.0)
            centre.append(middle if upper - lower > 80.0 else (lower + upper) / 2)
            for amplitude, frequency in [(22.0, 0.21 + 0.05 * k), (8.0, 0.83 + 0.11 * k),
                                         (1.5, 2.3 + 0.3 * k)]:
                sines.append(f'{{ joint = "{name}", amplitude_deg = {amplitude}, '
                             f"frequency_hz = {frequency:.2f} }}")
        numbers = lambda values: "[" + ", ".join(f"{float(value):.5g}" for value in values) + "]"
        names = lambda stem: json.dumps([f"{stem}{k}" for k in count])
        lines += ["[log]", 'file = "twin.csv"', 'time_s = "t"']
        if not rigid:
            lines.append(f"link_position_rad = {names('q')}")
        lines += [f"motor_position_rad = {names('phi')}", f"motor_torque_nm = {names('tau')}",
                  "[controller]", 'kind = "pd"',
                  f"kp_nm_per_rad = {numbers(gain for gain, _ in gains)}",
                  f"kd_nms_per_rad = {numbers(gain for _, gain in gains)}",
                  "[controller.reference]", f"centre_deg = {numbers(centre)}",
                  "sines = [", ",\n".join(sines), "]",
                  "[simulate]", f"duration_s = {DURATION}", f"period_s = {PERIOD}", "seed = 3",
                  f"motor_encoder_counts_per_turn = {numbers([262144] * len(self.joints))}",
                  f"torque_noise_nm = {numbers(noise)}"]
        if not rigid:
            lines.append(
                f"link_encoder_counts_per_turn = {numbers([262144] * len(self.joints))}")
        return "\n".join(lines).replace("262144.0", "262144").replace("2.6214e+05", "262144")

    def column(self, k, motor, what, unit):
        """Name of a column in a table."""
        joint = self.joints[k]
        unit = f"_{unit}" if unit else ""
        if self.style == "number":
            number = [c for c in joint if c.isdigit()][-1]
            stem = {"pos": "phi" if motor else "q", "torque": "tau", "vel": "dq",
                    "cmd": "q_cmd_", "current": "i", "temp": "temp"}[what]
            return f"{stem}{number}{unit}"
        if self.style == "from_0":
            stem = {"pos": "motor_q" if motor else "actual_q", "torque": "actual_torque",
                    "vel": "actual_qd", "cmd": "target_q", "current": "actual_current",
                    "temp": "joint_temperatures"}[what]
            return f"{stem}{unit}_{k}"
        if self.style == "short":
            joint = joint.removesuffix("_joint")
        side = "motor_" if motor else ""
        return f"{joint}_{side}{what}{unit}"


def run(program, arguments, folder):
    result = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True)
    return result.returncode, result.stdout, result.stderr


def simulated(program, arm, folder, rigid):
    """The log of the twin, and the true values of the parameters by name."""
    twin_folder = folder / "twins" / ("rigid" if rigid else "flexible") / arm.name
    twin_folder.mkdir(parents=True, exist_ok=True)
    (twin_folder / "twin.toml").write_text(arm.twin(rigid))
    code, _, error = run(program, ["simulate", "twin.toml", "--out", "log"], twin_folder)
    if code != 0:
        sys.exit(f"{arm.name}: {error}")
    least = "identify.estimator=[\"least-squares\"]"
    code, _, error = run(program, ["identify", "twin.toml", "--quiet", "--set", least, "--out", "found",
                                    "--set", "log.file=log/twin.csv"], twin_folder)
    if code not in (0, 1):
        sys.exit(f"{arm.name}: {error}")
    result = json.loads((twin_folder / "found/identification.json").read_text())
    truth = {parameter["name"]: parameter.get("nominal") for parameter in result["results"][0]["parameters"]}
    table = np.genfromtxt(twin_folder / "log/twin.csv", delimiter=",", names=True)
    count = len(arm.joints)
    signal = lambda stem: np.column_stack([table[f"{stem}{k}"] for k in range(count)])
    log = {"t": table["t"], "phi": signal("phi"), "tau": signal("tau")}
    if not rigid:
        log["q"] = signal("q")
    return log, truth


def recorded(arm, index, kind, log):
    """Columns as a recorder writes them: time, and (motor, what, unit, values) of the joints."""
    log = dict(log)
    columns, gear = [], GEARS[index]
    link_unit = motor_unit = torque_unit = ""
    if kind == "german":
        log["q"], log["phi"] = np.degrees(log["q"]), np.degrees(log["phi"])
        link_unit, motor_unit, torque_unit = "Grad", "Grad", "Nm"
    elif kind == "units" and index < 6:
        log["q"], log["phi"] = np.degrees(log["q"]), np.degrees(log["phi"])
        link_unit = motor_unit = "deg" if index < 3 else ""
    elif kind == "units":
        log["phi"] = np.round(log["phi"] / (2 * math.pi) * 4096 * gear)
        motor_unit = "counts" if index % 2 else ""
        if index >= 8:
            log["q"] = np.round(log["q"] / (2 * math.pi) * 65536)
    elif kind == "motor":
        log["phi"], log["tau"] = log["phi"] * gear, log["tau"] / gear
        motor_unit = "rad" if index % 2 else ""
    else:
        link_unit = motor_unit = "rad" if index % 2 else ""
        torque_unit = "nm" if index % 2 else ""
    if "q" in log:
        columns.append((False, "pos", link_unit, log["q"]))
    columns.append((kind != "rigid", "pos", motor_unit, log["phi"]))
    columns.append((False, "torque", torque_unit, log["tau"]))
    if kind == "extra":
        rate = np.gradient(log["q"], PERIOD, axis=0)
        noise = np.random.default_rng(7).normal(size=log["q"].shape)
        columns += [(False, "vel", "", rate), (False, "cmd", "", log["phi"] + 0.01),
                    (False, "current", "", log["tau"] / 8.0 + 0.01 * noise),
                    (False, "temp", "", 40.0 + 0.1 * np.round(noise))]
    return log["t"], columns


def table_of(arm, time, columns, extra):
    names = {("timestamp" if extra else "time_s"): time}
    if extra:
        names["sample"] = np.arange(len(time))
    for motor, what, unit, values in columns:
        for k in range(values.shape[1]):
            names[arm.column(k, motor, what, unit)] = values[:, k]
    return names


def german(path, arm, time, columns):
    texts = {"Zeit [s]": time}
    for motor, what, unit, values in columns:
        for k in range(values.shape[1]):
            texts[f"{GERMAN[motor, what]} {arm.joints[k]} [{unit}]"] = values[:, k]
    with open(path, "w") as file:
        file.write(";".join(texts) + "\n")
        for row in zip(*texts.values()):
            file.write(";".join(f"{x:.10g}" for x in row).replace(".", ",") + "\n")


def write(path, arm, kind, time, columns):
    form = path.suffix[1:]
    if kind == "german":
        german(path, arm, time, columns)
        return
    names = table_of(arm, time, columns, kind == "extra")
    if form == "csv":
        texts = {name: [f"{x:.10g}" for x in values] for name, values in names.items()}
        if kind == "extra":
            texts["status"] = ["RUNNING"] * len(time)
        with open(path, "w") as file:
            file.write(",".join(texts) + "\n")
            file.writelines(",".join(row) + "\n" for row in zip(*texts.values()))
    elif form == "parquet":
        import pyarrow
        import pyarrow.parquet
        if kind == "rigid":
            lists = {"timestamp": pyarrow.array((time * 1e9).astype("int64"),
                                                pyarrow.timestamp("ns")),
                     "name": [arm.joints] * len(time)}
            for _, what, _, values in columns:
                lists[{"pos": "position", "torque": "effort"}[what]] = values.tolist()
            pyarrow.parquet.write_table(pyarrow.table(lists), path)
        else:
            pyarrow.parquet.write_table(pyarrow.table(names), path)
    elif form == "mat":
        import scipy.io
        scipy.io.savemat(path, {name.replace(" ", "_"): np.asarray(values)
                                for name, values in names.items()}, long_field_names=True)
    else:
        bag(path, arm, time, columns, kind == "gripper")


def bag(path, arm, time, columns, with_gripper):
    from mcap_ros2.writer import Writer
    header = "std_msgs/Header header\n"
    inner = ("=" * 80 + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\n"
             "string frame_id\n" + "=" * 80 + "\nMSG: builtin_interfaces/Time\n"
             "int32 sec\nuint32 nanosec\n")
    state = header + "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    by = {(motor, what): values for motor, what, _, values in columns}
    links, motors = by.get((False, "pos")), by.get((True, "pos"))
    fingers = arm.fingers if with_gripper else []
    opening = 0.02 + 0.01 * np.sin(3.0 * time)
    with open(path, "wb") as file:
        writer = Writer(file)
        joint_state = writer.register_msgdef("sensor_msgs/msg/JointState", state + inner)
        numbers = writer.register_msgdef("std_msgs/msg/Float64MultiArray", "float64[] data\n")
        for k, t in enumerate(time):
            stamp = int(round((1000.0 + t) * 1e9))
            clock = {"sec": stamp // 10**9, "nanosec": stamp % 10**9}

            def send(topic, position, velocity=None, effort=None):
                extra_joints = fingers if topic == "/joint_states" else []
                extra = [float(opening[k])] * len(extra_joints)
                with_extra = lambda values: [] if values is None else extra + values[k].tolist()
                message = {"header": {"stamp": clock, "frame_id": ""}, "name": extra_joints + arm.joints,
                           "position": with_extra(position), "velocity": with_extra(velocity),
                           "effort": with_extra(effort)}
                writer.write_message(topic, joint_state, message, stamp, stamp)

            torque = by[False, "torque"]
            if motors is None:
                send("/joint_states", links, effort=torque)
            else:
                send("/joint_states", links, by.get((False, "vel")))
                send("/motor_states", motors, effort=torque)
            if (False, "cmd") in by:
                send("/joint_commands", by[False, "cmd"])
                writer.write_message("/temperatures", numbers,
                                     {"data": by[False, "temp"][k].tolist()}, stamp, stamp)
        writer.finish()


def csv_text(names, header=True, units=None):
    rows = [",".join(f"{x:.10g}" for x in row) for row in zip(*names.values())]
    return "\n".join([",".join(names)] * header + ([",".join(units)] if units else []) + rows) + "\n"


def of_joints(arm, name, values):
    """Columns of all joints; `*` in the name stands for the joint."""
    return {name.replace("*", joint): values[:, k] for k, joint in enumerate(arm.joints)}


# Each recorder takes the log of a twin and returns its files by name.
RECORDERS = {
    "two files": (False, lambda arm, log, of: {
        "positions.csv": csv_text({"time": log["t"], **of("*_pos", "q"), **of("*_motor_pos", "phi")}),
        "efforts.csv": csv_text({"time": log["t"], **of("*_torque", "tau")})}),
    "file names": (False, lambda arm, log, of: {
        f"{name}.csv": csv_text({"t": log["t"], **of("*", key)})
        for name, key in (("link_position", "q"), ("motor_position", "phi"), ("motor_torque", "tau"))}),
    "units row": (False, lambda arm, log, of: {
        "log.csv": csv_text({"clock": log["t"], **of("*_enc", "q"), **of("*_motor_enc", "phi"), **of("*_torque", "tau")},
                            units=["s"] + ["rad"] * 2 * len(arm.joints) + ["N·m"] * len(arm.joints))}),
    "blocks": (True, lambda arm, log, of: {
        "log.csv": csv_text({**of("a*", "phi"), **of("b*", "rate"), **of("c*", "tau")}, header=False)}),
    "json samples": (False, lambda arm, log, of: {
        "log.json": json.dumps([{"t": t, "q": q, "motor_q": phi, "tau": tau} for t, q, phi, tau in zip(
            *(log[key].tolist() for key in ("t", "q", "phi", "tau")))])}),
    "json columns": (False, lambda arm, log, of: {
        "log.json": json.dumps({name: values.tolist() for name, values in
                                {"t": log["t"], **of("*_pos", "q"), **of("*_motor_pos", "phi"), **of("*_torque", "tau")}.items()})}),
    "slow": (True, lambda arm, log, of: {
        "log.csv": csv_text({name: values[::10] for name, values in
                             {"time": log["t"], **of("*_pos", "phi"), **of("*_torque", "tau")}.items()})}),
    "sensor": (False, lambda arm, log, of: {
        "log.csv": csv_text({"time": log["t"], **of("*_pos", "q"), **of("*_motor_pos", "phi"), **of("*_motor_torque", "tau"),
                             **of("*_torque_sensor", "spring")})}),
    "commands": (True, lambda arm, log, of: {
        "log.csv": csv_text({"time": log["t"], **of("*_PositionCmded", "command"), **of("*_Position", "phi"),
                             **of("*_TorqueRef", "command"), **of("*_Torque", "tau")})}),
    "counter": (True, lambda arm, log, of: {
        "log.csv": csv_text({"ID": np.arange(len(log["t"])), **of("*_pos", "phi"), **of("*_vel", "rate"),
                             **of("*_torque", "tau")})}),
}
RECORDED = ["ur3", "ur5", "panda", "xarm7"]


def write_recorded(arm, recorder, log, stiffness, folder):
    """Writes the files of a recorder; returns their names."""
    log = dict(log, rate=np.gradient(log["phi"], PERIOD, axis=0), command=np.roll(log["phi"], -7, axis=0))
    if "q" in log:
        log["spring"] = (log["phi"] - log["q"]) * stiffness
    files = RECORDERS[recorder][1](arm, log, lambda name, key: of_joints(arm, name, log[key]))
    for name, text in files.items():
        (folder / name).write_text(text)
    return list(files)


def judged(program, arm, logs, folder, truth):
    """Runs new and identify; returns outcome, largest error of a torque, and a remark."""
    arguments = ["new", "exp", "--urdf", str(arm.urdf), "--quiet"]
    arguments += [word for log in logs for word in ("--log", log)]
    code, _, error = run(program, arguments, folder)
    if code != 0:
        return "refused by new", None, error.strip().splitlines()[0]
    least = "identify.estimator=[\"least-squares\"]"
    code, _, error = run(program, ["identify", "exp", "--quiet", "--set", least], folder)
    if "FILL IN" in error:
        return "FILL IN", None, error.strip().splitlines()[0].split("FILL IN ")[-1][:60]
    if code not in (0, 1):
        return "error", None, error.strip().splitlines()[0][:140]
    text = (folder / "exp/sprung-out/identification.json").read_text()
    result = json.loads(text)["results"][0]
    worst, name, is_off = 0.0, "", False
    for parameter in result["parameters"]:
        true, value = truth.get(parameter["name"]), parameter["value"]
        if parameter["name"].endswith("joint_torque_offset"):
            continue
        if parameter["name"] not in truth:
            return "other parameters", None, parameter["name"]
        if true is None or parameter.get("torque_share") is None or value == 0.0:
            continue
        off = abs((value - true) / value) * parameter["torque_share"]
        is_off |= off > WRONG and abs(value - true) > SURE * (parameter["standard_error"] or 0.0)
        if off > worst:
            worst, name = off, parameter["name"]
    verdict = result["verdict"]
    if is_off:
        verdict += ", WRONG" if verdict == "good" else ", off"
    return verdict, worst, name


def cases(index, row, program, folder, wanted):
    """Judges the cases of an arm; returns case, kind, outcome, error and remark of each."""
    arm = Arm(*row)
    made, found = {}, []
    forms = [(kind, FORMATS[(index + place) % len(FORMATS)]) for place, kind in enumerate(KINDS)]
    for kind, form in forms + list(FURTHER.items()):
        case = f"{arm.name} {kind} {form}"
        if wanted and not any(part in case for part in wanted):
            continue
        rigid = kind == "rigid"
        if rigid not in made:
            made[rigid] = simulated(program, arm, folder, rigid)
        log, truth = made[rigid]
        case_folder = folder / kind / arm.name
        subprocess.run(["rm", "-rf", case_folder], check=True)
        case_folder.mkdir(parents=True)
        write(case_folder / f"log.{form}", arm, kind, *recorded(arm, index, kind, log))
        found.append((case, kind, *judged(program, arm, [f"log.{form}"], case_folder, truth)))
    for recorder, (rigid, _) in RECORDERS.items() if arm.name in RECORDED else ():
        case = f"{arm.name} {recorder}"
        if wanted and not any(part in case for part in wanted):
            continue
        if rigid not in made:
            made[rigid] = simulated(program, arm, folder, rigid)
        log, truth = made[rigid]
        case_folder = folder / recorder.replace(" ", "-") / arm.name
        subprocess.run(["rm", "-rf", case_folder], check=True)
        case_folder.mkdir(parents=True)
        stiffness = [truth.get(f"{joint}.stiffness") or 0.0 for joint in arm.joints]
        logs = write_recorded(arm, recorder, log, stiffness, case_folder)
        found.append((case, "recorder", *judged(program, arm, logs, case_folder, truth)))
    return found


def main():
    program, folder = str(pathlib.Path(sys.argv[1]).absolute()), pathlib.Path(sys.argv[2])
    wanted = sys.argv[3:]
    identified = refused = wrong = count = 0
    recorded = of_recorders = 0
    largest = {}
    print(f"{'case':22} {'result':18} {'error %':>8}  remark")
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        arms = [pool.submit(cases, index, row, program, folder, wanted) for index, row in enumerate(ARMS)]
        for case, kind, outcome, worst, remark in (found for arm in arms for found in arm.result()):
            error = "-" if worst is None else f"{100 * worst:.2f}"
            print(f"{case:22} {outcome:18} {error:>8}  {remark}", flush=True)
            if kind == "recorder":
                of_recorders += 1
                recorded += outcome in ("good", "doubtful", "FILL IN")
                wrong += "WRONG" in outcome
                continue
            count += 1
            if outcome == "good" and worst is not None:
                largest[kind] = max(worst, largest.get(kind, 0.0))
            identified += outcome in ("good", "doubtful")
            refused += outcome == "FILL IN"
            wrong += "WRONG" in outcome
    print(f"{identified} of {count} identified without an edit, {refused} refused with the line to "
          f"fill in, {wrong} wrong without a word; {recorded} of {of_recorders} of recorders identified or refused so")
    if not wanted:
        note("identified", f"{count} logs of ten arms: identified without an edit", identified, "", better="higher")
        note("refused", "refused, with the line to fill in", refused, "", better="none")
        note("wrong", "wrong without a word", wrong, "")
        for kind, error in sorted(largest.items()):
            note(f"error, {kind}", f"{kind}: largest error of the torque of a parameter", 100 * error, "%")
    if not wanted and (identified < LEAST_IDENTIFIED or identified + refused < count or wrong or recorded < LEAST_RECORDED):
        sys.exit(1)


if __name__ == "__main__":
    main()
