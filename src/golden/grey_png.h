#pragma once

#include <filesystem>

#include "twin/render/image.h"

// Depths and bodies as pictures of one channel. The same picture gives the same bytes.
namespace twin::golden {

/// The unit of a depth in a file, m: depths are rounded to it. What is farther away than the
/// largest that fits, 65535 of it or 16.4 m, is written as that.
inline constexpr double kDepthUnit = 0.25e-3;

/// As a file would give it back.
[[nodiscard]] render::DepthImage RoundedDepths(const render::DepthImage& image);

/// 16-bit grey, depth in kDepthUnit. @throws EnvironmentError when it cannot be written.
void WriteDepths(const std::filesystem::path& path, const render::DepthImage& image);
/// @throws InputError when it is missing, damaged, or not 16-bit grey.
[[nodiscard]] render::DepthImage ReadDepths(const std::filesystem::path& path);

/// 8-bit grey, the body's number, 255 the background. @pre no body has a number above 254.
/// @throws EnvironmentError when it cannot be written.
void WriteBodies(const std::filesystem::path& path, const render::SegmentationImage& image);
/// @throws InputError when it is missing, damaged, or not 8-bit grey.
[[nodiscard]] render::SegmentationImage ReadBodies(const std::filesystem::path& path);

}  // namespace twin::golden
