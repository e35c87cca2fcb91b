#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "twin/render/image.h"

namespace twin::render {

/// How alike pictures are to the eye: the structural similarity of each pair, by ffmpeg's filter
/// `ssim` on red, green and blue. 1: the same; what is unrelated comes near 0.
/// @param expected,actual  as many, all of one size. @param ffmpeg  as VideoSettings::ffmpeg.
/// @returns a value for each pair; none for none.
/// @throws EnvironmentError when ffmpeg cannot be started or fails, or no temporary file can be
/// made.
[[nodiscard]] std::vector<double> MeasureSsim(std::span<const Image> expected,
                                              std::span<const Image> actual,
                                              const std::filesystem::path& ffmpeg = "ffmpeg");

}  // namespace twin::render
