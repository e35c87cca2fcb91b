#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "twin/render/image.h"

namespace twin::golden {

/// A box of pixels; column 0 is the leftmost, row 0 the topmost.
struct Region {
  int left = 0;
  int top = 0;
  int width = 0;   ///< 0: empty
  int height = 0;  ///< 0: empty
  bool operator==(const Region&) const = default;
};

/// Difference of two pictures of one size.
struct Difference {
  double share = 0;       ///< of differing channels (colours) or pixels (others), in [0, 1]
  int window_pixels = 0;  ///< differing pixels in the fullest window
  Region region{};        ///< bounding box of these pixels
};

/// Mask of differing pixels: not 0 where they differ. Rows from top to bottom.
struct DifferenceMask {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  std::vector<std::uint8_t> differs;
};

/// The window of `window_px` by `window_px` pixels (or the picture's size, if smaller) with the
/// most differing pixels: their number and bounding box. Among equal ones the first, row by row.
/// `share` stays 0.
/// @pre window_px >= 1
[[nodiscard]] Difference DensestWindow(const DifferenceMask& mask, int window_px);

/// Tolerated differences of colours, 8-bit levels.
struct ColourTolerance {
  int channel = 1;  ///< larger differences of a channel count for the share
  int pixel = 2;    ///< pixels with a larger difference of a channel count in windows
  int scenery = 5;  ///< replaces both where only scenery is seen, because rasterisers filter its
                    ///< textures differently
};

/// True for pixels where both pictures show only the world or nothing.
/// @pre here and below: both have one size.
[[nodiscard]] std::vector<bool> SceneryOf(const render::SegmentationImage& expected,
                                          const render::SegmentationImage& actual);

/// @param scenery  SceneryOf() the pictures.
[[nodiscard]] Difference CompareColours(const render::Image& expected, const render::Image& actual,
                                        const std::vector<bool>& scenery,
                                        const ColourTolerance& tolerance, int window_px);

/// A pixel differs if its depths differ by more than `tolerance_m`, or only one has a depth.
[[nodiscard]] Difference CompareDepths(const render::DepthImage& expected,
                                       const render::DepthImage& actual, double tolerance_m,
                                       int window_px);

/// A pixel differs if the bodies differ.
[[nodiscard]] Difference CompareBodies(const render::SegmentationImage& expected,
                                       const render::SegmentationImage& actual, int window_px);

/// The body that a difference concerns: the one with the most pixels among the region's differing
/// pixels in either picture, or in the whole region if none differs. The world and the background
/// count only without other bodies.
/// @returns a body, or kBackground.
[[nodiscard]] std::int32_t BodyUnder(const render::SegmentationImage& expected,
                                     const render::SegmentationImage& actual, const Region& region);

}  // namespace twin::golden
