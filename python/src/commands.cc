#include "commands.h"

#include <new>

#include "arrays.h"
#include "bindings.h"

namespace twin::python {
namespace {

/// A class of one array and `finished`. @param from  reads the array, which `what` names.
template <typename Command, auto Member, typename Read>
void AddCommand(nb::module_& module, const char* name, const char* member, const char* what,
                Read from, const char* doc) {
  nb::class_<Command>(module, name, doc)
      .def(
          "__init__",
          [what, from](Command* self, const ArrayLike& values, bool finished) {
            new (self) Command;
            self->*Member = from(values, what);
            self->finished = finished;
          },
          nb::arg(member), nb::arg("finished") = false)
      .def_prop_rw(
          member, [](const Command& self) { return ArrayOf(self.*Member); },
          [what, from](Command& self, const ArrayLike& values) {
            self.*Member = from(values, what);
          })
      .def_rw("finished", &Command::finished, "The motion ends with this command.");
}

}  // namespace

void AddCommands(nb::module_& module) {
  AddCommand<Torques, &Torques::tau_J>(
      module, "Torques", "tau_J", "Torques: tau_J, Nm", &JointsFrom,
      "Joint torques tau_J, shape (7,), Nm, without gravity and friction, which the robot adds.");
  AddCommand<JointPositions, &JointPositions::q>(module, "JointPositions", "q",
                                                 "JointPositions: q, rad", &JointsFrom,
                                                 "Joint positions q, shape (7,), rad.");
  AddCommand<JointVelocities, &JointVelocities::dq>(module, "JointVelocities", "dq",
                                                    "JointVelocities: dq, rad/s", &JointsFrom,
                                                    "Joint velocities dq, shape (7,), rad/s.");
  AddCommand<CartesianPose, &CartesianPose::O_T_EE>(
      module, "CartesianPose", "O_T_EE", "CartesianPose: O_T_EE", &PoseFrom,
      "Pose O_T_EE of the end effector in the base, shape (4, 4), m.");
  AddCommand<CartesianVelocities, &CartesianVelocities::O_dP_EE>(
      module, "CartesianVelocities", "O_dP_EE", "CartesianVelocities: O_dP_EE, m/s and rad/s",
      &Vector6From,
      "Twist O_dP_EE = [v, w] of the end effector, base axes, shape (6,), m/s and rad/s. It is "
      "integrated to poses, which the robot gets.");
}

}  // namespace twin::python
