#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "twin/render/image.h"

namespace twin::golden {

/// The size of a signature, pixels.
inline constexpr int kSignatureWidth = 32;
inline constexpr int kSignatureHeight = 24;

/// A picture made so small that every frame of a film can be kept: each of its pixels is the
/// rounded mean of a box of the picture's; the boxes cover it without gap or overlap, box i from
/// floor(i * size / count) on. What moves by a fraction of a box shows in its grey.
/// @pre the picture is at least of a signature's size.
[[nodiscard]] render::Image SignatureOf(const render::Image& picture);

/// The largest difference of two signatures.
struct SignatureDifference {
  int levels = 0;  ///< of the channel most off, 8-bit
  int column = 0;  ///< where
  int row = 0;
};
/// @pre both are of a signature's size.
[[nodiscard]] SignatureDifference CompareSignatures(const render::Image& expected,
                                                    const render::Image& actual);

/// All signatures of a film as one picture, row by row, kStripColumns in a row; the last row is
/// filled up with black. @pre there is one, and all are of a signature's size.
inline constexpr int kStripColumns = 16;
[[nodiscard]] render::Image JoinSignatures(std::span<const render::Image> signatures);

/// The first `count` signatures out of such a picture.
/// @returns nothing when the picture is not of the size that many make.
[[nodiscard]] std::vector<render::Image> SplitSignatures(const render::Image& strip,
                                                         std::size_t count);

}  // namespace twin::golden
