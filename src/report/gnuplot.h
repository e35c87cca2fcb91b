#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace twin::report {

/// Runs gnuplot from PATH on `script`, without a shell and without the user's settings.
///
/// Threads: any. Not real-time: waits for gnuplot's end, at most a minute.
/// @returns the SVG document that gnuplot draws.
/// @throws EnvironmentError if gnuplot is missing or fails, or the document is incomplete.
[[nodiscard]] std::string SvgOf(std::string_view script);

/// Writes a picture to the file `path`, which is `.partial` until it is complete.
/// @throws EnvironmentError if it cannot be written.
void WriteSvg(std::string_view svg, const std::filesystem::path& path);

}  // namespace twin::report
