
/* Impulses of the shaper. */
#define TAPS %TAPS%
static const int delays[TAPS] = {%DELAYS%};
static const @real weights[TAPS] = {%WEIGHTS%};

/* Largest torques. */
static const @real limits_nm[§JOINTS] = {%LIMITS%};

%COMMAND%
static int are_finite(const @real *x, int length)
{
    int i;
    for (i = 0; i < length; i++) {
        /* Infinity minus infinity is not a number, which equals nothing. */
        if (!(x[i] - x[i] == R(0.0))) {
            return 0;
        }
    }
    return 1;
}

/* The motor of a rigid joint moves with its link. */
static void join(const @real q_rad[§JOINTS], const @real phi_rad[§JOINTS],
    @real positions[2 * §JOINTS])
{
    int i;
    for (i = 0; i < §JOINTS; i++) {
        positions[i] = q_rad[i];
        positions[§JOINTS + i] = inverse_rotors[i] > R(0.0) ? phi_rad[i] : q_rad[i];
    }
}

static void shape(struct @control *own, const @real desired[§DESIRED], @real shaped[§DESIRED])
{
    const @real *first;
    int i, k;
    own->newest_desired = (own->newest_desired + 1) % §SHAPED;
    for (i = 0; i < §DESIRED; i++) {
        own->desired[own->newest_desired][i] = desired[i];
    }
    first = own->desired[(own->newest_desired + §SHAPED - delays[0]) % §SHAPED];
    for (i = 0; i < §DESIRED; i++) {
        shaped[i] = first[i];
    }
    /* The weights have the sum 1, so the differences to the first impulse are enough. */
    for (k = 1; k < TAPS; k++) {
        const @real *past = own->desired[(own->newest_desired + §SHAPED - delays[k]) % §SHAPED];
        for (i = 0; i < §DESIRED; i++) {
            shaped[i] += weights[k] * (past[i] - first[i]);
        }
    }
}

/* Averages positions over %POSITIONS% samples, and differences of these averages over %RATES% samples. */
static void estimate(struct @control *own, const @real positions[2 * §JOINTS],
    @real velocities[2 * §JOINTS])
{
    int i, age;
    own->newest_position = (own->newest_position + 1) % §MEASURED;
    for (i = 0; i < 2 * §JOINTS; i++) {
        own->positions[own->newest_position][i] = positions[i];
        velocities[i] = R(0.0);
    }
    for (age = 0; age < %POSITIONS%; age++) {
        const int at = own->newest_position + §MEASURED - age;
        const @real *later = own->positions[at % §MEASURED];
        const @real *earlier = own->positions[(at - %RATES%) % §MEASURED];
        for (i = 0; i < 2 * §JOINTS; i++) {
            velocities[i] += later[i] - earlier[i];
        }
    }
    for (i = 0; i < 2 * §JOINTS; i++) {
        velocities[i] *= %SCALE%;
    }
}

int @control_start(struct @control *own,
    const @real q_rad[§JOINTS],
    const @real phi_rad[§JOINTS],
    const @real desired[§JOINTS])
{
    @real positions[2 * §JOINTS];
    int i, k;
    join(q_rad, phi_rad, positions);
    own->newest_position = 0;
    own->newest_desired = 0;
    own->is_running = are_finite(positions, 2 * §JOINTS) && are_finite(desired, §JOINTS);
    for (k = 0; k < §MEASURED; k++) {
        for (i = 0; i < 2 * §JOINTS; i++) {
            own->positions[k][i] = positions[i];
        }
    }
    for (k = 0; k < §SHAPED; k++) {
        for (i = 0; i < §DESIRED; i++) {
            own->desired[k][i] = i < §JOINTS ? desired[i] : R(0.0);
        }
    }
%FORGET%    return !own->is_running;
}

int @control_step(struct @control *own,
    const @real desired[§DESIRED],
    const @real q_rad[§JOINTS],
    const @real phi_rad[§JOINTS],
    @real tau_nm[§JOINTS])
{
    @real positions[2 * §JOINTS], velocities[2 * §JOINTS], shaped[§DESIRED];
    int i;
    join(q_rad, phi_rad, positions);
    if (own->is_running && are_finite(desired, §DESIRED) && are_finite(positions, 2 * §JOINTS)) {
        shape(own, desired, shaped);
        estimate(own, positions, velocities);
        command(%MEMORY_ARGUMENT%shaped, positions, velocities, tau_nm);
        own->is_running = are_finite(tau_nm, §JOINTS);
    } else {
        own->is_running = 0;
    }
    for (i = 0; i < §JOINTS; i++) {
        const @real limit = limits_nm[i];
        const @real tau = own->is_running ? tau_nm[i] : R(0.0);
        tau_nm[i] = tau > limit ? limit : tau < -limit ? -limit : tau;
    }
    return !own->is_running;
}
