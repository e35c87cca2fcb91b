#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "application/run_recorder.h"
#include "controllers/registration.h"
#include "plugins/backends.h"
#include "twin/application/application.h"
#include "twin/core/clock.h"
#include "twin/plant/contact_watch.h"
#include "twin/record/recorder.h"
#include "twin/scenario/scenario.h"

namespace twin::application::test {

/// The models that come with the program.
inline std::filesystem::path Models() {
  return std::filesystem::path(TWIN_SOURCE_DIR) / "models";
}

/// The file of an application that comes with the program.
inline std::filesystem::path FileOf(const std::string& name) {
  return Models() / "applications" / (name + ".yaml");
}

/// An application carried out in this process, with a log and somebody who watches for contacts.
class Performance final : public record::RecordSink {
 public:
  /// @param folder  for the log; empty: none is written. @param devices  of operators; may be null.
  explicit Performance(const scenario::Scenario& scenario, std::filesystem::path folder = {},
                       const run::RealtimeConfig& settings = {},
                       const teleop::DeviceRegistry* devices = nullptr)
      : folder_(std::move(folder)) {
    plugins::RegisterMujoco(backends_);
    plugins::RegisterFci(backends_);
    controllers::RegisterControllers(controllers_);
    run_.emplace(scenario, run::Catalogue{backends_, controllers_, devices}, files_, this, clock_,
                 settings);
    if (!folder_.empty()) {
      log_.emplace(
          LogPath(),
          record::RunInfo{scenario.name, scenario.seed, "test", "lockstep", "",
                          record::RunLimits{run_->robot().limits, run_->robot().cartesian}},
          record::FullRing::kWait);
    }
    if (truth() != nullptr) contacts_.emplace(*truth());
  }

  void Put(const record::CycleRecord& record) noexcept override {
    if (contacts_) contacts_->Look(record.at);
    if (log_) log_->Put(record);
  }
  void Put(const record::TickRecord& record) noexcept override {
    if (log_) log_->Put(record);
  }

  /// Does it and judges it.
  void Perform() {
    task_result = run_->Execute({}, [this](std::string_view line) { told.emplace_back(line); });
    if (log_) static_cast<void>(log_->Finish());
    evaluation = run_->Evaluate({.log = log_ ? LogPath() : std::filesystem::path(),
                                 .contacts = contacts_ ? &*contacts_ : nullptr});
  }

  [[nodiscard]] bool succeeded() const { return FailureOf(task_result, evaluation).empty(); }
  /// For messages: why not, and what was found.
  [[nodiscard]] std::string Story() const {
    std::string story = FailureOf(task_result, evaluation) + "\n";
    for (const std::string& line : told) story += line + "\n";
    for (const Finding& finding : evaluation.findings) {
      story += finding.quantity + ": " + std::to_string(finding.value) + " " + finding.unit + "\n";
    }
    return story;
  }
  /// Draws the figures. @returns how many of them the page has.
  [[nodiscard]] std::size_t FiguresOnPage() const {
    const std::string html = PageOf({}, task_result, evaluation, {});
    std::size_t count = 0;
    for (std::size_t at = html.find("</svg>"); at != std::string::npos;
         at = html.find("</svg>", at + 1)) {
      ++count;
    }
    return count;
  }
  /// The finding that begins so; null when there is none.
  [[nodiscard]] const Finding* Find(std::string_view quantity) const {
    for (const Finding& finding : evaluation.findings) {
      if (finding.quantity.starts_with(quantity)) return &finding;
    }
    return nullptr;
  }
  [[nodiscard]] const plant::TruthProbe* truth() const { return run_->connection().truth; }
  [[nodiscard]] ApplicationRun& run() { return *run_; }

  TaskResult task_result;
  Evaluation evaluation;
  std::vector<std::string> told;

 private:
  [[nodiscard]] std::filesystem::path LogPath() const { return folder_ / "run.mcap"; }

  const MonotonicClock clock_;
  const run::RunFiles files_{.models = Models(), .mesh_package = {}, .cache = {}};
  const std::filesystem::path folder_;
  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  std::optional<record::Recorder> log_;
  std::optional<plant::ContactWatch> contacts_;
  std::optional<ApplicationRun> run_;
};

}  // namespace twin::application::test
