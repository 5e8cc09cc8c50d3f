"""Identifies the demo's robot with MuJoCo's system identification.

It changes the parameters until a simulation with the logged torques follows the logged positions. The model is
written by hand, because a joint of MuJoCo has one mass: rotors are separate bodies, springs are tendons.
"""

import contextlib
import io

import mujoco
import mujoco.sysid as sysid
import numpy as np

LENGTH, MASS1, MASS2 = 0.343, 1.0, 0.5
NAMES = [
    "link1.inertia_total", "link2.coupling", "link2.inertia",
    "joint1.rotor_inertia", "joint2.rotor_inertia",
    "joint1.link_viscous", "joint2.link_viscous", "joint1.motor_viscous", "joint2.motor_viscous",
    "joint1.stiffness", "joint2.stiffness",
    "joint1.link_coulomb", "joint2.link_coulomb", "joint1.motor_coulomb", "joint2.motor_coulomb",
]


def mjcf(theta, period):
    inertia1, coupling, inertia2, r1, r2, lv1, lv2, mv1, mv2, k1, k2, lc1, lc2, mc1, mc2 = theta
    centre = coupling / (MASS2 * LENGTH)
    about1 = max(inertia1 - inertia2 - MASS2 * LENGTH**2, 1e-4)
    about2 = max(inertia2 - MASS2 * centre**2, 1e-5)

    def body(name, viscous, coulomb, mass, x, about, inner="", place=0.0):
        return (f'<body pos="{place} 0 0"><joint name="{name}" axis="0 0 1" damping="{viscous}" frictionloss="{coulomb}"/>'
                f'<inertial mass="{mass}" pos="{x} 0 0" diaginertia="{about} {about} {about}"/>{inner}</body>')

    second = body("q2", lv2, lc2, MASS2, centre, about2, place=LENGTH)
    bodies = (body("q1", lv1, lc1, MASS1, 0.0, about1, second)
              + body("phi1", mv1, mc1, 1.0, 0.0, r1) + body("phi2", mv2, mc2, 1.0, 0.0, r2))
    springs = "".join(f'<fixed stiffness="{k}" springlength="0"><joint joint="phi{i}" coef="1"/>'
                      f'<joint joint="q{i}" coef="-1"/></fixed>' for i, k in [(1, k1), (2, k2)])
    motors = "".join(f'<motor name="tau{i}" joint="phi{i}"/>' for i in (1, 2))
    sensors = "".join(f'<jointpos name="{name}" joint="{name}"/>' for name in ("q1", "q2", "phi1", "phi2"))
    return (f'<mujoco><option integrator="implicit" timestep="{period}" gravity="0 0 0"><flag contact="disable"/></option>'
            f'<worldbody>{bodies}</worldbody><tendon>{springs}</tendon><actuator>{motors}</actuator>'
            f'<sensor>{sensors}</sensor></mujoco>')


def identify(log, start, max_iterations=60):
    """Returns the parameters by name.

    - log: columns of the demo's log; start: values to begin with, by name.
    """
    period = float(log["t_s"][1])
    begin = np.array([start[name] for name in NAMES])
    spec = mujoco.MjSpec.from_string(mjcf(begin, period))
    model = spec.compile()
    times = log["t_s"]
    control = sysid.TimeSeries.from_control_names(times, np.column_stack([log["tau1_nm"], log["tau2_nm"]]), model)
    columns = [log[f"{name}_rad"] for name in ("q1", "q2", "phi1", "phi2")]
    measured = sysid.TimeSeries.from_names(times, np.column_stack(columns), model, ["q1", "q2", "phi1", "phi2"])
    state = sysid.create_initial_state(model, np.array([column[0] for column in columns]))
    sequences = [sysid.ModelSequences("demo", spec, "log", state, control, measured)]
    params = sysid.ParameterDict()
    # The factors of the starting values.
    params.add(sysid.Parameter("factors", np.ones(15), np.full(15, 0.05), np.full(15, 20.0)))

    def build(params, spec):
        return mujoco.MjModel.from_xml_string(mjcf(begin * params["factors"].value, period))

    residual = sysid.build_residual_fn(models_sequences=sequences, build_model=build)
    with contextlib.redirect_stdout(io.StringIO()):
        found, _ = sysid.optimize(params, residual, verbose=False, max_iters=max_iterations)
    return dict(zip(NAMES, begin * found["factors"].value))
