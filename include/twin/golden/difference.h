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
  int width = 0;   ///< 0: nothing
  int height = 0;  ///< 0: nothing
  bool operator==(const Region&) const = default;
};

/// How two pictures of one size differ.
struct Difference {
  double share = 0;       ///< of channels (colours) or pixels (others) that differ, in [0, 1]
  int window_pixels = 0;  ///< that differ, in the window where most do
  Region region{};        ///< the box of those
};

/// Which pixels differ: not 0 where they do. Rows from top to bottom.
struct DifferenceMask {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  std::vector<std::uint8_t> differs;
};

/// The fullest of all windows of `window_px` by `window_px` pixels (of the picture's size where
/// that is smaller): its count, and the box of what differs in it. Of equal ones the first, row by
/// row. `share` is left 0. @pre window_px >= 1
[[nodiscard]] Difference DensestWindow(const DifferenceMask& mask, int window_px);

/// What two colours may differ by, 8-bit levels.
struct ColourTolerance {
  int channel = 1;  ///< a channel differs that is off by more; counts for the share
  int pixel = 2;    ///< a pixel differs of which a channel is off by more; counts in windows
  int scenery = 5;  ///< instead of both where nothing but scenery is seen: its textures are
                    ///< filtered by each rasteriser in its own way
};

/// Where neither picture shows a body that is part of the run, but the world or nothing.
/// @pre both are of one size, as in the following.
[[nodiscard]] std::vector<bool> SceneryOf(const render::SegmentationImage& expected,
                                          const render::SegmentationImage& actual);

/// @param scenery  SceneryOf() the pictures.
[[nodiscard]] Difference CompareColours(const render::Image& expected, const render::Image& actual,
                                        const std::vector<bool>& scenery,
                                        const ColourTolerance& tolerance, int window_px);

/// A pixel differs when its depth is off by more than `tolerance_m`, or only one has any.
[[nodiscard]] Difference CompareDepths(const render::DepthImage& expected,
                                       const render::DepthImage& actual, double tolerance_m,
                                       int window_px);

/// A pixel differs when another body is seen.
[[nodiscard]] Difference CompareBodies(const render::SegmentationImage& expected,
                                       const render::SegmentationImage& actual, int window_px);

/// Whom a difference is about: of all bodies that either picture shows in the region's pixels that
/// differ, or in the whole region when none of those differs, the one with most pixels; the world
/// and the background only when there is nothing else.
/// @returns a body, or kBackground.
[[nodiscard]] std::int32_t BodyUnder(const render::SegmentationImage& expected,
                                     const render::SegmentationImage& actual, const Region& region);

}  // namespace twin::golden
