#include "twin/golden/difference.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "twin/core/error.h"

namespace twin::golden {
namespace {

/// The first body other than the world.
constexpr std::int32_t kFirstOfRun = 1;

/// Summed-area table: any box is four lookups.
class Integral {
 public:
  explicit Integral(const DifferenceMask& mask)
      : columns_(static_cast<std::size_t>(mask.width) + 1),
        sums_(columns_ * (static_cast<std::size_t>(mask.height) + 1)) {
    std::size_t pixel = 0;
    for (int row = 0; row < mask.height; ++row) {
      int in_row = 0;
      for (int column = 0; column < mask.width; ++column) {
        in_row += mask.differs[pixel++] != 0 ? 1 : 0;
        sums_[Index(column + 1, row + 1)] = sums_[Index(column + 1, row)] + in_row;
      }
    }
  }

  [[nodiscard]] int Count(const Region& box) const {
    const int right = box.left + box.width;
    const int bottom = box.top + box.height;
    return sums_[Index(right, bottom)] - sums_[Index(box.left, bottom)] -
           sums_[Index(right, box.top)] + sums_[Index(box.left, box.top)];
  }

 private:
  [[nodiscard]] std::size_t Index(int column, int row) const {
    return static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column);
  }

  std::size_t columns_;
  std::vector<int> sums_;
};

/// Bounding box of the differing pixels within `window`. @pre there is one.
Region Shrink(const DifferenceMask& mask, const Region& window) {
  int left = window.left + window.width;
  int right = window.left;
  int top = window.top + window.height;
  int bottom = window.top;
  for (int row = window.top; row < window.top + window.height; ++row) {
    for (int column = window.left; column < window.left + window.width; ++column) {
      if (mask.differs[static_cast<std::size_t>(row) * static_cast<std::size_t>(mask.width) +
                       static_cast<std::size_t>(column)] == 0) {
        continue;
      }
      left = std::min(left, column);
      right = std::max(right, column + 1);
      top = std::min(top, row);
      bottom = std::max(bottom, row + 1);
    }
  }
  return {left, top, right - left, bottom - top};
}

template <typename Picture>
DifferenceMask MaskOf(const Picture& expected, const Picture& actual, std::size_t pixels) {
  TWIN_CHECK(expected.width == actual.width && expected.height == actual.height);
  return {expected.width, expected.height, std::vector<std::uint8_t>(pixels)};
}

double Share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

Difference OfMask(const DifferenceMask& mask, int window_px) {
  Difference difference = DensestWindow(mask, window_px);
  const auto differing = std::count(mask.differs.begin(), mask.differs.end(), 1);
  difference.share = Share(static_cast<std::size_t>(differing), mask.differs.size());
  return difference;
}

}  // namespace

Difference DensestWindow(const DifferenceMask& mask, int window_px) {
  TWIN_CHECK(window_px >= 1);
  const Integral integral(mask);
  const int width = std::min(window_px, mask.width);
  const int height = std::min(window_px, mask.height);
  Difference densest;
  Region window;
  for (int top = 0; top + height <= mask.height; ++top) {
    for (int left = 0; left + width <= mask.width; ++left) {
      const Region here{left, top, width, height};
      const int count = integral.Count(here);
      if (count <= densest.window_pixels) continue;
      densest.window_pixels = count;
      window = here;
    }
  }
  if (densest.window_pixels > 0) densest.region = Shrink(mask, window);
  return densest;
}

std::vector<bool> SceneryOf(const render::SegmentationImage& expected,
                            const render::SegmentationImage& actual) {
  TWIN_CHECK(expected.body.size() == actual.body.size());
  std::vector<bool> scenery(expected.body.size());
  for (std::size_t i = 0; i < scenery.size(); ++i) {
    scenery[i] = expected.body[i] < kFirstOfRun && actual.body[i] < kFirstOfRun;
  }
  return scenery;
}

Difference CompareColours(const render::Image& expected, const render::Image& actual,
                          const std::vector<bool>& scenery, const ColourTolerance& tolerance,
                          int window_px) {
  DifferenceMask mask = MaskOf(expected, actual, expected.Pixels());
  TWIN_CHECK(scenery.size() == mask.differs.size());
  std::size_t channels = 0;
  for (std::size_t i = 0; i < expected.rgb.size(); ++i) {
    const int off = std::abs(int{expected.rgb[i]} - int{actual.rgb[i]});
    if (off > (scenery[i / 3] ? tolerance.scenery : tolerance.channel)) ++channels;
    if (off > (scenery[i / 3] ? tolerance.scenery : tolerance.pixel)) mask.differs[i / 3] = 1;
  }
  Difference difference = OfMask(mask, window_px);
  difference.share = Share(channels, expected.rgb.size());
  return difference;
}

Difference CompareDepths(const render::DepthImage& expected, const render::DepthImage& actual,
                         double tolerance_m, int window_px) {
  DifferenceMask mask = MaskOf(expected, actual, expected.depth_m.size());
  for (std::size_t i = 0; i < mask.differs.size(); ++i) {
    const double a = expected.depth_m[i];
    const double b = actual.depth_m[i];
    const bool one_alone =
        (a == render::DepthImage::kBackground) != (b == render::DepthImage::kBackground);
    mask.differs[i] = one_alone || std::abs(a - b) > tolerance_m ? 1 : 0;
  }
  return OfMask(mask, window_px);
}

Difference CompareBodies(const render::SegmentationImage& expected,
                         const render::SegmentationImage& actual, int window_px) {
  DifferenceMask mask = MaskOf(expected, actual, expected.body.size());
  for (std::size_t i = 0; i < mask.differs.size(); ++i) {
    mask.differs[i] = expected.body[i] != actual.body[i] ? 1 : 0;
  }
  return OfMask(mask, window_px);
}

std::int32_t BodyUnder(const render::SegmentationImage& expected,
                       const render::SegmentationImage& actual, const Region& region) {
  std::map<std::int32_t, int> all;
  std::map<std::int32_t, int> differing;
  for (int row = region.top; row < region.top + region.height; ++row) {
    for (int column = region.left; column < region.left + region.width; ++column) {
      const std::int32_t before = expected.at(column, row);
      const std::int32_t after = actual.at(column, row);
      for (const std::int32_t body : {before, after}) {
        ++all[body];
        if (before != after) ++differing[body];
      }
    }
  }
  const auto best = [](const std::map<std::int32_t, int>& counts, std::int32_t least) {
    std::int32_t body = render::SegmentationImage::kBackground;
    int most = 0;
    for (const auto& [id, count] : counts) {
      if (id < least || count <= most) continue;
      body = id;
      most = count;
    }
    return body;
  };
  for (const auto* counts : {&differing, &all}) {
    const std::int32_t body = best(*counts, kFirstOfRun);
    if (body != render::SegmentationImage::kBackground) return body;
  }
  return best(all, 0);
}

}  // namespace twin::golden
