#ifdef SPRUNG_FLOAT
#define MEMORY_TOLERANCE 5e-2
#else
#define MEMORY_TOLERANCE 1e-12
#endif

#define REMEMBERED %COUNT%

/* A sample of a motion with memory, and the torques of sprung. */
struct remembered {
    @real q_rad[§JOINTS];
    @real dq_rad_per_s[§JOINTS];
    @real ddq_rad_per_s2[§JOINTS];
    @real phi_rad[§JOINTS];
    @real dphi_rad_per_s[§JOINTS];
    @real ddphi_rad_per_s2[§JOINTS];
    @real link_nm[§JOINTS];
    @real motor_nm[§JOINTS];
};

static const struct remembered remembered[REMEMBERED] = {
%SAMPLES%};

static void check_memory(void)
{
    static struct @memory own;
    @real link_nm[§JOINTS], motor_nm[§JOINTS];
    int k;
    for (k = 0; k < REMEMBERED; k++) {
        const struct remembered *at = &remembered[k];
        @remember(&own, at->q_rad, at->phi_rad);
        @inverse_dynamics_with_memory(at->q_rad, at->dq_rad_per_s, at->ddq_rad_per_s2, at->phi_rad,
            at->dphi_rad_per_s, at->ddphi_rad_per_s2, own.elements, link_nm, motor_nm);
        compare("torques of links with memory", k, link_nm, at->link_nm, §JOINTS, MEMORY_TOLERANCE);
        compare("torques of motors with memory", k, motor_nm, at->motor_nm, §JOINTS, MEMORY_TOLERANCE);
    }
}

