#pragma once

#include "twin/core/joint_vector.h"

// What a law returns, one type per interface, as libfranka has them.
namespace twin::python {

struct Torques {
  JointVector tau_J{};
  bool finished = false;
};
struct JointPositions {
  JointVector q{};
  bool finished = false;
};
struct JointVelocities {
  JointVector dq{};
  bool finished = false;
};
struct CartesianPose {
  Transform O_T_EE = kIdentityTransform;
  bool finished = false;
};
struct CartesianVelocities {
  Vector6 O_dP_EE{};
  bool finished = false;
};

}  // namespace twin::python
