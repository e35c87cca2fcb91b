#pragma once

#include <filesystem>

#include "scenario/yaml_node.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {

/// Reads a trajectory into `motion`: either the name of a file (.yaml or .csv, relative to
/// `folder`) or a map
///   unit: rad            # of every q
///   duration: 18.32 s    # or velocity_scale, acceleration_scale, jerk_scale; or times at the
///   points waypoints: [{q: [7 numbers], at: 0 s, stop: true}, ...]
/// @throws InputError with file and line.
void ReadTrajectory(const YamlNode& node, const std::filesystem::path& folder,
                    MotionSection& motion);

}  // namespace twin::scenario
