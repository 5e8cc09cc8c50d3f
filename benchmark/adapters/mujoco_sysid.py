"""MuJoCo's sysid fits rollouts of 0.25 s from smoothed states to motor angles and deflections; springs are tendons."""
import sys
from pathlib import Path
import numpy as np
from mujoco import MjSpec, mjtIntegrator, mjtTrn, sysid
from scipy.signal import butter, filtfilt
sys.path.insert(0, str(Path(__file__).parents[1]))
from tool import DRIVES, Log, save
log, out, parts = Log(Path(sys.argv[1])), Path(sys.argv[2]), ["stiffness", "armature", *["damping", "frictionloss"] * 2]
if any(log.rigid) or log.n > 2: sys.exit("does only arms of two joints with springs: larger ones take over 5 minutes, rigid ones drift")
n, h, size, nominal = log.n, log.dt, round(0.25 / log.dt), np.array([log.task["nominal_drives"][key] for key in DRIVES])
spec, scale = MjSpec.from_file(str(Path(sys.argv[1]) / "robot.urdf")), np.r_[[0.25] * 6 * n, [1, 0.05, 0.05, 0.05] * n, 1e-3]
spec.option.timestep, spec.option.integrator, spec.option.tolerance = h, mjtIntegrator.mjINT_RK4, 1e-12
for i, hinge in enumerate(list(spec.joints), 1):
    spring, _ = spec.add_tendon(name=f"spring{i}"), spec.add_actuator(name=f"torque{i}", target=f"motor{i}", trntype=mjtTrn.mjTRN_JOINT)
    for joint, sign in (spec.worldbody.add_body(mass=1e-9, inertia=[1e-9] * 3, explicitinertial=True).add_joint(name=f"motor{i}"), 1), (hinge, -1):
        joint.solref_friction, joint.solimp_friction, _ = [2 * h, 1], [0.99, 0.9999, 1e-3, 0.5, 2], spring.wrap_joint(joint.name, sign)
drives = lambda s, p: [setattr(s.joint(f"{'joint' if k > 3 else 'motor'}{i + 1}") if k else s.tendon(f"spring{i + 1}"), parts[k],
                               x if k % 2 else [x, 0, 0]) for (k, i), x in np.ndenumerate(nominal * p.value.reshape(6, n))]
shapes = [sysid.body_inertia_param(spec.copy(), spec.compile(), f"link{i + 1}", sysid.InertiaType.MassIpos, True) for i in range(n)]
params = sysid.ParameterDict({p.name: p for p in [sysid.Parameter("drives", [1.0] * 6 * n, [0.2] * 6 * n, [5.0] * 6 * n, modifier=drives),
                                                  *shapes, sysid.Parameter("late", 0.0, -4e-3, 4e-3)]})
v, starts = np.gradient(x := filtfilt(*butter(2, 40 * h), np.c_[log.q, log.p], axis=0), h, axis=0), range(size, len(log.t) - 2 * size, size)
y, series = np.c_[log.p, log.p - log.q], lambda y: [sysid.TimeSeries(log.t[: size + 1], y[k : k + size + 1]) for k in starts]
start, weight = params.as_vector(), np.repeat([1800, 50], n) / np.sqrt((y**2).mean(0))  # errors that noisy torques cause
arm = sysid.ModelSequences("arm", spec, [""] * len(starts), [sysid.create_initial_state(spec.compile(), x[k], v[k]) for k in starts],
                           series(log.tau), series(y), True)
rollout = lambda initial_states, param_dicts, **more: sysid.sysid_rollout(initial_states=[      # the links are further than read
    s + p["late"].value * np.r_[0, s[1 + 2 * n : 1 + 3 * n], [0] * 3 * n] for s, p in zip(initial_states, param_dicts)], **more)
compare = lambda params, predicted, measured, *_, state, **__: ((measured.data[1:] - state[:, 1:] @ np.kron(
    [[0, -1], [1, 1], [0, params["late"].value[0]], [0, 0]], np.eye(n))) * weight, measured, measured)
fit = sysid.build_residual_fn(models_sequences=[arm], modify_residual=compare, custom_rollout=rollout, n_threads=1, resample_true=False)
residual, trials = lambda x, p: ([*fit(x, p)[0], ((x.T - start[: len(x)]) / scale[: len(x)]).T], None, None), []
for params["late"].frozen in (True, False):                 # late links almost act like friction: kept if they halve the cost
    params, result = sysid.optimize(params, residual, verbose=False, max_iters=12, eps=1e-5, xtol=3e-3, mu_min=10, x_scale=scale[: params.size])
    trials.append((params, result, residual(result.x, params)[0]))
found, result, rest = trials[int(np.linalg.norm(np.concatenate(trials[1][2])) < 0.7 * np.linalg.norm(np.concatenate(trials[0][2])))]
each, _ = [result.x, sysid.calculate_intervals(rest, result.jac)[1] / 1.96], sysid.apply_param_modifiers(found, spec)
save(out, "MuJoCo sysid", *(nominal * y[: 6 * n].reshape(6, n) for y in each),
     [sysid.model_modifier.pi_from_body(spec, f"link{i + 1}")[[0, 1, 2, 3, 4, 5, 8, 6, 9, 12]] for i in range(n)])
