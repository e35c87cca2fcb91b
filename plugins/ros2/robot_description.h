#pragma once

#include <filesystem>
#include <string>

namespace twin::ros2 {

/// The text of one URDF: the arm's, with the hand's links and joints when a hand is mounted.
/// @param hand  empty: none. @throws InputError for files that cannot be read or are no URDF.
[[nodiscard]] std::string DescriptionOf(const std::filesystem::path& arm,
                                        const std::filesystem::path& hand);

}  // namespace twin::ros2
