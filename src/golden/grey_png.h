#pragma once

#include <filesystem>

#include "twin/render/image.h"

// Depths and bodies as single-channel pictures. The same picture gives the same bytes.
namespace twin::golden {

/// Resolution of stored depths, m; depths are rounded to it. Depths above the largest value, 65535
/// units or 16.4 m, are stored as that.
inline constexpr double kDepthUnit = 0.25e-3;

/// The depths after writing and reading.
[[nodiscard]] render::DepthImage RoundedDepths(const render::DepthImage& image);

/// 16-bit grey, depth in kDepthUnit. @throws EnvironmentError if it cannot be written.
void WriteDepths(const std::filesystem::path& path, const render::DepthImage& image);
/// @throws InputError if it is missing, damaged, or not 16-bit grey.
[[nodiscard]] render::DepthImage ReadDepths(const std::filesystem::path& path);

/// 8-bit grey, the body's number, 255 the background. @pre body numbers are at most 254.
/// @throws EnvironmentError if it cannot be written.
void WriteBodies(const std::filesystem::path& path, const render::SegmentationImage& image);
/// @throws InputError if it is missing, damaged, or not 8-bit grey.
[[nodiscard]] render::SegmentationImage ReadBodies(const std::filesystem::path& path);

}  // namespace twin::golden
