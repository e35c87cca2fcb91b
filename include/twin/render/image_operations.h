#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "twin/render/image.h"

namespace twin::render {

/// Layout of a contact sheet.
struct ContactSheetLayout {
  int columns = 4;
  int border_px = 4;  ///< between and around pictures
  Rgb border = {32, 32, 36};
};

/// Indices of `count` of `frames` frames (or all, if fewer), evenly spaced and rising, with the
/// first and the last; a single one is the first.
[[nodiscard]] std::vector<std::size_t> SpreadFrames(std::size_t frames, std::size_t count);

/// Arranges pictures row by row from the top left; unused cells have the border colour.
/// @pre images is not empty, all images have one size, columns >= 1, border_px >= 0.
[[nodiscard]] Image ComposeContactSheet(std::span<const Image> images,
                                        const ContactSheetLayout& layout = {});

/// Halves a picture in both directions; each pixel is the rounded mean of four. Drops an odd last
/// row or column.
[[nodiscard]] Image HalveImage(const Image& image);

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
