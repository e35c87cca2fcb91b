#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "twin/render/video_writer.h"

namespace twin::render {

/// @returns the arguments for ffmpeg to encode raw RGB pictures from its standard input.
/// @param output  file; for pictures an existing folder.
[[nodiscard]] std::vector<std::string> FfmpegArguments(const VideoSettings& settings,
                                                       VideoFormat format,
                                                       const std::filesystem::path& output);

}  // namespace twin::render
