#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace twin::render {

/// One colour of 8 bits per channel: red, green, blue.
using Rgb = std::array<std::uint8_t, 3>;

/// A picture: 8-bit RGB, sRGB as displayed, rows from top to bottom, no padding.
struct Image {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  std::vector<std::uint8_t> rgb;

  Image() = default;
  /// A picture filled with `colour`.
  Image(int width_px, int height_px, Rgb colour = {})
      : width(width_px), height(height_px), rgb(Pixels() * 3, colour[0]) {
    if (colour[1] == colour[0] && colour[2] == colour[0]) return;  // fast path for grey
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = colour[i % 3];
  }

  [[nodiscard]] std::size_t Pixels() const noexcept {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  /// @pre 0 <= column < width, 0 <= row < height; row 0 is the topmost.
  [[nodiscard]] std::size_t Offset(int column, int row) const noexcept {
    return 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(column));
  }
  /// @returns the bytes of a row. @pre 0 <= row < height
  [[nodiscard]] std::span<std::uint8_t> Row(int row) {
    return std::span(rgb).subspan(Offset(0, row), 3 * static_cast<std::size_t>(width));
  }
  [[nodiscard]] std::span<const std::uint8_t> Row(int row) const {
    return std::span(rgb).subspan(Offset(0, row), 3 * static_cast<std::size_t>(width));
  }
  [[nodiscard]] Rgb at(int column, int row) const noexcept {
    const std::size_t i = Offset(column, row);
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
  }
  bool operator==(const Image&) const = default;
};

/// The body seen in each pixel: MuJoCo body id (0 is the world), or kBackground. Rows from top to
/// bottom.
struct SegmentationImage {
  static constexpr std::int32_t kBackground = -1;

  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  std::vector<std::int32_t> body;

  /// @pre 0 <= column < width, 0 <= row < height; row 0 is the topmost.
  [[nodiscard]] std::int32_t at(int column, int row) const noexcept {
    return body[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(column)];
  }
  bool operator==(const SegmentationImage&) const = default;
};

/// Distance of the surface in each pixel along the camera's axis, m; kBackground without one. Rows
/// from top to bottom.
struct DepthImage {
  static constexpr float kBackground = 0;

  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  std::vector<float> depth_m;

  /// @pre 0 <= column < width, 0 <= row < height; row 0 is the topmost.
  [[nodiscard]] float at(int column, int row) const noexcept {
    return depth_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                   static_cast<std::size_t>(column)];
  }
  bool operator==(const DepthImage&) const = default;
};

/// @returns `image` as the bytes of an 8-bit RGB PNG. @pre it is not empty.
[[nodiscard]] std::vector<char> EncodePng(const Image& image);

/// Writes `image` as an 8-bit RGB PNG; the same image gives the same bytes. Writes
/// `<path>.partial`, and renames it when complete or removes it.
/// @throws EnvironmentError if the file cannot be written, or another process writes it.
void WritePng(const std::filesystem::path& path, const Image& image);

/// Reads a PNG as 8-bit RGB; blends transparency over black.
/// @throws InputError if the file is missing or not a PNG.
[[nodiscard]] Image ReadPng(const std::filesystem::path& path);

}  // namespace twin::render
