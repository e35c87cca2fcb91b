#pragma once

#include <filesystem>
#include <string>

#include "twin/robot/link_config.h"
#include "twin/scenario/scenario.h"

// The section `link` by itself, for who has a link and no scenario: one syntax for both.
namespace twin::scenario {

/// What the section asks for. @throws InputError when a parameter is outside its range.
[[nodiscard]] robot::LinkConfig MakeLink(const LinkSection& link);

/// The same of one direction. @throws InputError as MakeLink.
[[nodiscard]] robot::DirectionConfig MakeDirection(const DirectionSection& direction);

/// @param path  a scenario, whose section `link` counts; or a file with that section only.
/// @throws InputError naming file, line and key.
[[nodiscard]] LinkSection LoadLink(const std::filesystem::path& path);

/// @param text  the keys of the section. @param file  its name in messages.
/// @throws InputError naming file, line and key.
[[nodiscard]] LinkSection ParseLink(const std::string& text, const std::filesystem::path& file);

}  // namespace twin::scenario
