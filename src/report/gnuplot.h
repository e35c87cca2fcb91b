#pragma once

#include <filesystem>
#include <string_view>

namespace twin::report {

/// Runs gnuplot from PATH on `script`, and gives what it draws, an SVG, the name `path`. The file
/// is
/// `.partial` until it is whole. Nothing passes through a shell, and no settings of the user are
/// read.
///
/// Threads: any thread. Real-time: no; waits for gnuplot to end.
/// @throws EnvironmentError when gnuplot is not there or fails, or the file cannot be written.
void DrawSvg(std::string_view script, const std::filesystem::path& path);

}  // namespace twin::report
