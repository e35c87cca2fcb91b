#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "scenario/quantity.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {

/// How scenarios spell their choices; used by reader and writer alike.
template <typename Enum>
using Spelling = std::pair<std::string_view, Enum>;

inline constexpr std::array<Spelling<plant::HandKind>, 2> kHandNames{
    {{"franka_hand", plant::HandKind::kFrankaHand}, {"none", plant::HandKind::kNone}}};

inline constexpr std::array<Spelling<robot::PlantKind>, 2> kPlantNames{
    {{"mujoco", robot::PlantKind::kMujoco}, {"ideal", robot::PlantKind::kIdeal}}};

inline constexpr std::array<Spelling<plant::FrictionProfile>, 3> kFrictionNames{
    {{"none", plant::FrictionProfile::kNone},
     {"residual", plant::FrictionProfile::kResidual},
     {"breakaway", plant::FrictionProfile::kBreakaway}}};

inline constexpr std::array<Spelling<Drive>, 2> kDriveNames{
    {{"lockstep", Drive::kLockstep}, {"realtime", Drive::kRealtime}}};

inline constexpr std::array<Spelling<loop::LoopKind>, 3> kLoopNames{
    {{"asynchronous", loop::LoopKind::kAsynchronous},
     {"synchronous", loop::LoopKind::kSynchronous},
     {"bare", loop::LoopKind::kBare}}};

inline constexpr std::array<Spelling<loop::Generator>, 2> kGeneratorNames{
    {{"none", loop::Generator::kNone}, {"joint", loop::Generator::kJoint}}};

inline constexpr std::array<Spelling<reference::FeedForwardTime>, 2> kFeedForwardNames{
    {{"source", reference::FeedForwardTime::kSource},
     {"nominal", reference::FeedForwardTime::kNominal}}};

inline constexpr std::array<Spelling<control::CommandInterface>, 3> kInterfaceNames{
    {{"joint_position", control::CommandInterface::kJointPosition},
     {"joint_velocity", control::CommandInterface::kJointVelocity},
     {"torque", control::CommandInterface::kTorque}}};

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
