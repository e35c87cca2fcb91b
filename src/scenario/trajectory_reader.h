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

/// Reads a motion of poses: start, timing, waypoints.
/// @throws InputError naming file, line and key.
void ReadPoses(const YamlNode& node, MotionSection& motion);

/// Reads a planned motion: goal, seed, budget, clearance, pace, stretch.
/// @throws InputError naming file, line and key.
void ReadPlan(const YamlNode& node, MotionSection& motion);

/// Reads the keys of a motion's timing that a map has.
void ReadTiming(const YamlMap& map, reference::Timing& timing);

}  // namespace twin::scenario
