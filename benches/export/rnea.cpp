// Times the exported inverse dynamics of a robot beside Pinocchio's rnea, and compares their torques.
//
//     rnea < NUMBERS
//
// For each joint, which turns about its z axis, the input has the rotation by rows and the origin in the
// frame of the joint before it, ten inertial parameters in Pinocchio's order, and the rotor inertia. Compiled with -DPREFIX=arm_ -DJOINTS=7 and robot.c. Prints the nanoseconds of a call of both, medians of
// rounds in turn, and the largest relative difference of the torques.
#include "robot.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>

#define JOIN_(prefix, name) prefix##name
#define JOIN(prefix, name) JOIN_(prefix, name)
#define OWN(name) JOIN(PREFIX, name)

namespace {

constexpr int STATES = 500, ROUNDS = 41, REPEATS = 20;

using Vector = Eigen::VectorXd;

struct State {
    Vector q, dq, ddq, phi, dphi, ddphi;
};

struct Torques {
    double link[JOINTS], motor[JOINTS];
};

void exported(const State &own, Torques &torques)
{
    OWN(inverse_dynamics)(own.q.data(), own.dq.data(), own.ddq.data(), own.phi.data(), own.dphi.data(),
        own.ddphi.data(), torques.link, torques.motor);
}

// Returns the nanoseconds of a call.
template <class Call> double time_of(const std::vector<State> &states, Call call)
{
    const auto begin = std::chrono::steady_clock::now();
    for (int repeat = 0; repeat < REPEATS; repeat++) {
        for (const State &state : states) {
            call(state);
        }
    }
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - begin;
    return taken.count() / (REPEATS * STATES);
}

double median(std::vector<double> times)
{
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

}

int main()
{
    pinocchio::Model model;
    Vector rotors(JOINTS);
    for (int i = 0; i < JOINTS; i++) {
        double numbers[23];
        for (double &number : numbers) {
            if (std::scanf("%lf", &number) != 1) {
                std::printf("the input ends in joint %d\n", i);
                return 1;
            }
        }
        const pinocchio::SE3 place(
            Eigen::Matrix<double, 3, 3, Eigen::RowMajor>(numbers), Eigen::Vector3d(numbers + 9));
        const Eigen::Matrix<double, 10, 1> body(numbers + 12);
        const auto joint = model.addJoint(i, pinocchio::JointModelRZ(), place, std::to_string(i));
        model.appendBodyToJoint(joint, pinocchio::Inertia::FromDynamicParameters(body), pinocchio::SE3::Identity());
        rotors[i] = numbers[22];
    }
    pinocchio::Data data(model);

    std::mt19937 random(1);
    const auto draw = [&random](double size) {
        std::uniform_real_distribution<double> uniform(-size, size);
        Vector values(JOINTS);
        for (double &value : values) {
            value = uniform(random);
        }
        return values;
    };
    std::vector<State> states;
    for (int i = 0; i < STATES; i++) {
        State own{draw(3.0), draw(2.0), draw(10.0), {}, {}, {}};
        own.phi = own.q + draw(0.1);
        own.dphi = draw(2.0);
        own.ddphi = draw(10.0);
        states.push_back(own);
    }

    // Springs act on link and motor and are not part of the sum. A rigid joint has the rotor's motion.
    double difference = 0.0, largest = 0.0;
    for (State &own : states) {
        Torques torques;
        double link[JOINTS], motor[JOINTS], spring[JOINTS];
        OWN(spring)(own.q.data(), own.dq.data(), own.phi.data(), own.dphi.data(), spring);
        for (int i = 0; i < JOINTS; i++) {
            if (spring[i] == 0.0) {
                own.phi[i] = own.q[i];
                own.dphi[i] = own.dq[i];
                own.ddphi[i] = own.ddq[i];
            }
        }
        exported(own, torques);
        OWN(friction)(own.q.data(), own.dq.data(), own.phi.data(), own.dphi.data(), link, motor);
        const Vector &known = pinocchio::rnea(model, data, own.q, own.dq, own.ddq);
        for (int i = 0; i < JOINTS; i++) {
            const double found = torques.link[i] + torques.motor[i] - link[i] - motor[i] - rotors[i] * own.ddphi[i];
            difference = std::max(difference, std::abs(found - known[i]));
            largest = std::max(largest, std::abs(known[i]));
        }
    }

    // The same work: Pinocchio adds the rotors of rigid joints.
    model.armature = rotors;
    std::vector<double> of_code, of_pinocchio;
    volatile double sink = 0.0;
    for (int round = 0; round < ROUNDS; round++) {
        of_code.push_back(time_of(states, [&](const State &own) {
            Torques torques;
            exported(own, torques);
            sink = torques.motor[0];
        }));
        of_pinocchio.push_back(time_of(states, [&](const State &own) {
            sink = pinocchio::rnea(model, data, own.q, own.dq, own.ddq)[0];
        }));
    }
    (void)sink;
    std::printf("%.1f %.1f %.1e\n", median(of_code), median(of_pinocchio), difference / largest);
    return 0;
}
