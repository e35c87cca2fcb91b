#include "twin/golden/golden.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>
#include <utility>

#include "golden/golden_text.h"
#include "golden/grey_png.h"
#include "twin/core/error.h"
#include "twin/golden/signature.h"
#include "twin/render/png.h"

namespace twin::golden {
namespace {

namespace fs = std::filesystem;

/// The files of a view.
class ViewFiles {
 public:
  ViewFiles(const fs::path& folder, const std::string& view) : stem_(folder / view) {}

  [[nodiscard]] fs::path Signatures() const { return Named(".png"); }
  [[nodiscard]] fs::path Colour(std::size_t frame) const { return Of(frame, ".png"); }
  [[nodiscard]] fs::path Depth(std::size_t frame) const { return Of(frame, "_depth.png"); }
  [[nodiscard]] fs::path Bodies(std::size_t frame) const { return Of(frame, "_bodies.png"); }

 private:
  [[nodiscard]] fs::path Named(const std::string& end) const { return stem_.string() + end; }
  [[nodiscard]] fs::path Of(std::size_t frame, const char* end) const {
    return Named(fmt::format("_{:04}{}", frame, end));
  }

  fs::path stem_;
};

template <typename Picture>
Picture RequireSize(Picture picture, const ViewPictures& view, const fs::path& path) {
  if (picture.width == view.width && picture.height == view.height) return picture;
  throw InputError(fmt::format(
      "{}: is of {} x {} pixels, {} says {} x {}; restore it, or remove "
      "the folder and approve the case anew",
      path.string(), picture.width, picture.height, kGoldenFile, view.width, view.height));
}

void ReadPictures(const fs::path& folder, std::size_t frames, ViewPictures& view) {
  const ViewFiles files(folder, view.name);
  view.signatures = SplitSignatures(render::ReadPng(files.Signatures()), frames);
  if (view.signatures.empty()) {
    throw InputError(
        fmt::format("{}: is not of the size that {} frames make; restore it, or "
                    "remove the folder and approve the case anew",
                    files.Signatures().string(), frames));
  }
  for (KeyPicture& key : view.keys) {
    const fs::path colour = files.Colour(key.frame);
    const fs::path depth = files.Depth(key.frame);
    const fs::path bodies = files.Bodies(key.frame);
    key.colour = RequireSize(render::ReadPng(colour), view, colour);
    key.depth = RequireSize(ReadDepths(depth), view, depth);
    key.bodies = RequireSize(ReadBodies(bodies), view, bodies);
  }
}

void WriteInto(const fs::path& folder, const Golden& golden) {
  for (const ViewPictures& view : golden.pictures.views) {
    const ViewFiles files(folder, view.name);
    render::WritePng(files.Signatures(), JoinSignatures(view.signatures));
    for (const KeyPicture& key : view.keys) {
      render::WritePng(files.Colour(key.frame), key.colour);
      WriteDepths(files.Depth(key.frame), key.depth);
      WriteBodies(files.Bodies(key.frame), key.bodies);
    }
  }
  const fs::path path = folder / kGoldenFile;
  std::ofstream file(path, std::ios::binary);
  file << TextOf(golden);
  file.close();
  if (!file) throw EnvironmentError(fmt::format("{}: cannot be written", path.string()));
}

fs::path Beside(const fs::path& folder, const char* end) {
  fs::path other = folder;
  other += end;
  return other;
}

/// Puts `made` where `folder` is.
void Exchange(const fs::path& made, const fs::path& folder) {
  const fs::path old = Beside(folder, ".old");
  fs::remove_all(old);
  const bool replaces = fs::exists(folder);
  if (replaces) fs::rename(folder, old);
  try {
    fs::rename(made, folder);
  } catch (const fs::filesystem_error&) {
    if (replaces) fs::rename(old, folder);
    throw;
  }
  fs::remove_all(old);
}

void RequireFewBodies(const Pictures& pictures) {
  constexpr std::size_t kMost = 254;
  if (pictures.bodies.size() <= kMost) return;
  throw InputError(fmt::format("the scene has {} bodies; a golden tells at most {} apart",
                               pictures.bodies.size(), kMost));
}

}  // namespace

Golden ReadGolden(const fs::path& folder) {
  Golden golden = ReadGoldenText(folder / kGoldenFile);
  for (ViewPictures& view : golden.pictures.views) {
    ReadPictures(folder, golden.pictures.frames, view);
  }
  return golden;
}

void WriteGolden(const fs::path& folder, const Golden& golden) {
  RequireFewBodies(golden.pictures);
  const fs::path made = Beside(folder, ".partial");
  try {
    fs::remove_all(made);
    fs::create_directories(made);
    WriteInto(made, golden);
    Exchange(made, folder);
  } catch (const fs::filesystem_error& error) {
    std::error_code ignored;
    fs::remove_all(made, ignored);
    throw EnvironmentError(fmt::format("{}: cannot be written ({}); what was there is as it was",
                                       folder.string(), error.code().message()));
  } catch (const Error&) {
    std::error_code ignored;
    fs::remove_all(made, ignored);
    throw;
  }
}

}  // namespace twin::golden
