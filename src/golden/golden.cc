#include "twin/golden/golden.h"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "golden/golden_files.h"
#include "twin/core/error.h"
#include "twin/golden/signature.h"
#include "twin/render/image.h"

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
  throw InputError(fmt::format("{}: is of {} x {} pixels, {} says {} x {}", path.string(),
                               picture.width, picture.height, kGoldenFile, view.width,
                               view.height));
}

void ReadPictures(const fs::path& folder, std::size_t frames, ViewPictures& view) {
  const ViewFiles files(folder, view.name);
  view.signatures = SplitSignatures(render::ReadPng(files.Signatures()), frames);
  if (view.signatures.empty()) {
    throw InputError(fmt::format("{}: is not of the size that {} frames make",
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

void WriteFile(const fs::path& path, std::string_view bytes) {
  errno = 0;
  std::ofstream file(path, std::ios::binary);
  file << bytes;
  file.close();
  if (file) return;
  throw EnvironmentError(fmt::format("{}: cannot be written ({})", path.string(),
                                     std::generic_category().message(errno)));
}

void WriteColours(const fs::path& path, const render::Image& picture) {
  const std::vector<char> png = render::EncodePng(picture);
  WriteFile(path, {png.data(), png.size()});
}

void WriteInto(const fs::path& folder, const Golden& golden) {
  for (const ViewPictures& view : golden.pictures.views) {
    const ViewFiles files(folder, view.name);
    WriteColours(files.Signatures(), JoinSignatures(view.signatures));
    for (const KeyPicture& key : view.keys) {
      WriteColours(files.Colour(key.frame), key.colour);
      WriteDepths(files.Depth(key.frame), key.depth);
      WriteBodies(files.Bodies(key.frame), key.bodies);
    }
  }
  WriteFile(folder / kGoldenFile, TextOf(golden));
}

void RequireFewBodies(const Pictures& pictures) {
  constexpr std::size_t kMost = 254;
  if (pictures.bodies.size() <= kMost) return;
  throw InputError(fmt::format("the scene has {} bodies; a golden tells at most {} apart",
                               pictures.bodies.size(), kMost));
}

/// File names of a golden.
std::set<std::string> FilesOf(const Golden& golden) {
  std::set<std::string> names{kGoldenFile};
  for (const ViewPictures& view : golden.pictures.views) {
    const ViewFiles files("", view.name);
    names.insert(files.Signatures());
    for (const KeyPicture& key : view.keys) {
      names.insert({files.Colour(key.frame), files.Depth(key.frame), files.Bodies(key.frame)});
    }
  }
  return names;
}

[[noreturn]] void ThrowWithCure(const InputError& error, const fs::path& folder) {
  throw InputError(fmt::format(
      "{}; bring it back (git checkout -- {}), or remove the folder and approve the case anew",
      error.what(), folder.string()));
}

[[noreturn]] void ThrowForeign(const fs::path& path) {
  throw InputError(fmt::format(
      "{}: not written by panda-twin video approve, which replaces the folder; move it elsewhere",
      path.string()));
}

/// File names that a golden's folder should contain.
std::set<std::string> FilesIn(const fs::path& folder) {
  if (!fs::exists(folder / kGoldenFile)) return {};
  try {
    return FilesOf(ReadGoldenText(folder / kGoldenFile));
  } catch (const InputError& error) {
    ThrowWithCure(error, folder);
  }
}

void RemovePartial(const fs::path& made) {
  std::error_code ignored;
  fs::remove_all(made, ignored);
}

}  // namespace

bool HasGolden(const fs::path& folder) {
  return fs::exists(WholeOf(folder));
}

Golden ReadGolden(const fs::path& named) {
  const fs::path folder = WholeOf(named);
  try {
    Golden golden = ReadGoldenText(folder / kGoldenFile);
    for (ViewPictures& view : golden.pictures.views) {
      ReadPictures(folder, golden.pictures.frames, view);
    }
    return golden;
  } catch (const InputError& error) {
    ThrowWithCure(error, named);
  }
}

void RequireNothingElse(const fs::path& named) {
  const fs::path folder = WholeOf(named);
  try {
    if (!fs::exists(folder)) return;
    const std::set<std::string> ours = FilesIn(folder);
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (!ours.contains(entry.path().filename())) ThrowForeign(entry.path());
    }
  } catch (const fs::filesystem_error& error) {
    throw EnvironmentError(
        fmt::format("{}: cannot be read ({})", folder.string(), error.code().message()));
  }
}

void WriteGolden(const fs::path& folder, const Golden& golden) {
  RequireFewBodies(golden.pictures);
  const fs::path made = PartialOf(folder);
  try {
    RequireNothingElse(folder);
    fs::remove_all(made);
    fs::create_directories(made);
    WriteInto(made, golden);
    Exchange(made, folder);
  } catch (const fs::filesystem_error& error) {
    RemovePartial(made);
    throw EnvironmentError(fmt::format("{}: cannot be written ({}); what was there is as it was",
                                       folder.string(), error.code().message()));
  } catch (const EnvironmentError& error) {
    RemovePartial(made);
    throw EnvironmentError(fmt::format(
        "{}; what was approved before is as it was: make room, and approve again", error.what()));
  } catch (const Error&) {
    RemovePartial(made);
    throw;
  }
}

}  // namespace twin::golden
