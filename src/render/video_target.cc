#include "render/ffmpeg.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

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

/// A folder may be replaced only if it holds nothing but a video's pictures.
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

/// @returns the path without a trailing slash.
fs::path WithoutSlash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

fs::path PartialOf(fs::path path) {
  return path += ".partial";
}

/// @returns the path without a trailing slash. @throws as CheckVideoPath().
fs::path Checked(const fs::path& path) {
  CheckVideoPath(path);
  return WithoutSlash(path);
}

/// Removes only the pictures from the folder.
void RemovePictures(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> pictures;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (IsPicture(entry.path().filename().string())) pictures.push_back(entry.path());
  }
  for (const fs::path& picture : pictures) fs::remove(picture, error);
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

void CheckVideoPath(const fs::path& path) {
  const VideoFormat format = FormatOf(path);
  const fs::path plain = WithoutSlash(path);
  if (!plain.has_filename() || plain.filename() == "." || plain.filename() == "..") {
    throw InputError(fmt::format(
        "video: {} is a folder that is there already, not the name of a new one; name a folder in "
        "it, such as {}",
        path.string(), (path / "frames/").string()));
  }
  if (format == VideoFormat::kPictures) {
    RequirePicturesOnly(plain);
    RequirePicturesOnly(PartialOf(plain));
  } else {
    RequireNoFolder(plain);
  }
}

VideoTarget::VideoTarget(const fs::path& path)
    : format_(FormatOf(path)),
      path_(Checked(path)),
      output_(path_, format_ == VideoFormat::kPictures ? record::PartialOutput::Kind::kFolder
                                                       : record::PartialOutput::Kind::kFile) {
  if (format_ == VideoFormat::kPictures) RemovePictures(partial());
}

VideoTarget::~VideoTarget() {
  if (format_ == VideoFormat::kPictures && output_.IsOurs()) RemovePictures(partial());
}

void VideoTarget::Publish() {
  if (format_ == VideoFormat::kPictures) {
    RequirePicturesOnly(path_);
    RemovePictures(path_);
  }
  output_.Publish();
}

}  // namespace twin::render
