#pragma once

#include <string>

#include "plant/robot_description.h"

namespace twin::plant {

/// Replaces every mesh of `robot` by its link's shapes from a primitives file.
///
/// The file (YAML): `unit: m`; `colours`: name to [red, green, blue, opacity]; `links`: link name
/// to a list of shapes, each {shape: capsule | cylinder, from, to, radius} or {shape: sphere, at,
/// radius} or {shape: box, at, half}, with `colour` and, optionally, `use: visual | collision`
/// (default: both). All in the link's frame.
/// @param text  the file's content. @param where  its name, for messages.
/// @throws InputError naming file, line and key.
void UsePrimitives(const std::string& text, const std::string& where, RobotDescription& robot);

}  // namespace twin::plant
