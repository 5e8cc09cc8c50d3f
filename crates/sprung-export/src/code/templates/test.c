/*
 * The self-test: compares the functions with the numbers of sprung, and prints PASS or FAIL. With
 * -DSPRUNG_NO_CLOCK, it measures no time.
 */
#include "robot.h"

#include <stdio.h>
#ifndef SPRUNG_NO_CLOCK
#include <time.h>
#endif

#ifdef SPRUNG_FLOAT
#define R(x) x##f
#define TORQUE_TOLERANCE 1e-4
#define ACCELERATION_TOLERANCE 1e-2
#else
#define R(x) x
#define TORQUE_TOLERANCE 1e-12
#define ACCELERATION_TOLERANCE 1e-9
#endif

#define STATES %COUNT%

/* A state, and the numbers of sprung. */
struct vector {
    @real q_rad[§JOINTS];
    @real dq_rad_per_s[§JOINTS];
    @real ddq_rad_per_s2[§JOINTS];
    @real phi_rad[§JOINTS];
    @real dphi_rad_per_s[§JOINTS];
    @real ddphi_rad_per_s2[§JOINTS];
    @real gravity_nm[§JOINTS];
    @real coriolis_nm[§JOINTS];
    @real mass_kgm2[§JOINTS * §JOINTS];
    @real link_nm[§JOINTS];
    @real motor_nm[§JOINTS];
    @real tau_link_nm[§JOINTS];
    @real tau_motor_nm[§JOINTS];
    @real ddq_by_tau[§JOINTS];
    @real ddphi_by_tau[§JOINTS];
};

static const struct vector vectors[STATES] = {
%VECTORS%};

static int failures = 0;

static double size_of(@real x)
{
    return x < R(0.0) ? -(double)x : (double)x;
}

/* Compares an array, relative to its largest number. */
static void compare(const char *what, int state, const @real *found, const @real *known, int length,
    double tolerance)
{
    double largest = 0.0, difference = 0.0;
    int i;
    for (i = 0; i < length; i++) {
        const double own = size_of(found[i] - known[i]);
        largest = size_of(known[i]) > largest ? size_of(known[i]) : largest;
        difference = own <= difference ? difference : own;
    }
    if (!(difference <= tolerance * (largest > 0.0 ? largest : 1.0))) {
        printf("%s differs in state %d: %.1e of %.1e\n", what, state, difference, largest);
        failures++;
    }
}

/* Compares the product of regressor and parameters with the torques. */
static void compare_regressor(int state, const struct vector *own)
{
    static @real regressor[§ROWS * §PARAMETERS];
    @real known_nm[§ROWS], product_nm[§ROWS];
    int i, k, row = §JOINTS;
    @regressor(own->q_rad, own->dq_rad_per_s, own->ddq_rad_per_s2, own->phi_rad, own->dphi_rad_per_s,
        own->ddphi_rad_per_s2, regressor);
    for (i = 0; i < §JOINTS; i++) {
        const int is_rigid = own->phi_rad[i] == own->q_rad[i];
        known_nm[i] = is_rigid ? own->motor_nm[i] : own->link_nm[i];
        if (!is_rigid && row < §ROWS) {
            known_nm[row++] = own->motor_nm[i];
        }
    }
    for (i = 0; i < §ROWS; i++) {
        product_nm[i] = R(0.0);
        for (k = 0; k < §PARAMETERS; k++) {
            product_nm[i] += regressor[i * §PARAMETERS + k] * @theta[k];
        }
    }
    compare("regressor times parameters", state, product_nm, known_nm, §ROWS, TORQUE_TOLERANCE);
}

#ifndef SPRUNG_NO_CLOCK
/* Prints the time of inverse dynamics. */
static void measure(void)
{
    const int runs = 200000;
    @real q_rad[§JOINTS], link_nm[§JOINTS], motor_nm[§JOINTS];
    volatile @real sink = R(0.0);
    const struct vector *own = &vectors[0];
    clock_t start;
    int i, run;
    for (i = 0; i < §JOINTS; i++) {
        q_rad[i] = own->q_rad[i];
    }
    start = clock();
    for (run = 0; run < runs; run++) {
        q_rad[0] += R(1e-6);
        @inverse_dynamics(q_rad, own->dq_rad_per_s, own->ddq_rad_per_s2, own->phi_rad,
            own->dphi_rad_per_s, own->ddphi_rad_per_s2, link_nm, motor_nm);
        sink = motor_nm[0];
    }
    (void)sink;
    printf("inverse dynamics: %.3f us\n",
        (double)(clock() - start) / (double)CLOCKS_PER_SEC / runs * 1e6);
}
#endif

%CONTROLLER%int main(void)
{
    int state, i;
    for (state = 0; state < STATES; state++) {
        const struct vector *own = &vectors[state];
        @real link_nm[§JOINTS], motor_nm[§JOINTS], more_nm[§JOINTS], mass_kgm2[§JOINTS * §JOINTS];
        @real ddq[§JOINTS], ddphi[§JOINTS];
        @real at[4 * §JOINTS], derivative[4 * §JOINTS], parts_nm[§JOINTS], whole_nm[§JOINTS];
        @inverse_dynamics(own->q_rad, own->dq_rad_per_s, own->ddq_rad_per_s2, own->phi_rad,
            own->dphi_rad_per_s, own->ddphi_rad_per_s2, link_nm, motor_nm);
        compare("inverse dynamics of links", state, link_nm, own->link_nm, §JOINTS, TORQUE_TOLERANCE);
        compare("inverse dynamics of motors", state, motor_nm, own->motor_nm, §JOINTS, TORQUE_TOLERANCE);
        compare_regressor(state, own);
        @gravity(own->q_rad, more_nm);
        compare("gravity", state, more_nm, own->gravity_nm, §JOINTS, TORQUE_TOLERANCE);
        for (i = 0; i < §JOINTS; i++) {
            parts_nm[i] = more_nm[i];
        }
        @coriolis(own->q_rad, own->dq_rad_per_s, more_nm);
        compare("coriolis", state, more_nm, own->coriolis_nm, §JOINTS, TORQUE_TOLERANCE);
        for (i = 0; i < §JOINTS; i++) {
            parts_nm[i] += more_nm[i];
        }
        @mass_matrix(own->q_rad, mass_kgm2);
        compare("mass matrix", state, mass_kgm2, own->mass_kgm2, §JOINTS * §JOINTS, TORQUE_TOLERANCE);
        @friction(own->q_rad, own->dq_rad_per_s, own->phi_rad, own->dphi_rad_per_s, link_nm, motor_nm);
        @spring(own->q_rad, own->dq_rad_per_s, own->phi_rad, own->dphi_rad_per_s, more_nm);
        for (i = 0; i < §JOINTS; i++) {
            /* At a rigid joint, the motor delivers all torques of the link. */
            const int is_rigid = own->phi_rad[i] == own->q_rad[i];
            int k;
            parts_nm[i] += link_nm[i] - more_nm[i] + (is_rigid ? motor_nm[i] : R(0.0));
            for (k = 0; k < §JOINTS; k++) {
                parts_nm[i] += mass_kgm2[i * §JOINTS + k] * own->ddq_rad_per_s2[k];
            }
            whole_nm[i] = own->link_nm[i] + (is_rigid ? own->motor_nm[i] : R(0.0));
        }
        compare("sum of the parts", state, parts_nm, whole_nm, §JOINTS, TORQUE_TOLERANCE);
        @forward_dynamics(own->q_rad, own->dq_rad_per_s, own->phi_rad, own->dphi_rad_per_s,
            own->tau_link_nm, own->tau_motor_nm, ddq, ddphi);
        compare("accelerations of links", state, ddq, own->ddq_by_tau, §JOINTS, ACCELERATION_TOLERANCE);
        compare("accelerations of motors", state, ddphi, own->ddphi_by_tau, §JOINTS,
            ACCELERATION_TOLERANCE);
        for (i = 0; i < §JOINTS; i++) {
            at[i] = own->q_rad[i];
            at[§JOINTS + i] = own->dq_rad_per_s[i];
            at[2 * §JOINTS + i] = own->phi_rad[i];
            at[3 * §JOINTS + i] = own->dphi_rad_per_s[i];
            more_nm[i] = R(0.0);
        }
        @state_derivative(at, own->tau_motor_nm, derivative);
        @forward_dynamics(own->q_rad, own->dq_rad_per_s, own->phi_rad, own->dphi_rad_per_s,
            more_nm, own->tau_motor_nm, ddq, ddphi);
        compare("derivative of q", state, derivative, own->dq_rad_per_s, §JOINTS, TORQUE_TOLERANCE);
        compare("derivative of dq", state, derivative + §JOINTS, ddq, §JOINTS, TORQUE_TOLERANCE);
        compare("derivative of phi", state, derivative + 2 * §JOINTS, own->dphi_rad_per_s, §JOINTS,
            TORQUE_TOLERANCE);
        compare("derivative of dphi", state, derivative + 3 * §JOINTS, ddphi, §JOINTS, TORQUE_TOLERANCE);
    }
%CHECK%#ifndef SPRUNG_NO_CLOCK
    measure();
%MEASURE%#endif
    printf("%s: %d states\n", failures == 0 ? "PASS" : "FAIL", STATES);
    return failures == 0 ? 0 : 1;
}
