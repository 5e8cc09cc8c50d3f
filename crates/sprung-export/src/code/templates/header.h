/*
 * Dynamics of the robot. Positions of revolute joints are in rad, of prismatic joints in m; torques in
 * N*m or N. phi is the position of a motor after the gear. At rigid joints phi, dphi and ddphi are not
 * read: the motor moves with its link.
 *
 * Joints:
%JOINTS% *
 * The regressor has a row for each joint: the torque on the link, or at a rigid joint the torque of the
 * motor. A row for each motor behind a spring follows, in the order of the joints. Its columns belong to
 * the parameters theta:
%NAMES% *
 * Compile robot.c with -std=c99 and link the library of mathematics. With -DSPRUNG_FLOAT, all numbers
 * are float. No function allocates memory, keeps a state or divides by zero.
 */
#ifndef §H
#define §H

#ifdef __cplusplus
extern "C" {
#endif

#define §JOINTS %N%

/* Size of the regressor. */
#define §ROWS %ROWS%
#define §PARAMETERS %PARAMETERS%

#ifdef SPRUNG_FLOAT
typedef float @real;
#else
typedef double @real;
#endif

/* Identified parameters: the columns of the regressor. */
extern const @real @theta[§PARAMETERS];

%FUNCTIONS%/*
 * Accelerations by the torques of the motors and torques on the links from outside.
 */
void @forward_dynamics(const @real q_rad[§JOINTS],
    const @real dq_rad_per_s[§JOINTS],
    const @real phi_rad[§JOINTS],
    const @real dphi_rad_per_s[§JOINTS],
    const @real tau_link_nm[§JOINTS],
    const @real tau_motor_nm[§JOINTS],
    @real ddq_rad_per_s2[§JOINTS],
    @real ddphi_rad_per_s2[§JOINTS]);

/*
 * Derivative of the state q, dq, phi, dphi (each all joints) by time, without torques from outside.
 */
void @state_derivative(const @real state[4 * §JOINTS],
    const @real tau_motor_nm[§JOINTS],
    @real derivative[4 * §JOINTS]);

%CONTROLLER%#ifdef __cplusplus
}
#endif

#endif
