#ifdef SPRUNG_FLOAT
#define CONTROL_TOLERANCE 1e-2
#else
#define CONTROL_TOLERANCE 1e-12
#endif

#define SAMPLES %COUNT%

/* A sample of the controller; the feedforward is that of the motion before it is shaped. */
struct sample {
    @real wanted[§WANTED];
    @real q_rad[§JOINTS];
    @real phi_rad[§JOINTS];
    @real tau_ff_nm[§JOINTS];
    @real phi_d_rad[§JOINTS];
    @real dphi_d_rad_per_s[§JOINTS];
    @real tau_nm[§JOINTS];
};

static const struct sample samples[SAMPLES] = {
%SAMPLES%};

static void expect(int is_true, const char *what)
{
    if (!is_true) {
        printf("%s\n", what);
        failures++;
    }
}

static void check_controller(void)
{
    static struct @controller own;
    const @real none[§JOINTS] = {R(0.0)};
    const struct sample *last = &samples[SAMPLES - 1];
    volatile @real zero = R(0.0);
    @real tau_nm[§JOINTS], phi_d[§JOINTS], dphi_d[§JOINTS], q_rad[§JOINTS];
    int k, i;
    @start(&own);
    for (k = 0; k < SAMPLES; k++) {
        const struct sample *at = &samples[k];
        const @real *wanted = at->wanted;
        @feedforward(wanted, wanted + §JOINTS, wanted + 2 * §JOINTS, wanted + 3 * §JOINTS,
            wanted + 4 * §JOINTS, tau_nm, phi_d, dphi_d);
        compare("feedforward", k, tau_nm, at->tau_ff_nm, §JOINTS, TORQUE_TOLERANCE);
        compare("positions of rotors", k, phi_d, at->phi_d_rad, §JOINTS, TORQUE_TOLERANCE);
        compare("velocities of rotors", k, dphi_d, at->dphi_d_rad_per_s, §JOINTS, TORQUE_TOLERANCE);
        expect(@control(&own, wanted, at->q_rad, at->phi_rad, tau_nm) == 0, "the controller stopped");
        compare("controller", k, tau_nm, at->tau_nm, §JOINTS, CONTROL_TOLERANCE);
    }
    for (i = 0; i < §JOINTS; i++) {
        q_rad[i] = last->q_rad[i];
    }
    q_rad[§JOINTS - 1] = zero / zero;
    for (k = 0; k < 2; k++) {
        expect(@control(&own, last->wanted, q_rad, last->phi_rad, tau_nm) == 1, "no stop");
        compare("stopped controller", k, tau_nm, none, §JOINTS, 0.0);
        q_rad[§JOINTS - 1] = last->q_rad[§JOINTS - 1];
    }
    @start(&own);
    expect(@control(&own, last->wanted, q_rad, last->phi_rad, tau_nm) == 0, "no new start");
}

#ifndef SPRUNG_NO_CLOCK
/* Prints the time of a sample of the controller. */
static void measure_controller(void)
{
    static struct @controller own;
    const int runs = 200000;
    @real tau_nm[§JOINTS];
    volatile @real sink = R(0.0);
    clock_t start;
    int run;
    @start(&own);
    start = clock();
    for (run = 0; run < runs; run++) {
        const struct sample *at = &samples[run % SAMPLES];
        @control(&own, at->wanted, at->q_rad, at->phi_rad, tau_nm);
        sink = tau_nm[0];
    }
    (void)sink;
    printf("controller: %.3f us\n", (double)(clock() - start) / (double)CLOCKS_PER_SEC / runs * 1e6);
}
#endif

