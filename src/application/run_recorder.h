#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "application/robot_start.h"
#include "twin/application/application.h"
#include "twin/application/record_run.h"
#include "twin/core/clock.h"
#include "twin/fci/capture.h"
#include "twin/record/log_records.h"
#include "twin/render/film.h"
#include "twin/run/operator_page.h"
#include "twin/run/result_folder.h"
#include "twin/run/run_records.h"
#include "twin/run/summary.h"

namespace twin::replay {
class PlanPictures;
}  // namespace twin::replay

namespace twin::application {

/// Records a run: connects, runs, writes the results and prints the summary. Derived classes
/// implement the differences between a motion and an application.
///
/// Threads: one thread.
class RunRecorder {
 public:
  explicit RunRecorder(const RunInputs& inputs);
  virtual ~RunRecorder() = default;
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  /// Runs; call once. @param capture  set if the options request one; must outlive this.
  /// @throws as RecordRun().
  void Execute(std::optional<fci::Capture>& capture);
  /// True if the folder of results has this run's summary.
  [[nodiscard]] bool has_summary() const noexcept { return has_summary_; }

 protected:
  /// A run connected to its robot.
  struct Connected {
    const backend::Connection* connection = nullptr;
    const scenario::RobotData* robot = nullptr;
    std::function<bool(const run::TellCheck&)> check_start;
    std::optional<JointVector> start{};  ///< where the arm begins, rad
    Duration longest{};                  ///< end of the video
  };
  struct Outcome {
    std::string failure{};  ///< empty: success
    std::string cause{};    ///< follows the failure in the message
    Duration simulated{};
    std::vector<record::PlanRecord> plans{};
    std::vector<run::FollowedMotion> followed{};
    std::vector<std::string> notices{};  ///< of the workstation's threads
    backend::RobotTimings robot{};
    std::string lost_recording{};  ///< as TaskResult's
  };

  [[nodiscard]] const scenario::Scenario& scenario() const noexcept { return inputs_.scenario; }
  [[nodiscard]] bool is_interrupted() const { return inputs_.console.interrupted(); }
  [[nodiscard]] bool is_filmed() const { return makes_video() && records_.was_filmed(); }
  [[nodiscard]] double SecondsSince(Time begin) const { return ToSeconds(clock_.Now() - begin); }

  const MonotonicClock clock_;
  const RunInputs inputs_;
  run::ResultFolder out_;
  run::RunRecords records_;
  run::WallTimes times_;
  run::OperatorPage page_;

 private:
  [[nodiscard]] virtual Connected Connect(const run::RealtimeConfig& settings) = 0;
  [[nodiscard]] virtual Outcome Perform(const run::RunHooks& hooks) = 0;
  /// @pre the log is complete.
  virtual void Evaluate(Outcome& /*outcome*/) {}
  [[nodiscard]] virtual std::string SummaryOfFile() const = 0;
  [[nodiscard]] virtual std::string SummaryOfTerminal() const = 0;
  /// Pictures of the plans. @pre there is one.
  virtual void Draw(const render::Film& film, replay::PlanPictures& pictures) = 0;
  /// @param plots  of the whole run.
  virtual void WriteReport(const std::vector<std::filesystem::path>& /*plots*/) const {}

  void Prepare(std::optional<fci::Capture>& capture);
  void OpenPage();
  void BeginRecords();
  void Perform();
  /// Warns once, when the log can no longer be written.
  void WarnOfLostLog();
  void WriteResults();
  void MakePictures();
  /// Names motions that exceeded the scenario's max_deviation; empty: none did.
  [[nodiscard]] std::string Excess() const;
  /// @param failure  empty: success.
  void KeepInHistory(const std::string& failure) const;
  [[nodiscard]] bool is_remote() const { return scenario().is_remote(); }
  [[nodiscard]] bool wants_video() const {
    return scenario().render.enabled && inputs_.options.makes_video;
  }
  [[nodiscard]] bool makes_video() const {
    return wants_video() && run_.connection->truth != nullptr;
  }

  RobotStart start_;
  run::RealtimeConfig settings_;
  Connected run_;
  Outcome outcome_;
  bool warned_of_log_ = false;
  bool has_summary_ = false;
};

/// For the scenario's application.
[[nodiscard]] std::unique_ptr<RunRecorder> MakeApplicationRecorder(const RunInputs& inputs);

/// Two pictures of a planned motion, PNG; empty paths: none.
struct PicturePair {
  std::filesystem::path planned;
  std::filesystem::path done;
};

/// Contents of the page in addition to task_result and evaluation.
struct PageFacts {
  std::vector<std::pair<std::string, std::string>> lines{};  ///< "lab": "a"; as a table
  std::vector<PicturePair> pictures{};                       ///< one per plan of the task, or none
  std::vector<std::filesystem::path> plots{};                ///< SVG files of the whole run
  bool has_video = false;                                    ///< video.mp4 is in the page's folder
};

/// The report: outcome, demands, steps, pairs of pictures, figures, plots. One HTML file with
/// everything except the video. @throws EnvironmentError if a picture or plot cannot be read.
[[nodiscard]] std::string PageOf(const scenario::Scenario& scenario, const TaskResult& task_result,
                                 const Evaluation& evaluation, const PageFacts& facts);

}  // namespace twin::application
