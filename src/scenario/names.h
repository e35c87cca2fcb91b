#pragma once

#include <array>
#include <string_view>
#include <utility>

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

inline constexpr std::array<Spelling<loop::Generator>, 2> kGeneratorNames{
    {{"none", loop::Generator::kNone}, {"joint", loop::Generator::kJoint}}};

inline constexpr std::array<Spelling<reference::FeedForwardTime>, 2> kFeedForwardNames{
    {{"source", reference::FeedForwardTime::kSource},
     {"nominal", reference::FeedForwardTime::kNominal}}};

inline constexpr std::array<Spelling<control::CommandInterface>, 2> kInterfaceNames{
    {{"joint_position", control::CommandInterface::kJointPosition},
     {"joint_velocity", control::CommandInterface::kJointVelocity}}};

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
