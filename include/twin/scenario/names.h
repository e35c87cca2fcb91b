#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "twin/core/quantity.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {

/// The spelling of an enumerator in scenarios, for reader and writer.
template <typename Enum>
using Spelling = std::pair<std::string_view, Enum>;

inline constexpr std::array<Spelling<plant::HandKind>, 3> kHandNames{
    {{"franka_hand", plant::HandKind::kFrankaHand},
     {"cobot_pump", plant::HandKind::kCobotPump},
     {"none", plant::HandKind::kNone}}};

inline constexpr std::array<Spelling<robot::PlantKind>, 2> kPlantNames{
    {{"mujoco", robot::PlantKind::kMujoco}, {"ideal", robot::PlantKind::kIdeal}}};

inline constexpr std::array<Spelling<plant::FrictionProfile>, 3> kFrictionNames{
    {{"none", plant::FrictionProfile::kNone},
     {"residual", plant::FrictionProfile::kResidual},
     {"breakaway", plant::FrictionProfile::kBreakaway}}};

inline constexpr std::array<Spelling<plant::ElasticityProfile>, 2> kElasticityNames{
    {{"rigid", plant::ElasticityProfile::kRigid}, {"static", plant::ElasticityProfile::kStatic}}};

inline constexpr std::array<Spelling<plant::ForceFrame>, 2> kForceFrameNames{
    {{"world", plant::ForceFrame::kWorld}, {"body", plant::ForceFrame::kBody}}};

inline constexpr std::array<Spelling<ControllerMode>, 2> kControllerNames{
    {{"joint_impedance", ControllerMode::kJointImpedance},
     {"cartesian_impedance", ControllerMode::kCartesianImpedance}}};

inline constexpr std::array<Spelling<plant::ObjectShape>, 3> kObjectShapeNames{
    {{"box", plant::ObjectShape::kBox},
     {"cylinder", plant::ObjectShape::kCylinder},
     {"sphere", plant::ObjectShape::kSphere}}};

inline constexpr std::array<Spelling<Drive>, 2> kDriveNames{
    {{"lockstep", Drive::kLockstep}, {"realtime", Drive::kRealtime}}};

inline constexpr std::array<Spelling<loop::LoopKind>, 3> kLoopNames{
    {{"asynchronous", loop::LoopKind::kAsynchronous},
     {"synchronous", loop::LoopKind::kSynchronous},
     {"bare", loop::LoopKind::kBare}}};

inline constexpr std::array<Spelling<loop::Generator>, 4> kGeneratorNames{
    {{"none", loop::Generator::kNone},
     {"joint", loop::Generator::kJoint},
     {"rejoining", loop::Generator::kRejoining},
     {"cartesian", loop::Generator::kCartesian}}};

inline constexpr std::array<Spelling<reference::FeedForwardTime>, 2> kFeedForwardNames{
    {{"source", reference::FeedForwardTime::kSource},
     {"nominal", reference::FeedForwardTime::kNominal}}};

inline constexpr std::array<Spelling<control::CommandInterface>, 4> kInterfaceNames{
    {{"joint_position", control::CommandInterface::kJointPosition},
     {"joint_velocity", control::CommandInterface::kJointVelocity},
     {"cartesian_pose", control::CommandInterface::kCartesianPose},
     {"torque", control::CommandInterface::kTorque}}};

/// The cut-off frequency at which a low-pass, of the tick or of the robot, is off, Hz.
inline constexpr double kLowPassOff = 1000;

/// @returns what an interface's values measure.
[[nodiscard]] constexpr Dimension DimensionOf(control::CommandInterface interface) {
  switch (interface) {
    case control::CommandInterface::kJointPosition: return Dimension::kAngle;
    case control::CommandInterface::kJointVelocity: return Dimension::kAngularVelocity;
    case control::CommandInterface::kCartesianPose: return Dimension::kLength;
    case control::CommandInterface::kTorque: return Dimension::kTorque;
  }
  return Dimension::kAngle;
}

/// @returns the spelling of `value`. @pre the table has it.
template <typename Enum, std::size_t N>
[[nodiscard]] constexpr std::string_view NameOf(const std::array<Spelling<Enum>, N>& names,
                                                Enum value) {
  for (const auto& [name, candidate] : names) {
    if (candidate == value) return name;
  }
  return {};
}

}  // namespace twin::scenario
