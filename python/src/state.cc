#include "twin/core/robot_state.h"

#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.h"
#include "bindings.h"
#include "state.h"

namespace twin::python {
namespace {

using State = nb::class_<RobotState>;

template <auto Member>
void AddArray(State& state, const char* name, const char* doc) {
  state.def_prop_ro(
      name, [](const RobotState& self) { return ArrayOf(self.*Member); }, doc);
}

void AddPoses(State& state) {
  AddArray<&RobotState::O_T_EE>(state, "O_T_EE", "(4, 4): measured pose of the end effector, m.");
  AddArray<&RobotState::O_T_EE_d>(state, "O_T_EE_d", "(4, 4): desired pose of it, m.");
  AddArray<&RobotState::O_T_EE_c>(state, "O_T_EE_c", "(4, 4): last commanded pose of it, m.");
  AddArray<&RobotState::F_T_EE>(state, "F_T_EE", "(4, 4): end effector in the flange, m.");
  AddArray<&RobotState::EE_T_K>(state, "EE_T_K", "(4, 4): stiffness frame in the end effector.");
  AddArray<&RobotState::F_T_NE>(state, "F_T_NE", "(4, 4): nominal end effector in the flange.");
  AddArray<&RobotState::NE_T_EE>(state, "NE_T_EE", "(4, 4): end effector in the nominal one.");
  AddArray<&RobotState::elbow>(state, "elbow", "(2,): q3, rad, and the sign of the flip.");
  AddArray<&RobotState::elbow_d>(state, "elbow_d", "(2,): desired.");
  AddArray<&RobotState::elbow_c>(state, "elbow_c", "(2,): last commanded.");
  AddArray<&RobotState::delbow_c>(state, "delbow_c", "(2,): its velocity, rad/s.");
  AddArray<&RobotState::ddelbow_c>(state, "ddelbow_c", "(2,): its acceleration, rad/s^2.");
  AddArray<&RobotState::O_dP_EE_d>(state, "O_dP_EE_d", "(6,): desired twist, m/s and rad/s.");
  AddArray<&RobotState::O_dP_EE_c>(state, "O_dP_EE_c", "(6,): last commanded twist.");
  AddArray<&RobotState::O_ddP_EE_c>(state, "O_ddP_EE_c", "(6,): its derivative.");
  AddArray<&RobotState::O_ddP_O>(state, "O_ddP_O", "(3,): gravity in the base, m/s^2.");
}

void AddJoints(State& state) {
  AddArray<&RobotState::q>(state, "q", "(7,): measured joint positions, rad.");
  AddArray<&RobotState::q_d>(state, "q_d", "(7,): desired, rad.");
  AddArray<&RobotState::dq>(state, "dq", "(7,): measured joint velocities, rad/s.");
  AddArray<&RobotState::dq_d>(state, "dq_d", "(7,): desired, rad/s.");
  AddArray<&RobotState::ddq_d>(state, "ddq_d", "(7,): desired accelerations, rad/s^2.");
  AddArray<&RobotState::tau_J>(state, "tau_J", "(7,): measured link-side torques, Nm.");
  AddArray<&RobotState::tau_J_d>(state, "tau_J_d", "(7,): desired, without gravity, Nm.");
  AddArray<&RobotState::dtau_J>(state, "dtau_J", "(7,): derivative of tau_J, Nm/s.");
  AddArray<&RobotState::theta>(state, "theta", "(7,): motor positions, rad.");
  AddArray<&RobotState::dtheta>(state, "dtheta", "(7,): motor velocities, rad/s.");
  AddArray<&RobotState::accelerometer_top>(
      state, "accelerometer_top",
      "(18,): of an FR3, x, y, z of the links 0 to 5, m/s^2; zero for a Panda.");
  AddArray<&RobotState::accelerometer_bottom>(state, "accelerometer_bottom",
                                              "(18,): the same at the other end.");
}

void AddForces(State& state) {
  AddArray<&RobotState::joint_contact>(state, "joint_contact", "(7,): contact levels.");
  AddArray<&RobotState::cartesian_contact>(state, "cartesian_contact", "(6,): contact levels.");
  AddArray<&RobotState::joint_collision>(state, "joint_collision", "(7,): collision levels.");
  AddArray<&RobotState::cartesian_collision>(state, "cartesian_collision",
                                             "(6,): collision levels.");
  AddArray<&RobotState::tau_ext_hat_filtered>(state, "tau_ext_hat_filtered",
                                              "(7,): external torques, filtered, Nm.");
  AddArray<&RobotState::O_F_ext_hat_K>(state, "O_F_ext_hat_K",
                                       "(6,): external wrench at K, base axes, N and Nm.");
  AddArray<&RobotState::K_F_ext_hat_K>(state, "K_F_ext_hat_K", "(6,): the same in K's axes.");
}

void AddLoads(State& state) {
  state.def_ro("m_ee", &RobotState::m_ee, "Mass of the end effector, kg.");
  AddArray<&RobotState::I_ee>(state, "I_ee", "(3, 3): its inertia, kg m^2.");
  AddArray<&RobotState::F_x_Cee>(state, "F_x_Cee", "(3,): its centre of mass in the flange, m.");
  state.def_ro("m_load", &RobotState::m_load, "Mass of the load, kg.");
  AddArray<&RobotState::I_load>(state, "I_load", "(3, 3): its inertia, kg m^2.");
  AddArray<&RobotState::F_x_Cload>(state, "F_x_Cload", "(3,): its centre of mass, m.");
}

}  // namespace

std::vector<std::string> NamesOf(const RobotErrors& errors) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (errors.test(i)) names.emplace_back(Name(static_cast<RobotError>(i)));
  }
  return names;
}

void AddState(nb::module_& module) {
  State state(module, "RobotState",
              "A robot state, as the robot sends one each millisecond. Names, units and frames are "
              "Franka's: O is the base, F the flange, EE the end effector, K the stiffness frame; "
              "_d is desired, _c last commanded. Every read of a field gives an array of its own.");
  state.def_ro("message_id", &RobotState::message_id, "Cycles since the robot was started.");
  state.def_prop_ro(
      "time", [](const RobotState& self) { return 1e-3 * static_cast<double>(self.message_id); },
      "Of the robot, s: 1 ms per message_id.");
  AddPoses(state);
  AddJoints(state);
  AddForces(state);
  AddLoads(state);
  state.def_prop_ro(
      "robot_mode", [](const RobotState& self) { return std::string(Name(self.robot_mode)); },
      "\"Idle\", \"Move\", \"Reflex\", ...");
  state.def_prop_ro("controller_mode",
                    [](const RobotState& self) { return std::string(Name(self.controller_mode)); });
  state.def_prop_ro("motion_generator_mode", [](const RobotState& self) {
    return std::string(Name(self.motion_generator_mode));
  });
  state.def_prop_ro(
      "errors", [](const RobotState& self) { return NamesOf(self.errors); },
      "Names of the present errors.");
  state.def_prop_ro(
      "reflex_reason", [](const RobotState& self) { return NamesOf(self.reflex_reason); },
      "Names of the errors that ended the last motion.");
  state.def_ro("control_command_success_rate", &RobotState::control_command_success_rate,
               "Share of the last 100 commands received; 0 without a motion.");
  state.def("__repr__", [](const RobotState& self) {
    return fmt::format(
        "<RobotState {}: {}, q [{:.4f}] rad{}>", self.message_id, Name(self.robot_mode),
        fmt::join(self.q, ", "),
        self.errors.none() ? "" : ", " + fmt::format("{}", fmt::join(NamesOf(self.errors), ", ")));
  });
}

}  // namespace twin::python
