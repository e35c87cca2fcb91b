#pragma once

#include <filesystem>
#include <vector>

#include "twin/render/image.h"

namespace twin::render {

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
