#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "loop/motion_watch.h"
#include "twin/core/rest.h"
#include "twin/loop/communication_loop.h"
#include "twin/loop/control_tick.h"
#include "twin/loop/controller_loop.h"
#include "twin/loop/exchange.h"
#include "twin/loop/motion_run.h"
#include "twin/loop/run_report.h"

namespace twin::loop {

/// Why a robot that is silent for this long counts as gone.
[[nodiscard]] std::string NoStateFor(Duration silence);

/// @returns `run` without its delay and cost models: on a clock, actual time passes.
[[nodiscard]] MotionRun WithoutModels(MotionRun run);

/// @returns the communication loop of the kind that `run` selects, with `tick`.
[[nodiscard]] std::unique_ptr<CommunicationLoop> MakeLoop(const MotionRun& run, ControlTick& tick,
                                                          Exchange& exchange);

/// Runs one motion: first state, activation, start, motion, end, rest. Each drive derives from it
/// and implements the passage of time and the thread of the communication loop.
///
/// Threads: the caller's, called the supervisor. It observes the others through the watch only.
class MotionRunner {
 public:
  virtual ~MotionRunner() = default;
  MotionRunner(const MotionRunner&) = delete;
  MotionRunner& operator=(const MotionRunner&) = delete;

  /// @throws as Drive::Run.
  [[nodiscard]] RunReport Run();

 protected:
  /// The derived class must create loop_. @param run  must outlive the runner.
  explicit MotionRunner(const MotionRun& run);

  [[nodiscard]] virtual Time Now() const = 0;
  /// Lets time pass until `done()`, called often, returns true. @returns false when `limit` has
  /// passed first.
  [[nodiscard]] virtual bool PassUntil(Time limit, const std::function<bool()>& done) = 0;
  /// The newest state read. @pre the watch has a state.
  [[nodiscard]] virtual const RobotState& State() { return loop_->state(); }
  /// Prepares the communication loop for a motion.
  virtual void Activate(const MotionModes& modes) { loop_->Activate(modes); }
  /// Ends the controller's updates.
  virtual void StopController() = 0;
  /// Ends the motion's threads; the caller may then use the loops.
  virtual void EndThreads() {}

  const MotionRun& run_;
  Exchange exchange_;
  MotionWatch watch_;
  ControlTick tick_;
  ControllerLoop controller_loop_;
  std::unique_ptr<CommunicationLoop> loop_;

 private:
  [[nodiscard]] RunReport RunToEnd();
  bool Pass(Time limit, const std::function<bool()>& done);
  void StopEarly(RunReport& report, std::string why);
  void Conclude(RunReport& report);
  void JudgeRest(RunReport& report);
  [[nodiscard]] std::string WhyNotEnded() const;
  [[nodiscard]] bool Interrupted() const noexcept {
    return run_.interrupted != nullptr && *run_.interrupted;
  }
  void Attend();
  void LookOn();
  void WatchRest();
  void NoticeSilence();
  void NoticeUnseenEnd();
  void Tell(std::string_view kind, std::string_view text) {
    if (run_.event) run_.event(Now(), kind, text);
  }

  RestWatch rest_;
  std::uint64_t newest_ = 0;  ///< message_id of the newest state examined; 0: none yet
  bool stopping_ = false;
  bool deaf_ = false;  ///< states have stopped arriving
  Time next_look_{};
  Time next_attendance_{};
  Time silent_since_{};  ///< earliest start of a silence
};

}  // namespace twin::loop
