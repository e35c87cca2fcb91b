#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/golden/pictures.h"

namespace twin::golden {

/// Somebody looked, and said why this is right.
struct Approval {
  std::string reason;   ///< in their words
  std::string changed;  ///< what it changed, in ours
  std::string version;  ///< of the program
};

/// One way in which the approved pictures come out, by processor and rasteriser: the hashes of all
/// frames, by view.
using Rendering = std::vector<std::vector<std::uint64_t>>;

/// What was approved of a case: pictures, and hashes by which they are known at once.
struct Golden {
  Pictures pictures;                  ///< without hashes
  std::vector<std::uint64_t> states;  ///< approved hashes of all states of the run
  std::vector<Rendering> renderings;
  std::vector<Approval> approvals;  ///< the first is the oldest
};

/// The file of a golden's folder that names all others.
inline constexpr const char* kGoldenFile = "golden.yaml";

/// Whether anything was approved: its folder is there, or was put aside by a WriteGolden() that was
/// killed, from where it is read and replaced as if it were in its place.
[[nodiscard]] bool HasGolden(const std::filesystem::path& folder);

/// Reads a folder that WriteGolden wrote:
///   golden.yaml                     everything but pictures
///   <view>.png                      the signatures of all frames, JoinSignatures()
///   <view>_<frame>.png              a key picture, in colour,
///   <view>_<frame>_depth.png        its depth, 16-bit grey, 0.25 mm, 0: nothing there,
///   <view>_<frame>_bodies.png       and its bodies, 8-bit grey, 255: nothing there
/// @throws InputError naming the file and what is wrong with it: missing, damaged, of another size
/// than golden.yaml says, of another format; and how to get it back.
[[nodiscard]] Golden ReadGolden(const std::filesystem::path& folder);

/// @throws InputError naming a file in a golden's folder that is not the golden's: it would be lost
/// when the golden is replaced. A folder that is not there or empty will do.
void RequireNothingElse(const std::filesystem::path& folder);

/// Writes a golden in place of the one that is there, if any: beside it, then exchanged, so that
/// whatever fails, and whenever the program is killed, a whole golden is there. Folders above it
/// are made. One at a time: see GoldensLock.
/// @throws EnvironmentError naming what cannot be written; InputError when there are more bodies
/// than a picture can tell apart, and as RequireNothingElse().
void WriteGolden(const std::filesystem::path& folder, const Golden& golden);

}  // namespace twin::golden
