#include "twin/sweep/shard.h"

#include <unistd.h>

#include <system_error>

#include <fmt/format.h>

#include "sweep/log.h"
#include "twin/core/error.h"
#include "twin/core/integer.h"
#include "twin/core/proportion.h"
#include "twin/run/result_folder.h"
#include "twin/sweep/result.h"

namespace twin::sweep {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostShards = 1'000'000;
constexpr std::uint64_t kLook = 10;  ///< a point's interval is looked at after so many runs

/// Numbers below `all` that leave `index`.
std::uint64_t CountOf(std::uint64_t all, const Shard& shard) {
  return all / shard.count + (shard.index < all % shard.count ? 1 : 0);
}

/// Puts a result in its place. Two processes that have the same run do not wait for each other:
/// both write the same bytes under a name of their own, and rename.
void Put(const fs::path& file, const std::string& text) {
  run::MakeFolder(file.parent_path());
  fs::path own = file;
  own += fmt::format(".{}", ::getpid());
  run::WriteWholeFile(own, text);
  std::error_code error;
  fs::rename(own, file, error);
  if (error) throw EnvironmentError(fmt::format("{}: {}", file.string(), error.message()));
}

class Worker {
 public:
  Worker(const Sweep& sweep, const ShardWork& work)
      : sweep_(sweep), work_(work), maker_(sweep, work.files) {}

  /// @returns the run's result; nullopt after an interrupt.
  std::optional<Result> Do(std::uint64_t run) {
    const Case one = sweep_.CaseAt(run);
    const std::string address = maker_.AddressOf(one);
    const fs::path file = FileOf(work_.out, address);
    std::optional<Result> result = ReadResult(file, address);
    const bool was_there = result.has_value();
    if (!was_there) {
      result = Run(maker_.Make(one, address));
      if (!result) return std::nullopt;
      Put(file, ToJson(*result, one, sweep_.file().axes));
    }
    std::error_code none;
    const bool wants_log =
        KeepsLog(sweep_, *result) && !fs::exists(LogFolderOf(work_.out, address), none);
    if (wants_log && !KeepLog(maker_.Make(one, address), work_.catalogue, work_.files, work_.out,
                              work_.interrupted)) {
      return std::nullopt;
    }
    if (work_.done) work_.done(was_there && !wants_log);
    return result;
  }

  [[nodiscard]] bool is_interrupted() const {
    return work_.interrupted != nullptr && *work_.interrupted;
  }

 private:
  std::optional<Result> Run(const PreparedCase& prepared) {
    try {
      return RunCase(prepared, work_.catalogue, work_.files, work_.interrupted);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", sweep_.NameOf(prepared.one), error.what()));
    }
  }

  const Sweep& sweep_;
  const ShardWork& work_;
  CaseMaker maker_;
};

/// All runs of a point, until it ends.
void DoPoint(const Sweep& sweep, std::uint64_t point, Worker& worker) {
  const std::uint64_t seeds = sweep.file().seeds;
  std::uint64_t failures = 0;
  for (std::uint64_t i = 0; i < seeds && !worker.is_interrupted(); ++i) {
    const std::optional<Result> result = worker.Do(point * seeds + i);
    if (!result) return;
    failures += result->succeeded() ? 0 : 1;
    if (EndsPoint(sweep, i + 1, failures)) return;
  }
}

}  // namespace

Shard ParseShard(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash != std::string_view::npos) {
    const auto index = ParseInteger<std::uint64_t>(text.substr(0, slash));
    const auto count = ParseInteger<std::uint64_t>(text.substr(slash + 1));
    if (index && count && *index < *count && *count <= kMostShards) return {*index, *count};
  }
  throw InputError(
      fmt::format("shard \"{}\": must be i/n, such as 3/64, with i from 0 to n - 1", text));
}

std::uint64_t RunsOf(const Sweep& sweep, const Shard& shard) {
  if (!sweep.file().stop_at_width) return CountOf(sweep.runs(), shard);
  return CountOf(sweep.points(), shard) * sweep.file().seeds;
}

bool EndsPoint(const Sweep& sweep, std::uint64_t runs, std::uint64_t failures) {
  if (!sweep.file().stop_at_width || runs % kLook != 0) return false;
  const auto [least, most] = WilsonInterval(static_cast<int>(failures), static_cast<int>(runs));
  return most - least < *sweep.file().stop_at_width;
}

void RunShard(const Sweep& sweep, const Shard& shard, const ShardWork& work) {
  run::MakeFolder(work.out);
  run::TryToWrite(work.out);
  Worker worker(sweep, work);
  const bool by_point = sweep.file().stop_at_width.has_value();
  const std::uint64_t all = by_point ? sweep.points() : sweep.runs();
  for (std::uint64_t i = shard.index; i < all && !worker.is_interrupted(); i += shard.count) {
    if (by_point) {
      DoPoint(sweep, i, worker);
    } else {
      static_cast<void>(worker.Do(i));
    }
  }
}

}  // namespace twin::sweep
