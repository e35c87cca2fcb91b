#pragma once

#include <filesystem>
#include <vector>

#include "twin/render/image.h"

namespace twin::render {

/// @returns `image` as the bytes of an 8-bit RGB PNG. @pre it is not empty.
[[nodiscard]] std::vector<char> EncodePng(const Image& image);

/// Writes `image` as an 8-bit RGB PNG; the same image gives the same bytes. The file is written as
/// `<path>.partial` and renamed when it is whole, or else removed.
/// @throws EnvironmentError when the file cannot be written, or another writes it.
void WritePng(const std::filesystem::path& path, const Image& image);

/// Reads a PNG as 8-bit RGB; transparency is laid over black.
/// @throws InputError when the file is missing or not a PNG.
[[nodiscard]] Image ReadPng(const std::filesystem::path& path);

}  // namespace twin::render
