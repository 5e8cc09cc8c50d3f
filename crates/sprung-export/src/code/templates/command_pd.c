/* Gains on the errors of phi and of dphi. */
static const @real kp[§JOINTS] = {%KP%};
static const @real kd[§JOINTS] = {%KD%};

/* PD of the motors. */
static void command(const @real shaped[§DESIRED], const @real positions[2 * §JOINTS],
    const @real velocities[2 * §JOINTS], @real tau_nm[§JOINTS])
{
    int i;
    for (i = 0; i < §JOINTS; i++) {
        tau_nm[i] = kp[i] * (shaped[i] - positions[§JOINTS + i]) +
            kd[i] * (shaped[§JOINTS + i] - velocities[§JOINTS + i]);
    }
}

