#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/golden/pictures.h"

namespace twin::golden {

/// A user's approval and its reason.
struct Approval {
  std::string reason;   ///< in the user's words
  std::string changed;  ///< the change, as described by the program
  std::string version;  ///< of the program
};

/// One rendering of the approved pictures, by processor and rasteriser: the hashes of all frames,
/// by view.
using Rendering = std::vector<std::vector<std::uint64_t>>;

/// The approved pictures of a case, and hashes for their fast recognition.
struct Golden {
  Pictures pictures;                  ///< without hashes
  std::vector<std::uint64_t> states;  ///< approved hashes of all states of the run
  std::vector<Rendering> renderings;
  std::vector<Approval> approvals;  ///< the first is the oldest
};

/// The main file of a golden's folder.
inline constexpr const char* kGoldenFile = "golden.yaml";

/// True if an approval exists: its folder, or one put aside by a killed WriteGolden(), from which
/// it is read and replaced in the same way.
[[nodiscard]] bool HasGolden(const std::filesystem::path& folder);

/// Reads a folder that WriteGolden wrote:
///   golden.yaml                     all data except pictures
///   <view>.png                      the signatures of all frames, JoinSignatures()
///   <view>_<frame>.png              a key picture, in colour,
///   <view>_<frame>_depth.png        its depth, 16-bit grey, 0.25 mm, 0: no surface,
///   <view>_<frame>_bodies.png       and its bodies, 8-bit grey, 255: no body
/// @throws InputError naming file, fault and cure: missing, damaged, a size or format other than in
/// golden.yaml.
[[nodiscard]] Golden ReadGolden(const std::filesystem::path& folder);

/// @throws InputError naming a foreign file in a golden's folder, which replacing the golden would
/// delete. A missing or empty folder passes.
void RequireNothingElse(const std::filesystem::path& folder);

/// Writes a golden, replacing an existing one: writes it beside and exchanges the folders, so that
/// a complete golden exists after any failure. Creates parent folders. One writer at a time: see
/// GoldensLock.
/// @throws EnvironmentError naming what cannot be written; InputError for more bodies than a
/// picture can represent, and as RequireNothingElse().
void WriteGolden(const std::filesystem::path& folder, const Golden& golden);

}  // namespace twin::golden
