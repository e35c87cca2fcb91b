#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/scenario/scenario.h"
#include "twin/scenario/sweep_file.h"

namespace twin::sweep {

/// One run of a sweep.
struct Case {
  std::uint64_t point = 0;  ///< from 0; for people and in files from 1
  std::uint64_t seed = 0;
  std::vector<std::string> values;  ///< of each axis, as YAML in one line
};

/// A sweep's points and runs. No list of them is held: a sweep of 10^9 runs takes no more memory
/// than one of ten (samples take 4 bytes for each point and axis). Runs are numbered
/// from 0, point by point, and in a point in order of their seeds.
///
/// Threads: const calls any.
class Sweep {
 public:
  /// Reads the file, and the text of the scenario that it names: beside it, else in the models
  /// folder, or there in `scenarios`.
  /// @throws InputError as scenario::LoadSweep; when there is no such scenario, or there are more
  /// runs than the file's budget, or more than 2^63.
  Sweep(const std::filesystem::path& file, const std::filesystem::path& models);

  [[nodiscard]] const scenario::SweepFile& file() const noexcept { return file_; }
  [[nodiscard]] const std::filesystem::path& scenario_file() const noexcept {
    return scenario_file_;
  }
  [[nodiscard]] std::uint64_t points() const noexcept { return points_; }
  [[nodiscard]] std::uint64_t runs() const noexcept { return points_ * file_.seeds; }
  /// Whether runs of one point differ in more than their seed.
  [[nodiscard]] bool draws() const noexcept;

  /// Values of a point; of axes that each run draws empty. @pre point < points().
  [[nodiscard]] std::vector<std::string> ValuesAt(std::uint64_t point) const;
  /// @pre run < runs().
  [[nodiscard]] Case CaseAt(std::uint64_t run) const;
  /// The name of an axis' value, where the file gives one; else the value.
  [[nodiscard]] const std::string& LabelOf(std::size_t axis, const std::string& value) const;
  /// "point 3 (link.command_loss: 2 %, plant.mass_scale: 0.8)".
  [[nodiscard]] std::string NameOf(const Case& one) const;
  /// The scenario's text with values in place of its own; an empty value leaves it as it is.
  /// @throws InputError when it is no YAML.
  [[nodiscard]] std::string TextWith(const std::vector<std::string>& values) const;
  /// The scenario with the values and the seed of a run.
  /// @throws InputError "<NameOf>: <scenario's file>: ..." when the scenario refuses a value; lines
  /// are those of the changed text. InputError for one that is not in lockstep.
  [[nodiscard]] scenario::Scenario ScenarioOf(const Case& one) const;
  /// Reads every point's scenario, of sweeps of at most 1000 points; of others the first's.
  /// @throws as ScenarioOf.
  void CheckPoints() const;

 private:
  [[nodiscard]] std::vector<std::vector<std::uint32_t>> Places() const;
  [[nodiscard]] std::string SampledValue(std::size_t axis, std::uint64_t point) const;

  scenario::SweepFile file_;
  std::filesystem::path scenario_file_;
  std::string scenario_text_;
  std::uint64_t points_ = 1;
  /// For each axis where each point lies: of a Latin hypercube its stratum, of a Sobol sequence its
  /// number, of 2^32. Empty for axes that are drawn.
  std::vector<std::vector<std::uint32_t>> places_;
};

}  // namespace twin::sweep
