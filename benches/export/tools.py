"""Loads exported robots into Pinocchio, MuJoCo and Drake and compares them with known parameters.

    python tools.py SPRUNG FOLDER

Each robot gets random bodies, rotors, springs and friction, in a file of parameters.
`sprung export` writes all formats. The reference is Pinocchio with these bodies set
directly, and rotors, springs and viscous friction added by hand. The script prints a table
of relative differences and fails above the limits.
"""

import json
import logging
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as tree

import mujoco
import numpy as np
import pinocchio as pin
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

# Drake reports that it ignores dry friction, safety controllers and springs of URDF.
logging.getLogger("drake").setLevel(logging.ERROR)

INVERSE, FORWARD, TWIN_RAD = 1e-9, 1e-8, 1e-4
STATES = 50
BODY = ["m", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz"]


def robots_folder():
    """The robots of the package example-robot-data, which has no module."""
    for path in map(pathlib.Path, sys.path):
        found = path / "cmeel.prefix/share/example-robot-data/robots"
        if found.is_dir():
            return found
    raise SystemExit("there are no robots of example-robot-data")


class Robot:
    """A robot with random parameters: the reference."""

    def __init__(self, name, model, rigid, seed, head):
        # `model`: a Pinocchio model whose joints all belong to the robot, in its order.
        self.name, self.model, self.rigid, self.head = name, model, rigid, head
        self.n = model.nv
        self.joints = list(model.names)[1:]
        random = np.random.default_rng(seed)
        draw = lambda low, high: random.uniform(low, high, self.n)
        self.rotor, self.stiffness = draw(0.05, 0.5), draw(50.0, 5000.0)
        self.link_viscous, self.motor_viscous = draw(0.0, 0.5), draw(0.1, 3.0)
        self.link_coulomb, self.motor_coulomb = draw(0.0, 0.3), draw(0.1, 1.0)
        self.random = random
        for i in range(1, model.njoints):
            body = model.inertias[i]
            if body.mass < 1e-3:
                body = pin.Inertia.Random()
            factor = random.uniform(0.7, 1.3)
            vector = factor * body.toDynamicParameters()
            # A small ball keeps thin bodies possible.
            ball = pin.Inertia.FromSphere(0.05, 0.1).toDynamicParameters()
            model.inertias[i] = pin.Inertia.FromDynamicParameters(vector + ball)
        self.data = model.createData()

    def torques(self, q, dq, ddq, phi, dphi, ddphi, bearing_on_motor=False):
        """Torques on links and motors, both [n]; for rigid joints their sum on the links."""
        link = pin.rnea(self.model, self.data, q, dq, ddq)
        if self.rigid:
            viscous = self.motor_viscous
            return link + self.rotor * ddq + viscous * dq, None
        spring = self.stiffness * (phi - q)
        bearing = self.link_viscous * (dphi if bearing_on_motor else dq)
        motor = self.rotor * ddphi + self.motor_viscous * dphi + spring
        if bearing_on_motor:
            return link - spring, motor + bearing
        return link + bearing - spring, motor

    def accelerations(self, q, dq, phi, dphi, link_torque, motor_torque, bearing_on_motor=False):
        zero = np.zeros(self.n)
        link, motor = self.torques(q, dq, zero, phi, dphi, zero, bearing_on_motor)
        masses = pin.crba(self.model, self.data, q)
        masses = np.triu(masses) + np.triu(masses, 1).T
        if self.rigid:
            return np.linalg.solve(masses + np.diag(self.rotor), link_torque - link), None
        return (np.linalg.solve(masses, link_torque - link), (motor_torque - motor) / self.rotor)

    def write(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        text = self.head
        for joint in self.joints:
            text += f'[[robot.joint]]\nname = "{joint}"\n'
            if self.rigid:
                text += 'transmission = "rigid"\nmotor_friction = ["viscous", "coulomb"]\n'
        (folder / "experiment.toml").write_text(text)
        lines = []
        for i, (joint, link) in enumerate(zip(self.joints, self.links())):
            vector = self.model.inertias[i + 1].toDynamicParameters()
            # Pinocchio's order is that of sprung: m, first moments, ixx, ixy, iyy, ixz, iyz, izz.
            lines += [f'"{link}.{name}" = {value!r}' for name, value in zip(BODY, map(float, vector))]
            parameters = {
                "rotor_inertia": self.rotor,
                "motor_viscous": self.motor_viscous,
                "motor_coulomb": self.motor_coulomb,
            }
            if not self.rigid:
                parameters |= {
                    "stiffness": self.stiffness,
                    "link_viscous": self.link_viscous,
                    "link_coulomb": self.link_coulomb,
                }
            lines += [f'"{joint}.{name}" = {float(value[i])!r}' for name, value in parameters.items()]
        (folder / "parameters.toml").write_text("\n".join(lines) + "\n")

    def links(self):
        return self.link_names

    def state(self):
        r = self.random
        q = np.array([r.uniform(-1.0, 1.0) for _ in range(self.n)])
        dq, ddq = r.uniform(-2, 2, self.n), r.uniform(-10, 10, self.n)
        phi = q + r.uniform(-0.1, 0.1, self.n)
        return q, dq, ddq, phi, r.uniform(-2, 2, self.n), r.uniform(-10, 10, self.n)


def relative(found, known):
    found, known = np.concatenate(found), np.concatenate(known)
    return np.max(np.abs(found - known)) / np.max(np.abs(known))


def both(pair):
    return [part for part in pair if part is not None]


def in_pinocchio(robot, folder):
    """URDF: inverse dynamics of links and rotors; springs and friction are not part of the file."""
    model = pin.buildModelFromUrdf(str(folder / "robot.urdf"))
    locked = [
        model.getJointId(name)
        for name in list(model.names)[1:]
        if name not in robot.joints and name.removesuffix("_motor") not in robot.joints
    ]
    model = pin.buildReducedModel(model, locked, pin.neutral(model))
    if robot.gravity is not None:
        model.gravity.linear = np.array(robot.gravity)
    data = model.createData()
    worst = 0.0

    def place(model, vector, name, value):
        joint = model.joints[model.getJointId(name)]
        vector[joint.idx_v] = value

    for _ in range(STATES):
        q, dq, ddq, phi, dphi, ddphi = robot.state()
        full = [np.zeros(model.nv) for _ in range(3)]
        for i, joint in enumerate(robot.joints):
            for vector, link, motor in zip(full, (q, dq, ddq), (phi, dphi, ddphi)):
                place(model, vector, joint, link[i])
                if not robot.rigid:
                    place(model, vector, joint + "_motor", motor[i])
        configuration = pin.integrate(model, pin.neutral(model), full[0])
        found = pin.rnea(model, data, configuration, full[1], full[2])
        index = lambda name: model.joints[model.getJointId(name)].idx_v
        link = np.array([found[index(joint)] for joint in robot.joints])
        known = pin.rnea(robot.model, robot.data, q, dq, ddq)
        pairs = [(link, known)]
        if not robot.rigid:
            motor = np.array([found[index(joint + "_motor")] for joint in robot.joints])
            pairs.append((motor, robot.rotor * ddphi))
        for found, known in pairs:
            worst = max(worst, relative([found], [known]))
    return worst, None


def in_drake_urdf(robot, folder):
    """URDF: the mass matrix, with the rotors of rigid joints."""
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(folder / "robot.urdf"))
    children = {child for _, child in children_of(folder / "robot.urdf")}
    links = tree.parse(folder / "robot.urdf").getroot().findall("link")
    root = next(link.get("name") for link in links if link.get("name") not in children)
    if root != "world":
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(root))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    at = lambda name: plant.GetJointByName(name).velocity_start()
    link = [at(joint) for joint in robot.joints]
    worst = 0.0
    for _ in range(STATES):
        q = robot.state()[0]
        positions = plant.GetPositions(context)
        positions[link] = q
        plant.SetPositions(context, positions)
        found = plant.CalcMassMatrix(context)
        known = pin.crba(robot.model, robot.data, q)
        known = np.triu(known) + np.triu(known, 1).T
        if robot.rigid:
            known += np.diag(robot.rotor)
        else:
            motor = [at(joint + "_motor") for joint in robot.joints]
            worst = max(worst, relative([np.diag(found)[motor]], [robot.rotor]))
        worst = max(worst, relative([found[np.ix_(link, link)].ravel()], [known.ravel()]))
    return worst, None


def in_mujoco(robot, folder):
    model = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    data = mujoco.MjData(model)
    flags = mujoco.mjtDisableBit
    for flag in (flags.mjDSBL_FRICTIONLOSS, flags.mjDSBL_LIMIT, flags.mjDSBL_CONTACT):
        model.opt.disableflags |= flag
    at = lambda name: model.joint(name).dofadr[0]
    link = [at(joint) for joint in robot.joints]
    motor = None if robot.rigid else [at(joint + "_motor") for joint in robot.joints]
    inverse = forward = 0.0
    for _ in range(STATES):
        q, dq, ddq, phi, dphi, ddphi = robot.state()
        parts = [(data.qpos, q, phi), (data.qvel, dq, dphi), (data.qacc, ddq, ddphi)]
        for vector, of_link, of_motor in parts:
            vector[link] = of_link
            if motor:
                vector[motor] = of_motor
        mujoco.mj_inverse(model, data)
        found = [data.qfrc_inverse[link]] + ([data.qfrc_inverse[motor]] if motor else [])
        known = both(robot.torques(q, dq, ddq, phi, dphi, ddphi))
        inverse = max(inverse, relative(found, known))
        tau_link, tau_motor = robot.random.uniform(-5, 5, (2, robot.n))
        data.qfrc_applied[link] = tau_link
        if motor:
            data.qfrc_applied[motor] = tau_motor
        mujoco.mj_forward(model, data)
        found = [data.qacc[link]] + ([data.qacc[motor]] if motor else [])
        known = both(robot.accelerations(q, dq, phi, dphi, tau_link, tau_motor))
        forward = max(forward, relative(found, known))
        data.qfrc_applied[:] = 0.0
    return inverse, forward


def in_drake(robot, folder):
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(folder / "robot.sdf"))
    if robot.gravity is not None:
        plant.mutable_gravity_field().set_gravity_vector(np.array(robot.gravity))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    at = lambda name: plant.GetJointByName(name).velocity_start()
    if robot.rigid:
        link, spring = [at(joint) for joint in robot.joints], None
    else:
        link = [at(joint + "_motor") for joint in robot.joints]
        spring = [at(joint + "_spring") for joint in robot.joints]
    actuators = plant.num_actuators()
    assert actuators == robot.n, f"{actuators} actuators"
    plant.get_actuation_input_port().FixValue(context, np.zeros(actuators))
    inverse = forward = 0.0
    for _ in range(STATES):
        q, dq, ddq, phi, dphi, ddphi = robot.state()
        positions, velocities = np.zeros(plant.num_positions()), np.zeros(plant.num_velocities())
        for vector, of_link, of_motor in [(positions, q, phi), (velocities, dq, dphi)]:
            vector[link] = of_link if robot.rigid else of_motor
            if spring:
                vector[spring] = of_link - of_motor
        plant.SetPositions(context, positions)
        plant.SetVelocities(context, velocities)
        # Forces on actuated joints; the joints of springs have none.
        torque = robot.random.uniform(-5, 5, robot.n)
        actuation = np.zeros(actuators)
        for i, joint in enumerate(robot.joints):
            joint = plant.GetJointByName(joint if robot.rigid else joint + "_motor")
            actuator = plant.GetJointActuatorByName(joint.name())
            actuation[int(actuator.input_start())] = torque[i]
        plant.get_actuation_input_port().FixValue(context, actuation)
        rates = plant.EvalTimeDerivatives(context).CopyToVector()[plant.num_positions():]
        zero = np.zeros(robot.n)
        if robot.rigid:
            known, _ = robot.accelerations(q, dq, phi, dphi, torque, None)
            forward = max(forward, relative([rates[link]], [known]))
        else:
            of_link, of_motor = robot.accelerations(q, dq, phi, dphi, zero, torque, True)
            found = [rates[link] + rates[spring], rates[link]]
            forward = max(forward, relative(found, [of_link, of_motor]))
        # Inverse dynamics: the rest after damping and forces of springs and gravity.
        masses = plant.CalcMassMatrix(context)
        accelerations = np.zeros(plant.num_velocities())
        accelerations[link] = ddq if robot.rigid else ddphi
        if spring:
            accelerations[spring] = ddq - ddphi
        applied = np.zeros(plant.num_velocities())
        applied[link] = torque
        found = masses @ (accelerations - rates) + applied
        known_link, known_motor = robot.torques(q, dq, ddq, phi, dphi, ddphi, bool(spring))
        if spring:
            pairs = [found[link] - found[spring], found[spring]], [known_motor, known_link]
        else:
            pairs = [found[link]], [known_link]
        inverse = max(inverse, relative(*pairs))
    return inverse, forward


def in_json(robot, folder):
    """JSON: inverse dynamics from all numbers, read as training code reads them."""
    text = json.loads((folder / "robot.json").read_text())
    model = pin.Model()
    model.gravity.linear = np.array(text["gravity_m_per_s2"])
    joints = text["joints"]
    for joint in joints:
        link, axis = joint["link"], np.array(joint["axis"])
        inertia = link["inertia_about_center_kgm2"]
        matrix = np.array([
            [inertia["ixx"], inertia["ixy"], inertia["ixz"]],
            [inertia["ixy"], inertia["iyy"], inertia["iyz"]],
            [inertia["ixz"], inertia["iyz"], inertia["izz"]],
        ])
        turns = joint["kind"] == "revolute"
        kind = pin.JointModelRevoluteUnaligned(axis) if turns else pin.JointModelPrismaticUnaligned(axis)
        place = pin.SE3(np.array(joint["rotation"]), np.array(joint["origin_m"]))
        parent = 0 if joint["parent"] is None else model.getJointId(joint["parent"])
        index = model.addJoint(parent, kind, place, joint["name"])
        body = pin.Inertia(link["mass_kg"], np.array(link["center_of_mass_m"]), matrix)
        model.appendBodyToJoint(index, body, pin.SE3.Identity())
    data = model.createData()

    def values(part, start):
        found = [next((v for k, v in joint[part].items() if k.startswith(start)), None) for joint in joints]
        return np.array([entry["value"] if entry else 0.0 for entry in found])

    of = lambda start: values("actuator", start)
    worst = 0.0
    for _ in range(STATES):
        q, dq, ddq, phi, dphi, ddphi = robot.state()
        link = pin.rnea(model, data, q, dq, ddq)
        if robot.rigid:
            found = [link + of("reflected_inertia") * ddq + of("motor_viscous") * dq]
        else:
            spring = of("stiffness") * (phi - q) + of("spring_damping") * (dphi - dq)
            motor = of("reflected_inertia") * ddphi + of("motor_viscous") * dphi
            found = [link + of("link_viscous") * dq - spring, motor + spring]
        worst = max(worst, relative(found, both(robot.torques(q, dq, ddq, phi, dphi, ddphi))))
    pairs = [(of("motor_coulomb"), robot.motor_coulomb), (values("mjcf_rigid", "armature"), robot.rotor)]
    viscous, coulomb = robot.motor_viscous, robot.motor_coulomb
    if not robot.rigid:
        pairs.append((of("link_coulomb"), robot.link_coulomb))
        viscous, coulomb = viscous + robot.link_viscous, coulomb + robot.link_coulomb
    pairs += [(values("mjcf_rigid", "damping"), viscous), (values("mjcf_rigid", "frictionloss"), coulomb)]
    for found, known in pairs:
        worst = max(worst, relative([found], [known]))
    return worst, None


def dh_of(model_joints):
    """A Pinocchio model from placements and axes."""
    model = pin.Model()
    parent = 0
    for name, joint, placement in model_joints:
        parent = model.addJoint(parent, joint, placement, name)
        model.appendBodyToJoint(parent, pin.Inertia.FromSphere(2.0, 0.2), pin.SE3.Identity())
    return model


def robots():
    folder = robots_folder()
    made = []
    for name, file, joints, rigid in [
        ("panda", "panda_description/urdf/panda.urdf", [f"panda_joint{i}" for i in range(1, 8)], False),
        ("panda-rigid", "panda_description/urdf/panda.urdf", [f"panda_joint{i}" for i in range(1, 8)], True),
        ("ur5", "ur_description/urdf/ur5_robot.urdf", None, False),
    ]:
        path = folder / file
        full = pin.buildModelFromUrdf(str(path))
        names = joints or list(full.names)[1:]
        locked = [full.getJointId(joint) for joint in list(full.names)[1:] if joint not in names]
        model = pin.buildReducedModel(full, locked, pin.neutral(full))
        head = f'format = 1\n[robot]\nname = "{name}"\nurdf = "{path}"\n'
        robot = Robot(name, model, rigid, len(made), head)
        children = {joint: child for joint, child in children_of(path)}
        robot.link_names = [children[joint] for joint in robot.joints]
        robot.gravity = None
        made.append(robot)
    table = 'dh_modified = [{ theta_deg = 20.0 }, { a_m = 0.343 }]\n'
    turn = pin.SE3(pin.rpy.rpyToMatrix(0, 0, np.radians(20)), np.zeros(3))
    planar = dh_of([
        ("joint1", pin.JointModelRZ(), turn),
        ("joint2", pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([0.343, 0, 0]))),
    ])
    robot = Robot("planar", planar, False, 7, f'format = 1\n[robot]\nname = "planar"\n{table}')
    robot.link_names, robot.gravity = ["link1", "link2"], None
    made.append(robot)
    emps = dh_of([("carriage", pin.JointModelPZ(), pin.SE3.Identity())])
    emps.gravity.linear = np.array([0.0, -9.81, 0.0])
    head = (
        'format = 1\n[robot]\nname = "emps"\ndh_modified = [{ prismatic = true }]\n'
        "gravity_m_per_s2 = [0.0, -9.81, 0.0]\n"
    )
    robot = Robot("emps", emps, True, 8, head)
    robot.link_names, robot.gravity = ["link1"], [0.0, -9.81, 0.0]
    made.append(robot)
    return made


def children_of(path):
    for joint in tree.parse(path).getroot().findall("joint"):
        yield joint.get("name"), joint.find("child").get("link")


def twin_in_mujoco(sprung, folder, coulomb):
    """One second of the demo's twin, and the same torques on the exported robot."""
    demo = folder / "demo"
    if not (demo / "truth.toml").exists():
        subprocess.run([sprung, "demo", "--quiet", "--out", demo], check=True)
    twin = folder / ("dry" if coulomb else "viscous")
    twin.mkdir(exist_ok=True)
    (twin / "identification.csv").unlink(missing_ok=True)
    lines = (demo / "truth.toml").read_text().splitlines()
    lines = [line for line in lines if coulomb or "coulomb" not in line]
    if not coulomb:
        lines += [f'"joint{i}.{side}_coulomb" = 0.0' for i in (1, 2) for side in ("link", "motor")]
    parameters = twin / "parameters.toml"
    parameters.write_text("\n".join(lines) + "\n")
    text = (demo / "experiment.toml").read_text()
    (twin / "experiment.toml").write_text(text)
    exact = [
        "simulate.duration_s=1.0",
        "simulate.link_encoder_counts_per_turn=[0, 0]",
        "simulate.motor_encoder_counts_per_turn=[0, 0]",
        "simulate.torque_noise_nm=[0.0, 0.0]",
    ]
    sets = [word for line in exact for word in ("--set", line)]
    subprocess.run([sprung, "simulate", twin, "--quiet", "--parameters", parameters, "--out", twin, *sets], check=True)
    subprocess.run(
        [sprung, "export", twin, "--quiet", "--parameters", parameters, "--format", "mjcf", "--out", twin, "--force"],
        check=True,
    )
    log = np.genfromtxt(twin / "identification.csv", delimiter=",", names=True)
    model = mujoco.MjModel.from_xml_path(str(twin / "robot.xml"))
    data = mujoco.MjData(model)
    steps = 100
    model.opt.timestep = 1e-3 / steps
    if not coulomb:
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    columns = ["q1_rad", "q2_rad", "phi1_rad", "phi2_rad"]
    joints = ["joint1", "joint2", "joint1_motor", "joint2_motor"]
    at = [model.joint(joint).qposadr[0] for joint in joints]
    data.qpos[at] = [log[column][0] for column in columns]
    worst = 0.0
    for k in range(len(log) - 1):
        data.ctrl[:] = [log["tau1_nm"][k], log["tau2_nm"][k]]
        for _ in range(steps):
            mujoco.mj_step(model, data)
        known = np.array([log[column][k + 1] for column in columns])
        worst = max(worst, np.max(np.abs(data.qpos[at] - known)))
    return worst


def main():
    sprung, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    failed = False
    print(f"{'robot':12} {'tool':22} {'inverse':>10} {'forward':>10}")
    for robot in robots():
        robot_folder = folder / robot.name
        robot.write(robot_folder)
        for name in ["urdf", "mjcf", "sdf", "json"]:
            subprocess.run(
                [sprung, "export", robot_folder, "--quiet", "--format", name, "--out", robot_folder, "--force",
                 "--parameters", robot_folder / "parameters.toml"],
                check=True,
            )
        for tool, check in [
            ("Pinocchio, URDF", in_pinocchio),
            ("Drake, URDF (masses)", in_drake_urdf),
            ("MuJoCo, MJCF", in_mujoco),
            ("Drake, SDF", in_drake),
            ("Python, JSON", in_json),
        ]:
            inverse, forward = check(robot, robot_folder)
            shown = "-" if forward is None else f"{forward:.1e}"
            wrong = not inverse <= INVERSE or forward is not None and not forward <= FORWARD
            print(f"{robot.name:12} {tool:22} {inverse:10.1e} {shown:>10}{'  FAILED' if wrong else ''}")
            failed |= wrong
    for coulomb in (False, True):
        worst = twin_in_mujoco(sprung, folder, coulomb)
        wrong = not coulomb and not worst <= TWIN_RAD
        what = "with Coulomb friction" if coulomb else "with viscous friction only"
        print(f"one second of the demo in MuJoCo {what}: {worst:.1e} rad{'  FAILED' if wrong else ''}")
        failed |= wrong
    sys.exit(failed)


if __name__ == "__main__":
    main()
