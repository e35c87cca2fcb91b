#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace twin::report {

/// Runs gnuplot from PATH on `script`. Nothing passes through a shell, and no settings of the user
/// are read.
///
/// Threads: any thread. Real-time: no; waits for gnuplot to end, a minute at most.
/// @returns what it draws, an SVG file.
/// @throws EnvironmentError when gnuplot is not there or fails, or draws nothing whole.
[[nodiscard]] std::string SvgOf(std::string_view script);

/// Writes a picture into the file `path`, which is `.partial` until it is whole.
/// @throws EnvironmentError when it cannot be written.
void WriteSvg(std::string_view svg, const std::filesystem::path& path);

}  // namespace twin::report
