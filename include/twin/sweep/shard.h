#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "twin/run/catalogue.h"
#include "twin/sweep/points.h"

namespace twin::sweep {

/// Share of a sweep's runs: those whose number leaves `index` when divided by `count`. With
/// stop_at_width points are shared out in the same way, since a point's end hangs on its runs.
struct Shard {
  std::uint64_t index = 0;  ///< < count
  std::uint64_t count = 1;
};

/// "3/64". @throws InputError for anything else.
[[nodiscard]] Shard ParseShard(std::string_view text);

/// Largest number of runs of a shard; fewer when points end early.
[[nodiscard]] std::uint64_t RunsOf(const Sweep& sweep, const Shard& shard);

/// Of a point that may end early: whether it ends after `runs` runs, of which `failures` failed.
[[nodiscard]] bool EndsPoint(const Sweep& sweep, std::uint64_t runs, std::uint64_t failures);

/// What carries a shard out.
struct ShardWork {
  const run::Catalogue& catalogue;
  const run::RunFiles& files;
  std::filesystem::path out;  ///< folder of results
  /// After each run: whether it was there already. May be empty.
  std::function<void(bool was_there)> done{};
  const volatile bool* interrupted = nullptr;  ///< set from a signal handler; may be null
};

/// Carries out the runs of a shard whose results are not in the folder yet; a file that is not
/// whole is no result. Each result is put there at once, whole. A run whose log the sweep keeps is
/// carried out once more for it, behind its result. Killed at any time and begun again, it goes on.
/// Several may work in one folder, even on the same shard.
///
/// Threads: one thread. @throws InputError when the scenario refuses a point (named),
/// EnvironmentError when a result cannot be written. An interrupt ends it.
void RunShard(const Sweep& sweep, const Shard& shard, const ShardWork& work);

}  // namespace twin::sweep
