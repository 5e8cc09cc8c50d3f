/* Gains on the errors of phi and of dphi. */
static const @real kp[§JOINTS] = {%KP%};
static const @real kd[§JOINTS] = {%KD%};

static void feed_back(const @real errors[4 * §JOINTS], @real tau_nm[§JOINTS])
{
    int i;
    for (i = 0; i < §JOINTS; i++) {
        tau_nm[i] += kp[i] * errors[§JOINTS + i] + kd[i] * errors[3 * §JOINTS + i];
    }
}

