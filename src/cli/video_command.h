#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/exit_code.h"
#include "twin/run/run.h"

namespace twin::cli {

enum class VideoDeed : std::uint8_t {
  kCheck,    ///< compare; a page when something differs
  kApprove,  ///< keep as right
  kReport,   ///< compare; a page whatever comes of it
};

struct VideoFlags {
  VideoDeed deed = VideoDeed::kCheck;
  std::vector<std::string> cases;  ///< empty: all there are; to approve, at least one
  std::filesystem::path goldens = "tests/golden/cases";
  std::filesystem::path out = "out/video";     ///< of runs and the page
  std::optional<std::filesystem::path> log;    ///< a recorded run instead of a new one; one case
  std::optional<std::filesystem::path> junit;  ///< file for machines
  std::string reason;                          ///< to approve
  bool quiet = false;
  DataFlags data;
};

/// Runs cases, and compares their pictures with those approved, or approves them.
/// @returns kFailed when a case looks different from what was approved. @throws twin::Error;
/// Interrupted.
[[nodiscard]] ExitCode VideoCommand(const VideoFlags& flags, const Host& host,
                                    const run::Catalogue& catalogue);

}  // namespace twin::cli
