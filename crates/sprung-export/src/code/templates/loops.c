#include "robot.h"

#include <math.h>

#ifdef SPRUNG_FLOAT
#define R(x) x##f
#define SIN sinf
#define COS cosf
#define EXP expf
#define TANH tanhf
#define LOG logf
#define FABS fabsf
#define SQRT sqrtf
#else
#define R(x) x
#define SIN sin
#define COS cos
#define EXP exp
#define TANH tanh
#define LOG log
#define FABS fabs
#define SQRT sqrt
#endif

const @real @theta[§PARAMETERS] = {
%THETA%};

/* Reciprocals of the inertias of rotors behind a spring; zero at rigid joints. */
static const @real inverse_rotors[§JOINTS] = {%INVERSE_ROTORS%};

/* The reciprocal of a pivot; zero if the pivot is not positive. */
static @real inverse_of(@real pivot)
{
    return pivot > R(1e-30) ? R(1.0) / pivot : R(0.0);
}

/* Solves mass * x = x by the factors L D L^T, which replace the mass matrix. */
static void solve(@real mass[§JOINTS * §JOINTS], @real x[§JOINTS])
{
    int i, j, k;
    for (j = 0; j < §JOINTS; j++) {
        @real pivot = mass[j * §JOINTS + j];
        for (k = 0; k < j; k++) {
            const @real factor = mass[j * §JOINTS + k];
            pivot -= factor * factor * mass[k * §JOINTS + k];
        }
        mass[j * §JOINTS + j] = pivot;
        for (i = j + 1; i < §JOINTS; i++) {
            @real rest = mass[i * §JOINTS + j];
            for (k = 0; k < j; k++) {
                rest -= mass[i * §JOINTS + k] * mass[j * §JOINTS + k] * mass[k * §JOINTS + k];
            }
            mass[i * §JOINTS + j] = rest * inverse_of(pivot);
        }
    }
    for (i = 0; i < §JOINTS; i++) {
        for (k = 0; k < i; k++) {
            x[i] -= mass[i * §JOINTS + k] * x[k];
        }
    }
    for (i = §JOINTS - 1; i >= 0; i--) {
        x[i] *= inverse_of(mass[i * §JOINTS + i]);
        for (k = i + 1; k < §JOINTS; k++) {
            x[i] -= mass[k * §JOINTS + i] * x[k];
        }
    }
}

%FUNCTIONS%void @forward_dynamics(const @real q_rad[§JOINTS],
    const @real dq_rad_per_s[§JOINTS],
    const @real phi_rad[§JOINTS],
    const @real dphi_rad_per_s[§JOINTS],
    const @real tau_link_nm[§JOINTS],
    const @real tau_motor_nm[§JOINTS],
    @real ddq_rad_per_s2[§JOINTS],
    @real ddphi_rad_per_s2[§JOINTS])
{
    const @real none[§JOINTS] = {R(0.0)};
    @real mass_kgm2[§JOINTS * §JOINTS];
    @real link_nm[§JOINTS];
    @real motor_nm[§JOINTS];
    int i;
    @inverse_dynamics(q_rad, dq_rad_per_s, none, phi_rad, dphi_rad_per_s, none, link_nm, motor_nm);
    @mass_matrix(q_rad, mass_kgm2);
    for (i = 0; i < §JOINTS; i++) {
        const @real left_nm = tau_motor_nm[i] - motor_nm[i];
        const int is_flexible = inverse_rotors[i] > R(0.0);
        ddq_rad_per_s2[i] = tau_link_nm[i] - link_nm[i] + (is_flexible ? R(0.0) : left_nm);
        ddphi_rad_per_s2[i] = left_nm * inverse_rotors[i];
    }
    solve(mass_kgm2, ddq_rad_per_s2);
    for (i = 0; i < §JOINTS; i++) {
        if (!(inverse_rotors[i] > R(0.0))) {
            ddphi_rad_per_s2[i] = ddq_rad_per_s2[i];
        }
    }
}

void @state_derivative(const @real state[4 * §JOINTS],
    const @real tau_motor_nm[§JOINTS],
    @real derivative[4 * §JOINTS])
{
    const @real none[§JOINTS] = {R(0.0)};
    @real ddq[§JOINTS];
    @real ddphi[§JOINTS];
    int i;
    @forward_dynamics(state, state + §JOINTS, state + 2 * §JOINTS, state + 3 * §JOINTS,
        none, tau_motor_nm, ddq, ddphi);
    for (i = 0; i < §JOINTS; i++) {
        const int is_flexible = inverse_rotors[i] > R(0.0);
        derivative[i] = state[§JOINTS + i];
        derivative[2 * §JOINTS + i] = state[(is_flexible ? 3 : 1) * §JOINTS + i];
        derivative[§JOINTS + i] = ddq[i];
        derivative[3 * §JOINTS + i] = ddphi[i];
    }
}
%CONTROLLER%