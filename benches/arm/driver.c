/*
 * Runs all functions of an exported robot at states by chance and prints the bits of their results. On a
 * microcontroller, it also prints the instructions and the stack of each function.
 *
 * -DPREFIX=arm_ names the robot, -DJOINTS, -DROWS and -DPARAMETERS are its sizes. With -DCONTROL it runs the
 * functions of the controller and of the observer instead. The states come from integers, so that every machine has the same ones.
 */
#include "machine.h"
#include "robot.h"

#define JOIN_(prefix, name) prefix##name
#define JOIN(prefix, name) JOIN_(prefix, name)
#define OWN(name) JOIN(PREFIX, name)

typedef OWN(real) real;

#define STATES 20
#define CALLS 100
#define OF_MATRIX (JOINTS * JOINTS + 4 * JOINTS)
#define OF_REGRESSOR (ROWS * PARAMETERS)
#define RESULTS (OF_MATRIX > OF_REGRESSOR ? OF_MATRIX : OF_REGRESSOR)

static real q[JOINTS], dq[JOINTS], ddq[JOINTS], phi[JOINTS], dphi[JOINTS], ddphi[JOINTS];
static real tau_link[JOINTS], tau_motor[JOINTS], state[4 * JOINTS];
static real results[RESULTS];

#ifdef CONTROL
/* The desired motion: positions, then their derivatives. */
static real desired[5 * JOINTS];
static struct OWN(control) control;

static void feedforward(void)
{
    OWN(feedforward)(desired, desired + JOINTS, desired + 2 * JOINTS, desired + 3 * JOINTS,
        desired + 4 * JOINTS, results, results + JOINTS, results + 2 * JOINTS);
}

static struct OWN(observer) observer;

static void observe(void)
{
    OWN(observe)(&observer, q, phi, tau_motor, results, results + JOINTS);
}

static void control_step(void)
{
    OWN(control_step)(&control, desired, q, phi, results);
}
#else
static void gravity(void)
{
    OWN(gravity)(q, results);
}

static void coriolis(void)
{
    OWN(coriolis)(q, dq, results);
}

static void mass_matrix(void)
{
    OWN(mass_matrix)(q, results);
}

static void spring(void)
{
    OWN(spring)(q, dq, phi, dphi, results);
}

static void friction(void)
{
    OWN(friction)(q, dq, phi, dphi, results, results + JOINTS);
}

static void inverse_dynamics(void)
{
    OWN(inverse_dynamics)(q, dq, ddq, phi, dphi, ddphi, results, results + JOINTS);
}

static void regressor(void)
{
    OWN(regressor)(q, dq, ddq, phi, dphi, ddphi, results);
}

static void forward_dynamics(void)
{
    OWN(forward_dynamics)(q, dq, phi, dphi, tau_link, tau_motor, results, results + JOINTS);
}

static void state_derivative(void)
{
    OWN(state_derivative)(state, tau_motor, results);
}

#endif

static const struct {
    const char *name;
    void (*call)(void);
    int length;
} functions[] = {
#ifdef CONTROL
    {"feedforward", feedforward, 3 * JOINTS},
    {"control_step", control_step, JOINTS},
    {"observe", observe, 2 * JOINTS},
#else
    {"gravity", gravity, JOINTS},
    {"coriolis", coriolis, JOINTS},
    {"mass_matrix", mass_matrix, JOINTS * JOINTS},
    {"spring", spring, JOINTS},
    {"friction", friction, 2 * JOINTS},
    {"inverse_dynamics", inverse_dynamics, 2 * JOINTS},
    {"forward_dynamics", forward_dynamics, 2 * JOINTS},
    {"state_derivative", state_derivative, 4 * JOINTS},
    {"regressor", regressor, OF_REGRESSOR},
#endif
};

#define FUNCTIONS (sizeof functions / sizeof functions[0])

/* Returns a number from -size to size. */
static real by_chance(int size)
{
    static uint32_t seed = 1;
    seed = seed * 1664525u + 1013904223u;
    return (real)size * (real)((int32_t)(seed >> 12) - (1 << 19)) / (real)(1 << 19);
}

static void draw(void)
{
    int i;
    for (i = 0; i < JOINTS; i++) {
        state[i] = q[i] = by_chance(3);
        state[JOINTS + i] = dq[i] = by_chance(2);
        state[2 * JOINTS + i] = phi[i] = q[i] + by_chance(1) / (real)8;
        state[3 * JOINTS + i] = dphi[i] = by_chance(2);
        ddq[i] = by_chance(10);
        ddphi[i] = by_chance(10);
        tau_link[i] = by_chance(10);
        tau_motor[i] = by_chance(10);
    }
#ifdef CONTROL
    for (i = 0; i < JOINTS; i++) {
        desired[i] = q[i] + by_chance(1) / (real)64;
        desired[JOINTS + i] = dq[i];
        desired[2 * JOINTS + i] = ddq[i];
        desired[3 * JOINTS + i] = by_chance(50);
        desired[4 * JOINTS + i] = by_chance(250);
    }
    OWN(control_start)(&control, q, phi, desired);
#endif
}

static void print_bits(real value)
{
    union {
        real value;
        unsigned char bytes[sizeof(real)];
    } own;
    char text[2 * sizeof(real) + 2];
    unsigned at;
    own.value = value;
    text[0] = ' ';
    for (at = 0; at < sizeof(real); at++) {
        const unsigned char byte = own.bytes[sizeof(real) - 1 - at];
        text[1 + 2 * at] = "0123456789abcdef"[byte >> 4];
        text[2 + 2 * at] = "0123456789abcdef"[byte & 15];
    }
    text[1 + 2 * sizeof(real)] = '\0';
    print(text);
}

#ifdef __arm__
static void print_whole(uint32_t value)
{
    char text[12];
    int at = 11;
    text[at] = '\0';
    do {
        text[--at] = (char)('0' + value % 10);
        value /= 10;
    } while (value > 0);
    text[--at] = ' ';
    print(text + at);
}

static void print_costs(void)
{
    unsigned at;
    begin_count();
    loop(1000000);
    print("loop");
    print_whole(count());
    print("\n");
    for (at = 0; at < FUNCTIONS; at++) {
        int call;
        uint32_t instructions;
        begin_count();
        for (call = 0; call < CALLS; call++) {
            functions[at].call();
        }
        instructions = count() / CALLS;
        print("cost ");
        print(functions[at].name);
        print_whole(instructions);
        print_whole(stack_of(functions[at].call));
        print("\n");
    }
}
#else
#include <stdio.h>

void print(const char *text)
{
    fputs(text, stdout);
}
#endif

int main(void)
{
    int drawn, i;
    unsigned at;
    for (drawn = 0; drawn < STATES; drawn++) {
        draw();
        for (at = 0; at < FUNCTIONS; at++) {
            functions[at].call();
            print("result ");
            print(functions[at].name);
            for (i = 0; i < functions[at].length; i++) {
                print_bits(results[i]);
            }
            print("\n");
        }
    }
#ifdef __arm__
    print_costs();
#endif
    return 0;
}
