#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "twin/run/catalogue.h"
#include "twin/scenario/scenario.h"
#include "twin/sweep/points.h"

namespace twin::sweep {

/// What came of a run. The same run gives the same bytes wherever it ran; nothing here is of the
/// wall clock.
struct Result {
  std::string address;                    ///< as AddressBook gives it
  std::string outcome;                    ///< "success", "aborted" or "failed"
  std::string error;                      ///< why; empty after success
  std::uint64_t served = 0;               ///< cycles with a command in time
  std::uint64_t held = 0;                 ///< cycles without one
  std::optional<double> final_error_rad;  ///< of a motion
  std::optional<double> deviation_rad;    ///< largest, of a motion on joints
  std::optional<double> deviation_m;      ///< largest, of a motion of poses
  double duration_s = 0;                  ///< robot's time
  std::string states_hash;                ///< 16 hexadecimal digits
  std::string version;                    ///< of the program

  [[nodiscard]] bool succeeded() const noexcept { return outcome == "success"; }
};

/// A run of a sweep, ready to be run.
struct PreparedCase {
  Case one;
  scenario::Scenario scenario;
  std::string address;  ///< 32 hexadecimal digits
};

/// Makes the runs of a sweep, and their addresses: a hash of the scenario, its seed, the version of
/// the program, the variant of the C library's mathematics, and the content of the robots, the
/// scene and the controller's library. Meshes, which are only drawn, are no part of it. The hash is
/// ContentHash: 128 bits, not secure against adversaries.
///
/// Values that are numbers, with or without a unit, go into the hash beside the scenario that has
/// none of them in place: its text without comments, and all that it says with its files read.
/// Together they decide on the run as its own scenario does, of which a million would take half an
/// hour.
///
/// Threads: one thread. It keeps the last point, so that runs in order are made faster.
class CaseMaker {
 public:
  /// @param sweep, files  must outlive this.
  CaseMaker(const Sweep& sweep, const run::RunFiles& files);

  /// A run's address. @throws as Sweep::ScenarioOf, where a point's scenario has to be read.
  [[nodiscard]] std::string AddressOf(const Case& one);
  /// @param address  of AddressOf(one). @returns the run, until the next call.
  /// @throws as Sweep::ScenarioOf.
  const PreparedCase& Make(Case one, std::string address);
  /// As the two above.
  const PreparedCase& Make(std::uint64_t run);

 private:
  /// Of the scenario with those values alone that are not numbers.
  const std::string& HashOfRest(const Case& one);

  const Sweep& sweep_;
  const run::RunFiles& files_;
  const std::string robots_;       ///< hash of program, mathematics and robots
  std::vector<std::size_t> axes_;  ///< in order of their keys
  std::optional<PreparedCase> last_;
  std::unordered_map<std::string, std::string> rest_;  ///< hashes, by the values
  std::string whole_;  ///< hash of the last scenario that cannot be read without its numbers
};

/// DIR/runs/<2 digits>/<address>.json.
[[nodiscard]] std::filesystem::path FileOf(const std::filesystem::path& out,
                                           const std::string& address);

/// Of a run whose log is kept: DIR/logs/<2 digits>/<address>, with run.mcap, scenario.yaml and
/// summary.json.
[[nodiscard]] std::filesystem::path LogFolderOf(const std::filesystem::path& out,
                                                const std::string& address);

/// A result's file. @param axes  their keys, in the order of the case's values.
[[nodiscard]] std::string ToJson(const Result& result, const Case& one,
                                 const std::vector<scenario::SweepAxis>& axes);

/// @returns the result of a file; nullopt when there is none that is whole and of this address.
[[nodiscard]] std::optional<Result> ReadResult(const std::filesystem::path& file,
                                               const std::string& address);

/// Runs a motion or an application once, without a log.
/// @param interrupted  set from a signal handler; may be null. An interrupted run gives nullopt.
/// @throws InputError when the scenario is not acceptable, EnvironmentError. What the robot refuses
/// or a planner does not find is an outcome.
[[nodiscard]] std::optional<Result> RunCase(const PreparedCase& prepared,
                                            const run::Catalogue& catalogue,
                                            const run::RunFiles& files,
                                            const volatile bool* interrupted);

}  // namespace twin::sweep
