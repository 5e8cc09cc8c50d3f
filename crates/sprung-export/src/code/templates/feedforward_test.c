#define MOTIONS %COUNT%

/* A desired motion, and its feedforward. */
struct motion {
    @real desired[§DESIRED%ELEMENTS_SIZE%];
    @real tau_nm[§JOINTS];
    @real phi_rad[§JOINTS];
    @real dphi_rad_per_s[§JOINTS];
};

static const struct motion motions[MOTIONS] = {
%MOTIONS%};

static void check_feedforward(void)
{
    @real tau_nm[§JOINTS], phi[§JOINTS], dphi[§JOINTS];
    int k;
    for (k = 0; k < MOTIONS; k++) {
        const struct motion *at = &motions[k];
        const @real *desired = at->desired;
        @feedforward(desired, desired + §JOINTS, desired + 2 * §JOINTS, desired + 3 * §JOINTS,
            desired + 4 * §JOINTS,%TESTED_ELEMENTS% tau_nm, phi, dphi);
        compare("feedforward", k, tau_nm, at->tau_nm, §JOINTS, TORQUE_TOLERANCE);
        compare("positions of motors", k, phi, at->phi_rad, §JOINTS, TORQUE_TOLERANCE);
        compare("velocities of motors", k, dphi, at->dphi_rad_per_s, §JOINTS, TORQUE_TOLERANCE);
    }
}

