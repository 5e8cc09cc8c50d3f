
#ifdef SPRUNG_FLOAT
#define OBSERVER_TOLERANCE 5e-2
#else
#define OBSERVER_TOLERANCE 1e-12
#endif

/* Samples of a motion that repeats, and how often: the torques of the first and of the last time are known. */
#define OBSERVED %COUNT%
#define TIMES %TIMES%

/* A sample of the observer. */
struct observed {
    @real q_rad[§JOINTS];
    @real phi_rad[§JOINTS];
    @real tau_nm[§JOINTS];
    @real sensor_nm[§JOINTS];
    @real outside_nm[§JOINTS];
    @real last_outside_nm[§JOINTS];
    @real threshold_nm[§JOINTS];
    @real last_threshold_nm[§JOINTS];
};

static const struct observed observed[OBSERVED] = {
%SAMPLES%};

/* Observes the first sample until the observer has settled, then all; returns how many of them it saw. */
static int observe_all(struct @observer *own, int is_compared)
{
    @real outside_nm[§JOINTS], threshold_nm[§JOINTS];
    int k, seen = 0;
    for (k = 0; k < §SETTLE + TIMES * OBSERVED; k++) {
        const struct observed *at = &observed[k < §SETTLE ? 0 : (k - §SETTLE) % OBSERVED];
        const int is_last = k >= §SETTLE + (TIMES - 1) * OBSERVED;
        const int is_blind =
            @observe(own, at->q_rad, at->phi_rad, at->tau_nm,%SENSOR_ARGUMENT% outside_nm, threshold_nm);
        if (is_blind != (k < §SETTLE)) {
            printf("observer: %d in sample %d\n", is_blind, k);
            failures++;
        }
        if (!is_blind && is_compared && (is_last || k < §SETTLE + OBSERVED)) {
            const @real *outside = is_last ? at->last_outside_nm : at->outside_nm;
            const @real *threshold = is_last ? at->last_threshold_nm : at->threshold_nm;
            compare("torque from outside", k, outside_nm, outside, §JOINTS, OBSERVER_TOLERANCE);
            compare("threshold", k, threshold_nm, threshold, §JOINTS, OBSERVER_TOLERANCE);
        }
        seen += !is_blind;
    }
    return seen;
}

static void check_observer(void)
{
    static struct @observer own;
    const struct observed *at = &observed[0];
    const volatile @real zero = R(0.0);
    @real wrong[§JOINTS], outside_nm[§JOINTS], threshold_nm[§JOINTS];
    int i;
    if (observe_all(&own, 1) == 0) {
        printf("the observer saw nothing\n");
        failures++;
    }
    for (i = 0; i < §JOINTS; i++) {
        wrong[i] = i == §JOINTS - 1 ? zero / zero : R(0.0);
    }
    if (@observe(&own, wrong, at->phi_rad, at->tau_nm,%SENSOR_ARGUMENT% outside_nm, threshold_nm) != 1
        || !(outside_nm[0] == R(0.0))) {
        printf("the observer is not blind\n");
        failures++;
    }
    /* It begins again. */
    observe_all(&own, 1);
}

#ifndef SPRUNG_NO_CLOCK
/* Prints the time of a sample of the observer. */
static void measure_observer(void)
{
    static struct @observer own;
    const int runs = 200000;
    @real outside_nm[§JOINTS], threshold_nm[§JOINTS];
    volatile @real sink = R(0.0);
    const clock_t begin = clock();
    int run;
    for (run = 0; run < runs; run++) {
        const struct observed *at = &observed[run % OBSERVED];
        @observe(&own, at->q_rad, at->phi_rad, at->tau_nm,%SENSOR_ARGUMENT% outside_nm, threshold_nm);
        sink = outside_nm[0];
    }
    (void)sink;
    printf("observe: %.3f us\n", (double)(clock() - begin) / (double)CLOCKS_PER_SEC / runs * 1e6);
}
#endif

