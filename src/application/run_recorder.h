#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/application/record_run.h"
#include "twin/core/clock.h"
#include "twin/fci/capture.h"
#include "twin/record/log_records.h"
#include "twin/render/film.h"
#include "twin/run/operator_page.h"
#include "twin/run/result_folder.h"
#include "twin/run/run_records.h"
#include "twin/run/summary.h"

namespace twin::application {

/// What RecordRun() is given. All must outlive who refers to it.
struct RunParts {
  const scenario::Scenario& scenario;
  const RunOptions& options;
  const run::RunFiles& files;
  const run::Catalogue& catalogue;
  run::Console& console;
};

/// The recorder of a run: connects, runs, writes the results, tells the summary. What a motion and
/// an application do differently, derived classes say.
///
/// Threads: one thread.
class RunRecorder {
 public:
  explicit RunRecorder(const RunParts& parts);
  virtual ~RunRecorder() = default;
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  /// Once. @param capture  is made when the options want one; must outlive this.
  /// @throws as RecordRun().
  void Execute(std::optional<fci::Capture>& capture);
  /// Whether the folder of results holds this run's summary.
  [[nodiscard]] bool has_summary() const noexcept { return has_summary_; }

 protected:
  /// A run that is connected to its robot.
  struct Connected {
    const backend::Connection* connection = nullptr;
    const scenario::RobotData* robot = nullptr;
    std::function<bool(const run::TellCheck&)> check_start;
    Duration longest{};             ///< what comes later is not filmed
    bool evaluates_scenes = false;  ///< they are kept also when there is neither log nor video
  };
  /// What came of it.
  struct Outcome {
    std::string failure{};  ///< empty: it went well
    std::string cause{};    ///< what is told beside it
    Duration simulated{};
    std::vector<record::PlanRecord> plans{};
    std::vector<run::FollowedMotion> followed{};
    std::vector<std::string> notices{};  ///< of the workstation's threads
    backend::RobotTimings robot{};
  };

  [[nodiscard]] const scenario::Scenario& scenario() const noexcept { return parts_.scenario; }
  [[nodiscard]] bool is_interrupted() const { return parts_.console.interrupted(); }
  /// Whether pictures can be made of it.
  [[nodiscard]] bool is_filmed() const { return makes_video() && records_.was_filmed(); }
  [[nodiscard]] double SecondsSince(Time begin) const { return ToSeconds(clock_.Now() - begin); }

  const MonotonicClock clock_;
  const RunParts parts_;
  run::ResultFolder out_;
  run::RunRecords records_;
  run::WallTimes times_;
  run::OperatorPage page_;

 private:
  [[nodiscard]] virtual Connected Connect(const run::RealtimeSettings& settings) = 0;
  [[nodiscard]] virtual Outcome Perform(const run::RunHooks& hooks) = 0;
  /// With the whole log.
  virtual void Evaluate(Outcome& /*outcome*/) {}
  [[nodiscard]] virtual std::string SummaryOfFile() const = 0;
  [[nodiscard]] virtual std::string SummaryForPeople() const = 0;
  virtual void Draw(const render::Film& film, const render::FilmSettings& settings) = 0;
  /// @param plots  of the whole run.
  virtual void Report(const std::vector<std::filesystem::path>& /*plots*/) const {}

  void Prepare(std::optional<fci::Capture>& capture);
  void OpenPage();
  void BeginRecords();
  void Perform();
  /// Once, as soon as the log cannot be written any more.
  void WarnOfLostLog();
  void WriteResults();
  void MakePictures();
  /// After a run that went well: says which of its motions were further off their targets than the
  /// scenario's max_deviation. Warns; @throws RobotFault when that is a failure.
  void EvaluateDeviations() const;
  [[nodiscard]] bool is_remote() const { return scenario().is_remote(); }
  /// Not to make one is no part of the scenario: log and plots are the same with and without.
  [[nodiscard]] bool wants_video() const {
    return scenario().render.enabled && parts_.options.makes_video;
  }
  [[nodiscard]] bool makes_video() const {
    return wants_video() && run_.connection->truth != nullptr;
  }

  run::RealtimeSettings settings_;
  Connected run_;
  Outcome outcome_;
  bool told_of_log_ = false;
  bool has_summary_ = false;
};

/// Of the scenario's motion, and of its application.
[[nodiscard]] std::unique_ptr<RunRecorder> MakeMotionRecorder(const RunParts& parts);
[[nodiscard]] std::unique_ptr<RunRecorder> MakeApplicationRecorder(const RunParts& parts);

}  // namespace twin::application
