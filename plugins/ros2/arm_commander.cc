#include "plugins/ros2/arm_commander.h"

#include <chrono>
#include <exception>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/modes.h"

namespace twin::ros2 {
namespace {

/// Between looks for a work, where a connection is kept; a new one shortens it.
constexpr twin::Duration kIdle = std::chrono::milliseconds(100);
constexpr auto kBetweenConnections = std::chrono::seconds(2);

}  // namespace

/// A robot that stopped by an error moves again when a person or a program says so.
void RequireReady(const RobotState& state) {
  if (state.robot_mode == RobotMode::kIdle) return;
  throw RobotFault(fmt::format(
      "the robot is in mode {}, not Idle; after a reflex call the service ~/recover, else release "
      "the stop",
      Name(state.robot_mode)));
}

run::MotionResult MoveByOwnController(run::Session& session, run::Motion motion) {
  motion.controller.type = kController;
  return session.Move(motion);
}

ArmCommander::ArmCommander(Parts parts)
    : parts_(std::move(parts)), controllers_(parts_.catalogue.controllers) {
  controllers_.Add(kController, [this](const control::ControllerRequest& request) {
    return current_->MakeController(request);
  });
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

ArmCommander::~ArmCommander() {
  thread_.request_stop();
  const std::lock_guard lock(mutex_);
  interrupted_ = true;
}

void ArmCommander::Begin(std::shared_ptr<ArmWork> work) {
  std::shared_ptr<ArmWork> dropped;
  {
    const std::lock_guard lock(mutex_);
    dropped = std::exchange(next_, std::move(work));
    interrupted_ = true;
    wake_.notify_one();
  }
  if (dropped) dropped->End("a newer command took its place", true);
}

bool ArmCommander::TryBegin(std::shared_ptr<ArmWork> work) {
  const std::lock_guard lock(mutex_);
  if (next_ || current_) return false;
  next_ = std::move(work);
  interrupted_ = true;
  wake_.notify_one();
  return true;
}

void ArmCommander::GiveUp(const ArmWork& work) {
  std::shared_ptr<ArmWork> dropped;
  {
    const std::lock_guard lock(mutex_);
    if (next_.get() == &work) dropped = std::exchange(next_, nullptr);
    if (current_.get() == &work) interrupted_ = true;
  }
  if (dropped) dropped->End("given up before it began", true);
}

bool ArmCommander::is_busy() const {
  const std::lock_guard lock(mutex_);
  return next_ || current_;
}

void ArmCommander::Run(const std::stop_token& stop) {
  const bool keeps = parts_.states != nullptr;
  while (!stop.stop_requested()) {
    if (!keeps && !TakeNext(stop)) return;
    try {
      Serve(stop);
    } catch (const std::exception& error) {
      if (is_busy()) End(error.what());
      if (!keeps) continue;
      parts_.tell(fmt::format("ROS 2: {}; connecting anew", error.what()));
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, kBetweenConnections, [] { return false; });
    }
  }
}

void ArmCommander::Serve(const std::stop_token& stop) {
  const run::Catalogue catalogue{parts_.catalogue.backends, controllers_};
  run::RunHooks hooks;
  hooks.interrupted = &interrupted_;
  hooks.look = [this] {
    if (current_) current_->Look();
  };
  run::Session session(parts_.client, catalogue, parts_.files, parts_.states, parts_.settings);
  session.Begin(hooks);
  if (parts_.states == nullptr) return Execute(session);
  while (!stop.stop_requested()) {
    if (TakeNext(stop)) Execute(session);
    // Beside motions, a session records no states.
    static_cast<void>(session.Wait(kIdle, [&](const RobotState& state) {
      record::CycleRecord record;
      record.at = session.Now();
      record.state = state;
      parts_.states->Put(record);
      return false;
    }));
  }
}

bool ArmCommander::TakeNext(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (parts_.states == nullptr) {
    static_cast<void>(wake_.wait(lock, stop, [this] { return next_ != nullptr; }));
  }
  interrupted_ = stop.stop_requested();
  if (!next_ || interrupted_) return false;
  current_ = std::exchange(next_, nullptr);
  return true;
}

void ArmCommander::Execute(run::Session& session) {
  try {
    current_->Run(session, parts_.client);
    End("");
  } catch (const Error& error) {
    End(error.what());
  }
}

void ArmCommander::End(const std::string& why) {
  const std::shared_ptr<ArmWork> over = [this] {
    const std::lock_guard lock(mutex_);
    return std::exchange(current_, nullptr);
  }();
  if (over) over->End(why, interrupted_);
}

}  // namespace twin::ros2
