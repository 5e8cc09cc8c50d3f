/* Gains on the errors of q, phi, dq and dphi, row by row. */
static const @real gain[§JOINTS][4 * §JOINTS] = {
%GAIN%};

/* Adds state feedback to the feedforward. */
static void command(%MEMORY_PARAMETER%const @real shaped[§DESIRED], const @real positions[2 * §JOINTS],
    const @real velocities[2 * §JOINTS], @real tau_nm[§JOINTS])
{
    @real phi_d[§JOINTS], dphi_d[§JOINTS], errors[4 * §JOINTS];
    int i, k;
    @feedforward(shaped, shaped + §JOINTS, shaped + 2 * §JOINTS, shaped + 3 * §JOINTS,
        shaped + 4 * §JOINTS,%ELEMENTS_ARGUMENT% tau_nm, phi_d, dphi_d);
%REMEMBER%    for (i = 0; i < §JOINTS; i++) {
        errors[i] = shaped[i] - positions[i];
        errors[§JOINTS + i] = phi_d[i] - positions[§JOINTS + i];
        errors[2 * §JOINTS + i] = shaped[§JOINTS + i] - velocities[i];
        errors[3 * §JOINTS + i] = dphi_d[i] - velocities[§JOINTS + i];
    }
    for (i = 0; i < §JOINTS; i++) {
        @real sum = R(0.0);
        for (k = 0; k < 4 * §JOINTS; k++) {
            sum += gain[i][k] * errors[k];
        }
        tau_nm[i] += sum;
    }
}

