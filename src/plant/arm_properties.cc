#include "twin/plant/arm_properties.h"

#include <string>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "plant/thickness.h"
#include "twin/core/error.h"

namespace twin::plant {

void RequireThickness(const std::string& body, const Matrix3& inertia) {
  const Eigen::Map<const Eigen::Matrix3d> I(inertia.data());
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
  if (moments[0] > 0) return;
  throw InputError(fmt::format(
      "{}: its least principal moment of inertia is {} kg m^2, that of a rod without thickness; it "
      "must be above 0",
      body, moments[0]));
}

JointVector RotorInertia(bool has_armature, const ArmProperties& arm) {
  return has_armature ? arm.armature.value_or(kArmature) : JointVector{};
}

static void ValidateLinks(const std::vector<setting::Load>& links) {
  if (links.empty()) return;
  if (links.size() != kJoints) {
    throw InputError(fmt::format("links: {} of them; give all {}, or none", links.size(), kJoints));
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    const std::string name = fmt::format("links[{}]", i + 1);
    if (const auto bad = FindBadValue(links[i])) {
      throw InputError(fmt::format("{}: {}", name, Describe(*bad)));
    }
    if (!(links[i].m_load > 0)) throw InputError(name + ": a link has a mass; give one above 0");
    RequireThickness(name, links[i].I_load);
  }
}

void Validate(const ArmProperties& arm, bool has_armature) {
  const JointVector armature = RotorInertia(has_armature, arm);
  for (std::size_t i = 0; i < kJoints; ++i) {
    RequireInRange(fmt::format("armature of joint {}, kg m^2", i + 1), armature[i], 0, 10);
    RequireInRange(fmt::format("elasticity of joint {}, Nm/rad", i + 1), arm.stiffness[i], 1, 1e7);
  }
  if (arm.friction_law) Validate(*arm.friction_law, armature);
  RequireInRange("delay.tau_J, s", ToSeconds(arm.torque_delay), 0, ToSeconds(kLongestTorqueDelay));
  ValidateLinks(arm.links);
}

}  // namespace twin::plant
