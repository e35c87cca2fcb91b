#include "render/video_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <system_error>

#include "twin/core/error.h"

namespace twin::render {
namespace {

namespace fs = std::filesystem;

/// frame_000000.png and so on.
bool IsPicture(const std::string& name) {
  constexpr std::string_view kStem = "frame_";
  constexpr std::string_view kExtension = ".png";
  if (!name.starts_with(kStem) || !name.ends_with(kExtension)) return false;
  const std::string_view number =
      std::string_view(name).substr(kStem.size(), name.size() - kStem.size() - kExtension.size());
  return number.size() >= 6 &&
         std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// A folder may be replaced when only a video's pictures are in it.
void RequirePicturesOnly(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  if (!fs::is_directory(folder, error)) {
    throw InputError(fmt::format(
        "video: {} is a file; a name without an extension is that of a folder of pictures. Choose "
        "another, or end it in .mp4 or .mkv",
        folder.string()));
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!IsPicture(name)) {
      throw InputError(fmt::format(
          "video: the folder {} holds {}, which is no picture of a video; it would be replaced. "
          "Choose a new folder",
          folder.string(), name));
    }
  }
}

void RequireNoFolder(const fs::path& file) {
  std::error_code error;
  if (!fs::is_directory(file, error)) return;
  throw InputError(fmt::format("video: {} is a folder; a file is to be there. Choose another name",
                               file.string()));
}

[[noreturn]] void ThrowRefused(const fs::path& path, const char* what, const std::error_code& why) {
  throw EnvironmentError(fmt::format("video: {} {} ({})", path.string(), what, why.message()));
}

/// @returns a path without the slash it may end with.
fs::path WithoutSlash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

VideoFormat FormatOf(const fs::path& path) {
  if (path.empty()) throw InputError("video: no name is given");
  const std::string extension = path.extension().string();
  if (extension.empty()) return VideoFormat::kPictures;
  if (extension == ".mp4") return VideoFormat::kH264;
  if (extension == ".mkv") return VideoFormat::kFfv1;
  throw InputError(fmt::format(
      "video: {} ends in {}; it must be .mp4 (H.264), .mkv (FFV1, without loss), or none (a folder "
      "of PNG pictures)",
      path.string(), extension));
}

VideoTarget::VideoTarget(const fs::path& path)
    : format_(FormatOf(path)), path_(WithoutSlash(path)), partial_(path_) {
  partial_ += ".partial";
  if (format_ != VideoFormat::kPictures) {
    RequireNoFolder(path_);
    return;
  }
  RequirePicturesOnly(path_);
  RequirePicturesOnly(partial_);
  std::error_code error;
  fs::remove_all(partial_, error);
  if (!error) fs::create_directory(partial_, error);
  if (error) ThrowRefused(partial_, "cannot be made", error);
}

void VideoTarget::Publish() const {
  std::error_code error;
  if (format_ == VideoFormat::kPictures) {
    RequirePicturesOnly(path_);
    fs::remove_all(path_, error);
  }
  if (!error) fs::rename(partial_, path_, error);
  if (error) ThrowRefused(partial_, "cannot be given its name", error);
}

}  // namespace twin::render
