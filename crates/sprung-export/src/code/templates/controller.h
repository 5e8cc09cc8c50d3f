/*
 * The controller, for samples that are %PERIOD% s apart. It shapes the desired motion, estimates
 * velocities, adds the feedback to the feedforward and limits the torques.
%HEADER% */

/* The desired motion of %WHOSE%: positions, then their time derivatives up to the fourth. */
#define §DESIRED (5 * §JOINTS)

/* Samples that the estimators of velocities and the shaper remember. */
#define §MEASURED %MEASURED%
#define §SHAPED %SHAPED%

/* Memory of the controller. One of zeros has not been started. */
struct @control {
    @real positions[§MEASURED][2 * §JOINTS];
    @real desired[§SHAPED][§DESIRED];
    int newest_position;
    int newest_desired;
    int is_running;
%MEMORY_FIELD%};

/*
 * Starts the controller of a robot that rests at q and phi, and whose desired motion rests at the first
 * §JOINTS numbers of desired. Returns 0, or 1 if a number is not finite: it is then not started.
 */
int @control_start(struct @control *own,
    const @real q_rad[§JOINTS],
    const @real phi_rad[§JOINTS],
    const @real desired[§JOINTS]);

/*
 * Computes the torques of the motors, once a sample. It stops when a number is not finite: from this
 * sample on, until it is started again, it returns 1 and all torques are zero. Otherwise it returns 0.
 */
int @control_step(struct @control *own,
    const @real desired[§DESIRED],
    const @real q_rad[§JOINTS],
    const @real phi_rad[§JOINTS],
    @real tau_nm[§JOINTS]);

