/* Gains on the errors of q, phi, dq and dphi, row by row. */
static const @real gain[§JOINTS][4 * §JOINTS] = {
%GAIN%};

static void feed_back(const @real errors[4 * §JOINTS], @real tau_nm[§JOINTS])
{
    int i, k;
    for (i = 0; i < §JOINTS; i++) {
        @real sum = R(0.0);
        for (k = 0; k < 4 * §JOINTS; k++) {
            sum += gain[i][k] * errors[k];
        }
        tau_nm[i] += sum;
    }
}

