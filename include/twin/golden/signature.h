#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "twin/render/image.h"

namespace twin::golden {

/// The size of a signature, pixels.
inline constexpr int kSignatureWidth = 32;
inline constexpr int kSignatureHeight = 24;

/// Downscales a picture so that every frame of a film can be stored: each pixel is the rounded mean
/// of a box; the boxes cover the picture without gap or overlap, box i starting at floor(i * size /
/// count). Motion by a fraction of a box changes its grey level.
/// @pre the picture is not smaller than a signature.
[[nodiscard]] render::Image SignatureOf(const render::Image& picture);

/// Largest difference of two signatures.
struct SignatureDifference {
  int levels = 0;  ///< of the channel with the largest difference, 8-bit
  int column = 0;  ///< its position
  int row = 0;
};
/// @pre both have a signature's size.
[[nodiscard]] SignatureDifference CompareSignatures(const render::Image& expected,
                                                    const render::Image& actual);

/// All signatures of a film as one picture, row by row, kStripColumns per row; the last row is
/// padded with black. @pre at least one, all of a signature's size.
inline constexpr int kStripColumns = 16;
[[nodiscard]] render::Image JoinSignatures(std::span<const render::Image> signatures);

/// The first `count` signatures of such a picture.
/// @returns an empty vector if the picture's size does not match `count`.
[[nodiscard]] std::vector<render::Image> SplitSignatures(const render::Image& strip,
                                                         std::size_t count);

}  // namespace twin::golden
