#ifdef SPRUNG_FLOAT
#define CONTROL_TOLERANCE 1e-2
#else
#define CONTROL_TOLERANCE 1e-12
#endif

#define SAMPLES %COUNT%

/* A sample of the controller. In the last %FAR% samples the positions are so wrong that torques reach their
 * limits. */
struct sample {
    @real desired[§DESIRED];
    @real q_rad[§JOINTS];
    @real phi_rad[§JOINTS];
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

/* Starts the controller at the first sample. */
static int start(struct @control *own)
{
    return @control_start(own, samples[0].q_rad, samples[0].phi_rad, samples[0].desired);
}

%FEEDFORWARD%/* Checks that a step stops the controller for good, until it is started again. */
static void check_stop(struct @control *own, const @real *desired, const @real *q_rad, const @real *phi_rad)
{
    const struct sample *good = &samples[0];
    const @real none[§JOINTS] = {R(0.0)};
    @real tau_nm[§JOINTS];
    expect(start(own) == 0, "no start");
    expect(@control_step(own, good->desired, good->q_rad, good->phi_rad, tau_nm) == 0, "a stop");
    expect(@control_step(own, desired, q_rad, phi_rad, tau_nm) == 1, "no stop");
    compare("stopped controller", 0, tau_nm, none, §JOINTS, 0.0);
    expect(@control_step(own, good->desired, good->q_rad, good->phi_rad, tau_nm) == 1, "no latch");
    compare("stopped controller", 1, tau_nm, none, §JOINTS, 0.0);
}

static void check_controller(void)
{
    static struct @control own;
    const struct sample *good = &samples[0];
    const volatile @real zero = R(0.0);
    @real tau_nm[§JOINTS], wrong[§DESIRED];
    int k, i;
    expect(@control_step(&own, good->desired, good->q_rad, good->phi_rad, tau_nm) == 1, "not started");
    start(&own);
    for (k = 0; k < SAMPLES; k++) {
        const struct sample *at = &samples[k];
        expect(@control_step(&own, at->desired, at->q_rad, at->phi_rad, tau_nm) == 0, "a stop");
        compare("controller", k, tau_nm, at->tau_nm, §JOINTS, CONTROL_TOLERANCE);
    }
    for (i = 0; i < §DESIRED; i++) {
        wrong[i] = i == §JOINTS - 1 ? zero / zero : R(0.0);
    }
    check_stop(&own, good->desired, wrong, good->phi_rad);
    check_stop(&own, wrong, good->q_rad, good->phi_rad);
    expect(@control_start(&own, wrong, good->phi_rad, good->desired) == 1, "a wrong start");
    wrong[§JOINTS - 1] = R(0.0);
    wrong[§DESIRED - 1] = R(-1.0) / zero;
    check_stop(&own, wrong, good->q_rad, good->phi_rad);
}

#ifndef SPRUNG_NO_CLOCK
/* Prints the time of a sample of the controller. */
static void measure_controller(void)
{
    static struct @control own;
    const int runs = 200000;
    @real tau_nm[§JOINTS];
    volatile @real sink = R(0.0);
    clock_t begin;
    int run;
    start(&own);
    begin = clock();
    for (run = 0; run < runs; run++) {
        const struct sample *at = &samples[run % SAMPLES];
        @control_step(&own, at->desired, at->q_rad, at->phi_rad, tau_nm);
        sink = tau_nm[0];
    }
    (void)sink;
    printf("control_step: %.3f us\n", (double)(clock() - begin) / (double)CLOCKS_PER_SEC / runs * 1e6);
}
#endif

