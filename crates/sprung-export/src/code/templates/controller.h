/*
 * The controller, for samples that are %PERIOD% s apart. It shapes the desired motion, computes the
 * feedforward and the velocities, adds the feedback and limits the torques.
 */

/* The desired motion: positions of all links, then their time derivatives up to the fourth. */
#define §WANTED (5 * §JOINTS)

/* Samples that the estimators of velocities and the shaper remember. */
#define §MEASURED %MEASURED%
#define §SHAPED %SHAPED%

/* Memory of the controller. */
struct @controller {
    @real positions[§MEASURED][2 * §JOINTS];
    @real wanted[§SHAPED][§WANTED];
    int newest_position;
    int newest_wanted;
    int is_started;
    int is_stopped;
};

/*
 * Prepares for the first sample, before which the robot rests at the first positions. A controller that
 * has stopped works again.
 */
void @start(struct @controller *own);

/*
 * Computes the torques of the motors, once a sample. It stops when a number is not finite: from this
 * sample on, until @start is called, it returns 1 and all torques are zero. Otherwise it returns 0.
 */
int @control(struct @controller *own,
    const @real wanted[§WANTED],
    const @real q_rad[§JOINTS],
    const @real phi_rad[§JOINTS],
    @real tau_nm[§JOINTS]);

