
#include <float.h>

#ifdef SPRUNG_FLOAT
#define LARGEST FLT_MAX
#else
#define LARGEST DBL_MAX
#endif

/* Impulses of the shaper. */
#define TAPS %TAPS%
static const int delays[TAPS] = {%DELAYS%};
static const @real weights[TAPS] = {%WEIGHTS%};

/* Largest torques. */
static const @real limits_nm[§JOINTS] = {%LIMITS%};

%FEEDBACK%
static int are_finite(const @real *x, int length)
{
    int i;
    for (i = 0; i < length; i++) {
        if (!(FABS(x[i]) <= LARGEST)) {
            return 0;
        }
    }
    return 1;
}

void @start(struct @controller *own)
{
    own->newest_position = 0;
    own->newest_wanted = 0;
    own->is_started = 0;
    own->is_stopped = 0;
}

/* Fills the memories with a rest at the first positions. */
static void rest(struct @controller *own, const @real wanted[§WANTED],
    const @real positions[2 * §JOINTS])
{
    int i, k;
    for (k = 0; k < §MEASURED; k++) {
        for (i = 0; i < 2 * §JOINTS; i++) {
            own->positions[k][i] = positions[i];
        }
    }
    for (k = 0; k < §SHAPED; k++) {
        for (i = 0; i < §WANTED; i++) {
            own->wanted[k][i] = i < §JOINTS ? wanted[i] : R(0.0);
        }
    }
    own->is_started = 1;
}

static void shape(struct @controller *own, const @real wanted[§WANTED], @real shaped[§WANTED])
{
    int i, k;
    own->newest_wanted = (own->newest_wanted + 1) % §SHAPED;
    for (i = 0; i < §WANTED; i++) {
        own->wanted[own->newest_wanted][i] = wanted[i];
        shaped[i] = R(0.0);
    }
    for (k = 0; k < TAPS; k++) {
        const @real *past = own->wanted[(own->newest_wanted + §SHAPED - delays[k]) % §SHAPED];
        for (i = 0; i < §WANTED; i++) {
            shaped[i] += weights[k] * past[i];
        }
    }
}

/* Averages positions over %POSITIONS% samples, and differences of these averages over %RATES% samples. */
static void estimate(struct @controller *own, const @real positions[2 * §JOINTS],
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

static int stop(struct @controller *own, @real tau_nm[§JOINTS])
{
    int i;
    for (i = 0; i < §JOINTS; i++) {
        tau_nm[i] = R(0.0);
    }
    own->is_stopped = 1;
    return 1;
}

int @control(struct @controller *own,
    const @real wanted[§WANTED],
    const @real q_rad[§JOINTS],
    const @real phi_rad[§JOINTS],
    @real tau_nm[§JOINTS])
{
    @real positions[2 * §JOINTS], velocities[2 * §JOINTS], shaped[§WANTED];
    @real phi_d[§JOINTS], dphi_d[§JOINTS], errors[4 * §JOINTS];
    int i;
    for (i = 0; i < §JOINTS; i++) {
        positions[i] = q_rad[i];
        positions[§JOINTS + i] = inverse_rotors[i] > R(0.0) ? phi_rad[i] : q_rad[i];
    }
    if (own->is_stopped || !are_finite(wanted, §WANTED) || !are_finite(positions, 2 * §JOINTS)) {
        return stop(own, tau_nm);
    }
    if (!own->is_started) {
        rest(own, wanted, positions);
    }
    shape(own, wanted, shaped);
    estimate(own, positions, velocities);
    @feedforward(shaped, shaped + §JOINTS, shaped + 2 * §JOINTS, shaped + 3 * §JOINTS,
        shaped + 4 * §JOINTS, tau_nm, phi_d, dphi_d);
    for (i = 0; i < §JOINTS; i++) {
        errors[i] = shaped[i] - positions[i];
        errors[§JOINTS + i] = phi_d[i] - positions[§JOINTS + i];
        errors[2 * §JOINTS + i] = shaped[§JOINTS + i] - velocities[i];
        errors[3 * §JOINTS + i] = dphi_d[i] - velocities[§JOINTS + i];
    }
    feed_back(errors, tau_nm);
    if (!are_finite(tau_nm, §JOINTS)) {
        return stop(own, tau_nm);
    }
    for (i = 0; i < §JOINTS; i++) {
        const @real limit = limits_nm[i];
        tau_nm[i] = tau_nm[i] > limit ? limit : tau_nm[i] < -limit ? -limit : tau_nm[i];
    }
    return 0;
}
