// Pinocchio's side of `cargo xtask bench pinocchio`: reads a chain and its joint states from
// standard input, then answers one command a line on standard output.
//
//   chain N      N lines: R|P, rotation by rows and position before the joint,
//                mass, center of mass, inertia about it (xx xy xz yy yz zz)
//   states M     M lines: positions, velocities, accelerations
//   results jacobian|rnea    M lines of numbers
//   run jacobian|rnea P      nanoseconds of the thread's CPU time a state: one pass over all states
//                            that does not count, then P passes
//
// Meters, radians, kilograms. The Jacobian is the last joint's frame's, in the directions of the
// world, linear above angular. Pinocchio's algorithms are templates and are compiled here, with
// the instructions this program is compiled for, and not taken from its library of the baseline.
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>
#include <pinocchio/multibody/joint.hpp>

#include <cstddef>
#include <cstdlib>
#include <ctime>
#include <iomanip>
#include <iostream>
#include <string>
#include <vector>

namespace pin = pinocchio;

namespace {

struct State {
    Eigen::VectorXd q, v, a;
};

// The compiler has to believe that somebody looks at the numbers.
template <typename Numbers>
void keep(const Numbers &numbers) {
    asm volatile("" : : "r"(numbers.data()) : "memory");
}

[[noreturn]] void refuse(const std::string &what) {
    std::cerr << "pinocchio peer: " << what << '\n';
    std::exit(2);
}

double number() {
    double value = 0.0;
    if (!(std::cin >> value)) {
        refuse("a number was expected");
    }
    return value;
}

std::size_t expect(const std::string &word) {
    std::string found;
    std::size_t count = 0;
    if (!(std::cin >> found >> count) || found != word) {
        refuse("expected '" + word + " N', found '" + found + "'");
    }
    return count;
}

pin::Model read_chain() {
    pin::Model model;
    pin::JointIndex parent = 0;
    const std::size_t joints = expect("chain");
    for (std::size_t joint = 0; joint < joints; ++joint) {
        std::string kind;
        std::cin >> kind;
        pin::SE3 before;
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                before.rotation()(row, column) = number();
            }
        }
        for (int row = 0; row < 3; ++row) {
            before.translation()[row] = number();
        }
        const double mass = number();
        Eigen::Vector3d center;
        for (int row = 0; row < 3; ++row) {
            center[row] = number();
        }
        Eigen::Matrix3d inertia;
        for (int row = 0; row < 3; ++row) {
            for (int column = row; column < 3; ++column) {
                inertia(row, column) = inertia(column, row) = number();
            }
        }
        const std::string name = "joint" + std::to_string(joint + 1);
        if (kind == "R") {
            parent = model.addJoint(parent, pin::JointModelRZ(), before, name);
        } else if (kind == "P") {
            parent = model.addJoint(parent, pin::JointModelPZ(), before, name);
        } else {
            refuse("a joint is R or P, not '" + kind + "'");
        }
        model.appendBodyToJoint(parent, pin::Inertia(mass, center, inertia), pin::SE3::Identity());
    }
    model.gravity.linear() = Eigen::Vector3d(0.0, 0.0, -9.80665);
    return model;
}

std::vector<State> read_states(Eigen::Index joints) {
    std::vector<State> states(expect("states"));
    for (State &state : states) {
        for (Eigen::VectorXd *part : {&state.q, &state.v, &state.a}) {
            part->resize(joints);
            for (Eigen::Index joint = 0; joint < joints; ++joint) {
                (*part)[joint] = number();
            }
        }
    }
    return states;
}

struct Peer {
    pin::Model model = read_chain();
    pin::Data data{model};
    std::vector<State> states = read_states(model.nq);
    pin::Data::Matrix6x jacobian{6, model.nv};

    const pin::Data::Matrix6x &jacobian_at(const State &state) {
        pin::computeJointJacobians(model, data, state.q);
        // All joints are on the way to the last one: every column is written.
        pin::getJointJacobian(model, data, static_cast<pin::JointIndex>(model.njoints - 1),
                              pin::LOCAL_WORLD_ALIGNED, jacobian);
        return jacobian;
    }

    const Eigen::VectorXd &torques_at(const State &state) {
        return pin::rnea(model, data, state.q, state.v, state.a);
    }

    template <typename Each>
    void results(Each each) {
        for (const State &state : states) {
            const auto &numbers = each(state);
            for (Eigen::Index index = 0; index < numbers.size(); ++index) {
                std::cout << (index == 0 ? "" : " ") << numbers.data()[index];
            }
            std::cout << '\n';
        }
        std::cout.flush();
    }

    template <typename Each>
    void pass(Each each) {
        for (const State &state : states) {
            keep(each(state));
        }
    }

    template <typename Each>
    void run(Each each) {
        std::size_t passes = 0;
        if (!(std::cin >> passes) || passes == 0) {
            refuse("run: how many passes?");
        }
        pass(each);
        const double begun = cpu_seconds();
        for (std::size_t done = 0; done < passes; ++done) {
            pass(each);
        }
        const double used = cpu_seconds() - begun;
        std::cout << used * 1e9 / static_cast<double>(states.size() * passes) << std::endl;
    }

    static double cpu_seconds() {
        timespec now{};
        if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) != 0) {
            refuse("there is no clock of the thread's CPU time");
        }
        return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
    }
};

} // namespace

int main() {
    std::ios::sync_with_stdio(false);
    std::cout << std::setprecision(17);
    Peer peer;
    peer.jacobian.setZero();
    const auto jacobian = [&](const State &state) -> const auto & { return peer.jacobian_at(state); };
    const auto torques = [&](const State &state) -> const auto & { return peer.torques_at(state); };
    std::string command;
    std::string what;
    while (std::cin >> command >> what) {
        if (command == "results" && what == "jacobian") {
            peer.results(jacobian);
        } else if (command == "results" && what == "rnea") {
            peer.results(torques);
        } else if (command == "run" && what == "jacobian") {
            peer.run(jacobian);
        } else if (command == "run" && what == "rnea") {
            peer.run(torques);
        } else {
            refuse("there is no command '" + command + " " + what + "'");
        }
    }
}
