#pragma once

#include <functional>
#include <memory>
#include <string>

#include "loop/motion_watch.h"
#include "twin/core/rest.h"
#include "twin/loop/communication_loop.h"
#include "twin/loop/exchange.h"
#include "twin/loop/motion_run.h"
#include "twin/loop/run_report.h"

namespace twin::loop {

/// Where nothing is drawn: what things cost is what passes.
[[nodiscard]] MotionRun WithoutModels(MotionRun run);

/// @returns the communication loop that `run` asks for, around `tick`.
[[nodiscard]] std::unique_ptr<CommunicationLoop> MakeLoop(const MotionRun& run, ControlTick& tick,
                                                          Exchange& exchange);

/// What a drive does for a motion: lets time pass, and keeps the communication side going in it.
class Stage {
 public:
  virtual ~Stage() = default;
  [[nodiscard]] virtual Time Now() const = 0;
  /// Lets time pass until `done()`, which is asked often. @returns false when `limit` came first.
  [[nodiscard]] virtual bool PassUntil(Time limit, const std::function<bool()>& done) = 0;
  /// The newest state that was read. @pre the watch has one.
  [[nodiscard]] virtual const RobotState& State() = 0;
  /// Tells the communication side that a motion is about to start.
  virtual void Activate(const MotionModes& modes) = 0;
  /// Ends the controller's updates.
  virtual void StopController() = 0;
};

/// The life of a motion, the same in every drive: first state, activation, start, motion, end,
/// conclusion.
///
/// Threads: the onlooker's. The watch is what it knows of the others.
class MotionSession {
 public:
  MotionSession(const MotionRun& run, Stage& stage, MotionWatch& watch)
      : run_(run), stage_(stage), watch_(watch) {}

  /// @throws as LockstepDrive::Run. The figures of the communication loop are the drive's to add.
  [[nodiscard]] RunReport Run();

 private:
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
    if (run_.event) run_.event(stage_.Now(), kind, text);
  }

  const MotionRun& run_;
  Stage& stage_;
  MotionWatch& watch_;
  RestWatch rest_;
  std::uint64_t newest_ = 0;  ///< id of the newest state that was looked at; 0: none yet
  bool stopping_ = false;
  bool deaf_ = false;  ///< no state comes any more
  Time next_look_{};
  Time next_attendance_{};
  Time silent_since_{};  ///< at the earliest
};

}  // namespace twin::loop
