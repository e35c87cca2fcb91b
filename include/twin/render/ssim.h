#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "twin/render/image.h"

namespace twin::render {

/// Structural similarity of each pair of pictures, by ffmpeg's filter `ssim` on red, green and
/// blue. 1: identical; near 0: unrelated.
/// @param expected,actual  same number, all of one size. @param ffmpeg  as VideoSettings::ffmpeg.
/// @returns one value per pair.
/// @throws EnvironmentError if ffmpeg cannot be started or fails, or no temporary file can be
/// created.
[[nodiscard]] std::vector<double> MeasureSsim(std::span<const Image> expected,
                                              std::span<const Image> actual,
                                              const std::filesystem::path& ffmpeg = "ffmpeg");

}  // namespace twin::render
