"""Times Pinocchio's regressor of the seven-joint arm, called through its Python binding.

    python regressor_pinocchio.py
"""

import time

import numpy as np
import pinocchio as pin

import seven_joints as arm

CALLS = 100_000


def microseconds(call):
    best = np.inf
    for _ in range(3):
        start = time.perf_counter()
        for _ in range(CALLS):
            call()
        best = min(best, time.perf_counter() - start)
    return 1e6 * best / CALLS


def main():
    model = arm.pinocchio_model()
    data = model.createData()
    q, v, a = (0.3 + 0.2 * (np.arange(arm.N) + group) for group in range(3))
    torque = pin.computeJointTorqueRegressor(model, data, q, v, a)
    parameters = np.concatenate([arm.link(i) for i in range(arm.N)])
    assert np.allclose(torque @ parameters, pin.rnea(model, data, q, v, a))
    regressor = microseconds(lambda: pin.computeJointTorqueRegressor(model, data, q, v, a))
    # This call has almost no arithmetic, so it shows the cost of a call with vectors.
    binding = microseconds(lambda: pin.integrate(model, q, v))
    print(f"microseconds {regressor:.3f}")
    print(f"binding {binding:.3f}")


if __name__ == "__main__":
    main()
