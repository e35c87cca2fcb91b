#pragma once

#include <array>
#include <span>
#include <vector>

#include "twin/scenario/names.h"
#include "scenario/yaml_node.h"
#include "twin/core/time.h"
#include "twin/scenario/scenario.h"

// Readers of a scenario's sections. All: @throws InputError naming file, line and key.
namespace twin::scenario {

/// The latest a scenario may name.
inline constexpr Duration kDay = std::chrono::hours(24);

template <typename Enum, std::size_t N>
[[nodiscard]] Enum ReadChoice(const YamlNode& node, const std::array<Spelling<Enum>, N>& names) {
  return node.Choice(std::span<const Spelling<Enum>>(names));
}

/// Clock drift, ppm.
[[nodiscard]] double ReadDrift(const YamlNode& node);

/// "off" (kLowPassOff), or a low-pass's cut-off frequency, Hz.
[[nodiscard]] double ReadCutoff(const YamlNode& node);

/// A name that only a run can judge, and where it stands.
[[nodiscard]] std::string ReadName(const YamlNode& node, Place& place);

/// {mass: 1 kg, position: [x, y, z], inertia: [xx, yy, zz], products_of_inertia: [xy, xz, yz]}, the
/// last three zero unless given.
[[nodiscard]] setting::Load ReadLoad(const YamlNode& node);

/// {position: [x, y, z], rpy: [roll, pitch, yaw]}, each zero unless given.
[[nodiscard]] FramePose ReadFrame(const YamlNode& node);

/// Fails at the node with what is wrong with the setting, if anything is.
void RequireValid(const YamlNode& node, const Setting& setting);

void ReadRobot(const YamlNode& node, Scenario& scenario);
void ReadBase(const YamlNode& node, Scenario& scenario);
void ReadPlant(const YamlNode& node, PlantSection& plant);
void ReadOnboard(const YamlNode& node, OnboardSection& onboard);
[[nodiscard]] std::vector<plant::Perturbation> ReadPerturbations(const YamlNode& node);
[[nodiscard]] std::vector<ObjectSection> ReadObjects(const YamlNode& node);
[[nodiscard]] std::vector<robot::PanelEvent> ReadPanel(const YamlNode& node);
[[nodiscard]] std::vector<HandEvent> ReadHand(const YamlNode& node);
void ReadOperator(const YamlNode& node, Scenario& scenario);
void ReadRender(const YamlNode& node, RenderSection& render);

}  // namespace twin::scenario
