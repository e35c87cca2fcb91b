#include "twin/robot/threaded_robot.h"

#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/rt/fiber_thread.h"
#include "twin/rt/host_time.h"

namespace twin::robot {

ThreadedRobot::ThreadedRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                             WorkstationPort& port, const MonotonicClock& clock,
                             rt::ThreadSettings thread, record::RecordSink* sink, Duration timeout)
    : clock_(clock),
      thread_settings_(std::move(thread)),
      timeout_(timeout),
      port_(port),
      robot_(config, std::move(plant), events_, *this, sink),
      calls_(clock) {}

void ThreadedRobot::Begin() {
  const std::scoped_lock lock(requests_);
  TWIN_CHECK(!running_);
  auto run = [this](const std::stop_token& stop) { Run(stop); };
  if (thread_settings_.shared != nullptr) {
    thread_settings_.shared->Add(run);
  } else {
    rt::StartedThread started = rt::StartThread(thread_settings_, run);
    thread_ = std::move(started.thread);
    notices_ = std::move(started.notices);
  }
  running_ = true;
}

void ThreadedRobot::End() {
  const std::scoped_lock lock(requests_);
  if (!running_) return;
  if (thread_settings_.shared != nullptr) {
    thread_settings_.shared->Stop();
  } else {
    thread_.request_stop();
    thread_.join();
  }
  running_ = false;
}

void ThreadedRobot::SleepUntil(Time deadline) noexcept {
  if (thread_settings_.shared != nullptr) {
    rt::FiberThread::SleepUntil(clock_, deadline);
  } else {
    rt::SleepUntil(clock_, deadline);
  }
}

void ThreadedRobot::DropCommands() noexcept {
  ReceivedCommand dropped;
  while (port_.Receive(dropped)) {
  }
}

template <typename Request>
std::invoke_result_t<Request> ThreadedRobot::Ask(Request request) const {
  const std::scoped_lock lock(requests_);
  if (!running_) return request();
  rt::FunctionCall<Request> call(std::move(request));
  if (!calls_.Execute(call, timeout_)) {
    throw RobotFault(
        fmt::format("the robot's thread does not answer: it has not run for {} s; this machine "
                    "gives it no time (see panda-twin check)",
                    ToSeconds(timeout_)));
  }
  if constexpr (!std::is_void_v<std::invoke_result_t<Request>>) return call.answer();
}

MoveStatus ThreadedRobot::Move(const MotionModes& modes) {
  return Ask([&] {
    const MoveStatus status = robot_.Move(modes);
    if (status != MoveStatus::kMotionStarted) return status;
    motion_end_.reset();
    OnGranted(Granted::kMove);
    return status;
  });
}

void ThreadedRobot::StopMove() {
  Ask([&] {
    robot_.StopMove();
    OnGranted(Granted::kStopMove);
  });
}

RecoveryStatus ThreadedRobot::AutomaticErrorRecovery() {
  return Ask([&] {
    const RecoveryStatus status = robot_.AutomaticErrorRecovery();
    if (status == RecoveryStatus::kSuccess) OnGranted(Granted::kRecovery);
    return status;
  });
}

SetterStatus ThreadedRobot::Configure(const Setting& setting) {
  return Ask([&] {
    const SetterStatus status = robot_.Configure(setting);
    if (status == SetterStatus::kSuccess) OnGranted(Granted::kSetting);
    return status;
  });
}

bool ThreadedRobot::Operate(PanelAction action) {
  return Ask([&] {
    const bool done = robot_.Operate(action);
    if (done) OnGranted(Granted::kPanelAction);
    return done;
  });
}

void ThreadedRobot::StandBy() {
  Ask([&] { robot_.StandBy(); });
}

std::optional<plant::Overlap> ThreadedRobot::Place(int body, const Transform& X_WB) {
  return Ask([&] {
    std::optional<plant::Overlap> overlap = robot_.Place(body, X_WB);
    if (!overlap) OnGranted(Granted::kPlace);
    return overlap;
  });
}

bool ThreadedRobot::BetweenMotions(const std::function<void()>& action) {
  return Ask([&] {
    if (robot_.mode() == RobotMode::kMove || hand_is_busy()) return false;
    motion_end_ = LastEnd();
    if (hand_ticket_ != hand_before_) hand_end_ = OutcomeOf(hand_ticket_);
    hand_before_ = hand_ticket_;
    action();
    return true;
  });
}

HandStart ThreadedRobot::StartHand(const HandCommand& command) {
  return Ask([&] {
    HandStart start = robot_.StartHand(command);
    if (start.ticket == 0) return start;
    hand_offset_ = ++hand_ticket_ - start.ticket;
    start.ticket = hand_ticket_;
    return start;
  });
}

LastMotion ThreadedRobot::LastEnd() const noexcept {
  return motion_end_.value_or(robot_.last_motion());
}

std::optional<HandResult> ThreadedRobot::OutcomeOf(HandTicket ticket) const noexcept {
  if (ticket > hand_before_) return robot_.HandOutcome(ticket - hand_offset_);
  return ticket == hand_before_ ? hand_end_ : HandResult::kAborted;
}

std::optional<HandResult> ThreadedRobot::HandOutcome(HandTicket ticket) const {
  return Ask([&] { return OutcomeOf(ticket); });
}

HandState ThreadedRobot::hand_state() const {
  return Ask([&] { return robot_.hand_state(); });
}

RobotMode ThreadedRobot::mode() const {
  return Ask([&] { return robot_.mode(); });
}

LastMotion ThreadedRobot::last_motion() const {
  return Ask([&] { return LastEnd(); });
}

RobotState ThreadedRobot::state() const {
  return Ask([&] { return robot_.state(); });
}

RobotReport ThreadedRobot::report() const {
  return Ask([&] { return RobotReport{robot_.mode(), LastEnd(), robot_.last_found()}; });
}

}  // namespace twin::robot
