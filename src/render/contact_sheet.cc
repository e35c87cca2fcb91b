#include "twin/render/image_operations.h"

#include <algorithm>

#include "twin/core/error.h"

namespace twin::render {
namespace {

/// Copies `image` into `sheet` with its top left corner at (column, row).
void Paste(const Image& image, int column, int row, Image& sheet) {
  const std::size_t margin = 3 * static_cast<std::size_t>(column);
  for (int y = 0; y < image.height; ++y) {
    const auto from = image.Row(y);
    std::copy(from.begin(), from.end(), sheet.Row(row + y).subspan(margin).begin());
  }
}

}  // namespace

std::vector<std::size_t> SpreadFrames(std::size_t frames, std::size_t count) {
  const std::size_t taken = std::min(frames, count);
  std::vector<std::size_t> spread;
  spread.reserve(taken);
  for (std::size_t i = 0; i < taken; ++i) {
    spread.push_back(taken == 1 ? 0 : i * (frames - 1) / (taken - 1));
  }
  return spread;
}

Image ComposeContactSheet(std::span<const Image> images, const ContactSheetLayout& layout) {
  TWIN_CHECK(!images.empty() && layout.columns >= 1 && layout.border_px >= 0);
  const int count = static_cast<int>(images.size());
  const int columns = std::min(layout.columns, count);
  const int rows = (count + columns - 1) / columns;
  const int cell_width = images[0].width + layout.border_px;
  const int cell_height = images[0].height + layout.border_px;
  Image sheet(columns * cell_width + layout.border_px, rows * cell_height + layout.border_px,
              layout.border);
  for (int i = 0; i < count; ++i) {
    const Image& image = images[static_cast<std::size_t>(i)];
    TWIN_CHECK(image.width == images[0].width && image.height == images[0].height);
    Paste(image, layout.border_px + (i % columns) * cell_width,
          layout.border_px + (i / columns) * cell_height, sheet);
  }
  return sheet;
}

Image HalveImage(const Image& image) {
  Image half(image.width / 2, image.height / 2);
  for (int row = 0; row < half.height; ++row) {
    for (int column = 0; column < half.width; ++column) {
      const std::size_t upper = image.Offset(2 * column, 2 * row);
      const std::size_t lower = image.Offset(2 * column, 2 * row + 1);
      for (std::size_t c = 0; c < 3; ++c) {
        const unsigned sum = image.rgb[upper + c] + image.rgb[upper + 3 + c] +
                             image.rgb[lower + c] + image.rgb[lower + 3 + c];
        half.rgb[half.Offset(column, row) + c] = static_cast<std::uint8_t>((sum + 2) / 4);
      }
    }
  }
  return half;
}

}  // namespace twin::render
