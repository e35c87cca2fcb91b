#pragma once

#include <filesystem>
#include <string>

#include "twin/golden/golden.h"
#include "twin/render/image.h"

namespace twin::golden {

/// Path of a golden's folder until it is complete.
[[nodiscard]] std::filesystem::path PartialOf(std::filesystem::path folder);

/// Path of a case's approved golden: its folder, or the one put aside if a two-step exchange was
/// killed between its steps. @returns `folder` if neither exists.
[[nodiscard]] std::filesystem::path WholeOf(const std::filesystem::path& folder);

/// Moves `made` to `folder`, which need not exist, and removes the old one. Done in one step, so
/// that a kill at any time leaves one of them. File systems without exchange need two steps and put
/// the old folder aside between them: see WholeOf().
/// @throws std::filesystem::filesystem_error; `folder` is then unchanged.
void Exchange(const std::filesystem::path& made, const std::filesystem::path& folder);

// golden.yaml: all data of a golden except its pictures.

[[nodiscard]] std::string TextOf(const Golden& golden);

/// Reads the text of TextOf(). The key pictures have only their frames.
/// @throws InputError naming the file and, if known, the line.
[[nodiscard]] Golden ReadGoldenText(const std::filesystem::path& path);

// Depths and bodies as single-channel pictures. The same picture gives the same bytes.

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
