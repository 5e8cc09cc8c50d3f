/*
 * The observer of torques from outside, for samples that are %PERIOD% s apart.
%HEADER% */

/* Samples until the observer has settled after its start. */
#define §SETTLE %SETTLE%

/* Three low-pass filters in series. */
struct @chain {
    @real carry[3];
    @real output[3];
};

/* Motion in each direction, and mean residuals of link and motor in each: the zero of a joint's encoders. */
struct @zero {
    @real motion_s[2], link_nm[2], motor_nm[2];
};

/* Memory of the observer. One of zeros begins with its first sample, at rest. */
struct @observer {
    struct @chain link[§JOINTS], motor[§JOINTS], torque[§JOINTS]%SENSOR_CHAIN%;
    @real last_carry[7 * §JOINTS], last_output[7 * §JOINTS];
    struct @zero zero[§JOINTS];
%MEMORY_FIELD%    long samples;
};

/*
 * Computes the torque from outside on each joint and its threshold, once a sample: a larger torque is a contact. Returns 0, or
 * 1 while the observer is blind: it has not settled, or a number is not finite, from which on it begins again. All torques and
 * thresholds are then zero.%SENSOR_NOTE%
 */
int @observe(struct @observer *own,
    const @real q_rad[§JOINTS],
    const @real phi_rad[§JOINTS],
    const @real tau_nm[§JOINTS],%SENSOR_PARAMETER%
    @real outside_nm[§JOINTS],
    @real threshold_nm[§JOINTS]);

