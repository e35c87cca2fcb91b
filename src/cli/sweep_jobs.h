#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/terminal.h"
#include "twin/sweep/shard.h"

namespace twin::cli {

/// The descriptor on which a worker writes a byte for each run that is done.
inline constexpr int kDoneDescriptor = 3;

/// A shard's parts, each carried out by a process of its own.
struct SweepJobs {
  std::filesystem::path executable;
  std::vector<std::string> arguments;  ///< of each, without --shard: "sweep", "run", FILE, ...
  int jobs = 2;
  sweep::Shard shard;
  std::uint64_t runs = 0;  ///< of the shard
};

/// Carries a shard out by processes at low priority (nice 10). One that a signal ends is begun
/// anew, at most three times; the results that it wrote stay.
/// @throws InputError when the scenario refuses a point, EnvironmentError when one fails for good,
/// after all others have ended; Interrupted.
void RunJobs(const SweepJobs& jobs, Terminal& terminal);

/// Progress of a sweep: how many runs are done, and the time that is left.
class SweepProgress {
 public:
  /// @param runs  most that there are to do.
  SweepProgress(std::uint64_t runs, Terminal& terminal) : runs_(runs), terminal_(terminal) {}

  /// @param done  more runs. @param was_there  their results were there already.
  void Add(std::uint64_t done, bool was_there);

 private:
  const std::uint64_t runs_;
  Terminal& terminal_;
  const MonotonicClock clock_;
  std::uint64_t done_ = 0;
  std::uint64_t carried_out_ = 0;
};

}  // namespace twin::cli
