#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "twin/render/image.h"

namespace twin::render {

/// How pictures are laid out on a contact sheet.
struct ContactSheetLayout {
  int columns = 4;
  int border_px = 4;  ///< between pictures and round them
  Rgb border = {32, 32, 36};
};

/// Which of `frames` frames stand for all: `count` of them, or all where they are fewer, evenly
/// spaced and in order, the first and the last among them; one alone is the first.
[[nodiscard]] std::vector<std::size_t> SpreadFrames(std::size_t frames, std::size_t count);

/// Lays pictures out row by row, first one top left; cells that remain are border.
/// @pre images is not empty, all images have one size, columns >= 1, border_px >= 0.
[[nodiscard]] Image ComposeContactSheet(std::span<const Image> images,
                                        const ContactSheetLayout& layout = {});

/// Halves a picture in both directions, each pixel the rounded mean of four; an odd last row or
/// column is dropped.
[[nodiscard]] Image HalveImage(const Image& image);

}  // namespace twin::render
