#pragma once

#include <string_view>

#include "scenario/yaml_node.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {

/// Longest delay a scenario may ask for.
inline constexpr Duration kLongestDelay = std::chrono::seconds(10);

/// Reads a delay in any of its forms:
///   80 us                                                       always the same
///   {constant: 80 us}
///   {normal: {mean: 80 us, sigma: 4 us}}                        without its part below 0
///   {log_normal: {median: 50 us, sigma: 0.5, offset: 30 us}}
///   {gamma: {shape: 2, scale: 30 us, offset: 20 us}}
///   {histogram: {edges: [0 us, 50 us, 100 us], weights: [3, 1]}}
/// @throws InputError naming file, line and key.
[[nodiscard]] Delay ReadDelay(const YamlNode& node);

/// Reads which messages are lost: 0.1 %, {gilbert_elliott: {...}} or {scripted: [...]}.
/// @throws InputError naming file, line and key.
[[nodiscard]] Loss ReadLoss(const YamlNode& node);

/// Reads one direction of a link; its keys have its name in front: "state_delay".
/// @throws InputError naming file, line and key.
void ReadDirection(const YamlMap& map, std::string_view name, DirectionSection& direction);

/// Reads the section `link`. @throws InputError naming file, line and key.
void ReadLink(const YamlNode& node, LinkSection& link);

}  // namespace twin::scenario
