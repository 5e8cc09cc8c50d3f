
/* Filters of the observer: pole, and factors of the present and of the last input. */
static const @real continuous[3] = {%CONTINUOUS%};
static const @real held[3] = {%HELD%};
static const @real last[3] = {%LAST%};

/* Shares of the motors' equations, sharpness of Coulomb friction, thresholds in standard deviations. */
static const @real motor_share[§JOINTS] = {%SHARE%};
static const @real sharpness[§JOINTS] = {%SHARPNESS%};
static const @real threshold_sigma[§JOINTS] = {%SIGMA%};

/* Deviations by other zeros of the encoders, while they are not known. */
static const @real zero_nm[§JOINTS] = {%ZERO%};
%SENSOR_CONSTANTS%
/* Variance: of one, and of the squares of velocity, torque, acceleration and nearness of a reversal. */
static const @real variance[§JOINTS][5] = {
%VARIANCE%};

static @real squared_root(@real x)
{
    return x > R(0.0) ? SQRT(x) : R(0.0);
}

/* Filters a signal three times; its first filter is that of a held torque or of a continuous signal. */
static void filter(struct @chain *own, const @real first[3], @real x, int begins)
{
    int i;
    for (i = 0; i < 3; i++) {
        const @real *pair = i == 0 ? first : continuous;
        @real y = own->carry[i] + pair[1] * x + pair[0] * own->output[i];
        if (begins) {
            y = x;
        }
        own->carry[i] = pair[2] * x;
        own->output[i] = y;
        x = y;
    }
}

/* Position, velocity and acceleration of a filtered position. */
static void move(const struct @chain *own, @real *position, @real *velocity, @real *acceleration)
{
    const @real w = %CUTOFF%;
    const @real one = own->output[0], two = own->output[1], three = own->output[2];
    *position = three;
    *velocity = w * (two - three);
    *acceleration = w * w * (one - two - (two - three));
}

/* Filters a residual, or a quantity with which its error grows, the last time. */
static @real smooth(struct @observer *own, int at, @real x)
{
    const @real y = own->samples == 0
        ? R(0.0)
        : own->last_carry[at] + last[1] * x + last[0] * own->last_output[at];
    own->last_carry[at] = last[2] * x;
    own->last_output[at] = y;
    return y;
}

/*
 * The constant torque of a spring whose encoders have another zero than at the identification, in the equation of the motor. It
 * has opposite signs in the equations of link and motor, and both directions of motion are needed, so that errors of the friction
 * cancel. Returns whether it is known.
 */
static int find_zero(struct @zero *own, @real direction, @real of_link_nm, @real of_motor_nm, @real *torque_nm)
{
    const int at = direction < R(0.0);
    const @real weight = direction * direction * %PERIOD%;
    @real link_nm, motor_nm;
    own->motion_s[at] = own->motion_s[at] + weight < %ZERO_MEMORY% ? own->motion_s[at] + weight : %ZERO_MEMORY%;
    if (own->motion_s[at] > R(0.0)) {
        const @real part = weight / own->motion_s[at];
        own->link_nm[at] += part * (of_link_nm - own->link_nm[at]);
        own->motor_nm[at] += part * (of_motor_nm - own->motor_nm[at]);
    }
    link_nm = R(0.5) * (own->link_nm[0] + own->link_nm[1]);
    motor_nm = R(0.5) * (own->motor_nm[0] + own->motor_nm[1]);
    *torque_nm = R(0.0);
    if (own->motion_s[0] < %ZERO_KNOWN% || own->motion_s[1] < %ZERO_KNOWN%) {
        return 0;
    }
    if (link_nm * motor_nm < R(0.0)) {
        const @real size = FABS(link_nm) < FABS(motor_nm) ? FABS(link_nm) : FABS(motor_nm);
        *torque_nm = motor_nm < R(0.0) ? -size : size;
    }
    return 1;
}

int @observe(struct @observer *own,
    const @real q_rad[§JOINTS],
    const @real phi_rad[§JOINTS],
    const @real tau_nm[§JOINTS],%SENSOR_PARAMETER%
    @real outside_nm[§JOINTS],
    @real threshold_nm[§JOINTS])
{
    @real motion[2][3][§JOINTS];
    @real link_nm[§JOINTS], motor_nm[§JOINTS];
    const int begins = own->samples == 0;
    int i, is_blind = 0;
    for (i = 0; i < §JOINTS; i++) {
        const int is_flexible = inverse_rotors[i] > R(0.0);
        const @real phi = is_flexible ? phi_rad[i] : q_rad[i];
        filter(&own->link[i], continuous, q_rad[i], begins);
        filter(&own->motor[i], continuous, phi, begins);
        filter(&own->torque[i], held, tau_nm[i], begins);
%SENSOR_FILTER%        move(&own->link[i], &motion[0][0][i], &motion[0][1][i], &motion[0][2][i]);
        move(&own->motor[i], &motion[1][0][i], &motion[1][1][i], &motion[1][2][i]);
    }
%REMEMBER%    %DYNAMICS%
    for (i = 0; i < §JOINTS; i++) {
        const int is_flexible = inverse_rotors[i] > R(0.0);
        const @real tau = own->torque[i].output[2];
        const @real slope = TANH(sharpness[i] * motion[1][1][i]);
        const @real spring_nm = %SPRING%;
        const @real left_nm = smooth(own, 7 * i, tau - spring_nm - motor_nm[i]);
        const @real of_link_nm = smooth(own, 7 * i + 1, spring_nm - link_nm[i]);
        const @real raw[4] = {motion[1][1][i], tau, motion[1][2][i], R(1.0) - slope * slope};
        @real sum = variance[i][0], other_zero_nm = R(0.0);
        int k;
        for (k = 0; k < 4; k++) {
            const @real feature = smooth(own, 7 * i + 2 + k, FABS(raw[k]));
            sum += variance[i][k + 1] * (feature * feature);
        }
        if (is_flexible && own->samples >= §SETTLE
            && !find_zero(&own->zero[i], slope, of_link_nm, left_nm, &other_zero_nm)) {
            sum += zero_nm[i] * zero_nm[i];
        }
        outside_nm[i] = is_flexible
            ? -(of_link_nm + motor_share[i] * left_nm + (R(1.0) - motor_share[i]) * other_zero_nm)
            : -left_nm;
        threshold_nm[i] = threshold_sigma[i] * squared_root(sum);
        /* Infinity minus infinity is not a number, which equals nothing. */
        is_blind = is_blind || !(outside_nm[i] - outside_nm[i] == R(0.0));
        is_blind = is_blind || !(threshold_nm[i] - threshold_nm[i] == R(0.0));
    }
    if (is_blind) {
        own->samples = 0;
%FORGET%        for (i = 0; i < 2 * §JOINTS; i++) {
            struct @zero *zero = &own->zero[i / 2];
            zero->motion_s[i % 2] = zero->link_nm[i % 2] = zero->motor_nm[i % 2] = R(0.0);
        }
    } else if (own->samples <= §SETTLE) {
        own->samples++;
    }
    is_blind = is_blind || own->samples <= §SETTLE;
    for (i = 0; i < §JOINTS && is_blind; i++) {
        outside_nm[i] = threshold_nm[i] = R(0.0);
    }
    return is_blind;
}
