#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "twin/render/video_writer.h"

namespace twin::render {

/// @returns what ffmpeg is called with to encode raw RGB pictures from its standard input.
/// @param output  file, or for pictures the folder, which is there.
[[nodiscard]] std::vector<std::string> FfmpegArguments(const VideoSettings& settings,
                                                       VideoFormat format,
                                                       const std::filesystem::path& output);

}  // namespace twin::render
