// The robot on the wall clock. Nothing here depends on the machine being fast or quiet: what is
// asserted holds however late the threads run, or is tried again when a witness saw that they did
// not run at all.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "robot/robot_fixture.h"
#include "support/realtime_guard.h"
#include "support/undisturbed.h"
#include "twin/core/error.h"
#include "twin/robot/realtime_robot.h"
#include "twin/rt/fiber_thread.h"
#include "twin/rt/host_time.h"

namespace twin::robot::robot_realtime_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;

constexpr Duration kLong = seconds(60);

/// The ideal plant, with something to do at every step, on the robot's thread.
class HookedPlant final : public plant::Plant {
 public:
  using Hook = std::function<void(int step)>;
  explicit HookedPlant(Hook hook) : hook_(std::move(hook)) {}
  void Reset(const JointVector& q) override { ideal_.Reset(q); }
  std::unique_ptr<const State> Save() const override { return ideal_.Save(); }
  void Restore(const State& state) override { ideal_.Restore(state); }
  void Step(const JointDrive& drive) noexcept override {
    hook_(++steps_);
    ideal_.Step(drive);
  }
  const JointSensors& sensors() const noexcept override { return ideal_.sensors(); }

 private:
  Hook hook_;
  int steps_ = 0;
  plant::IdealPlant ideal_;
};

/// What a cycle's record is kept of.
struct Cycle {
  std::uint64_t id = 0;
  Time at{};
  Time put{};  ///< wall time of the record
  record::CommandFate fate{};
};

/// Keeps the cycles, without allocating.
class Cycles final : public record::RecordSink {
 public:
  explicit Cycles(const MonotonicClock& clock) : clock_(clock) { kept_.reserve(kMost); }
  void Put(const record::CycleRecord& record) noexcept override {
    if (kept_.size() < kMost) {
      kept_.push_back({record.state.message_id, record.at, clock_.Now(), record.fate});
    }
    count_.store(record.state.message_id, std::memory_order_release);
  }
  void Put(const record::TickRecord&) noexcept override {}
  /// While no robot runs.
  void Clear() {
    kept_.clear();
    count_ = 0;
  }
  /// Any thread.
  [[nodiscard]] std::uint64_t count() const { return count_.load(std::memory_order_acquire); }
  /// Once the robot's thread has ended.
  [[nodiscard]] const std::vector<Cycle>& kept() const { return kept_; }

 private:
  static constexpr std::size_t kMost = 20000;
  const MonotonicClock& clock_;
  std::vector<Cycle> kept_;
  std::atomic<std::uint64_t> count_ = 0;
};

class RealtimeRobotTest : public ::testing::Test {
 protected:
  void Make(
      const RobotConfig& config, HookedPlant::Hook hook = [](int) {},
      rt::FiberThread* shared = nullptr) {
    const rt::ThreadSettings thread{.name = "robot", .lock_memory = false, .shared = shared};
    robot_.reset();
    cycles_.Clear();
    robot_ = std::make_unique<RealtimeRobot>(config, std::make_unique<HookedPlant>(std::move(hook)),
                                             clock_, thread, &cycles_);
  }
  void AwaitCycle(std::uint64_t id) {
    while (cycles_.count() < id) rt::SleepUntil(clock_, clock_.Now() + microseconds(200));
  }
  /// The newest state, once there is one. @returns null when none has come for very long.
  const RobotState* AwaitState() {
    const RobotState* state = robot_->Read();
    while (state == nullptr && robot_->arrival().AwaitUntil(clock_.Now() + kLong)) {
      state = robot_->Read();
    }
    return state;
  }

  const MonotonicClock clock_;
  Cycles cycles_{clock_};
  std::unique_ptr<RealtimeRobot> robot_;
};

/// Lateness that leaves the grid where it is.
constexpr Duration kTolerated = microseconds(250);

/// Ids without a gap, instants a period apart but where a cycle was postponed, and no cycle before
/// it was due.
void ExpectSoundGrid(const std::vector<Cycle>& cycles, std::uint64_t overruns) {
  ASSERT_FALSE(cycles.empty());
  std::uint64_t skipped = 0;
  for (std::size_t i = 0; i < cycles.size(); ++i) {
    EXPECT_EQ(cycles[i].id, i + 1);
    EXPECT_GE(cycles[i].put, cycles[i].at);
    if (i == 0) continue;
    const Duration step = cycles[i].at - cycles[i - 1].at;
    EXPECT_TRUE(step == kCycle || step > kCycle + kTolerated) << step.count() << " ns";
    skipped += static_cast<std::uint64_t>(step / kCycle - 1);
  }
  // The first cycle may have been postponed too.
  EXPECT_LE(skipped, overruns);
}

TEST_F(RealtimeRobotTest, RunsItsCyclesOnAnAbsoluteGrid) {
  Make(test::PandaRobot());
  const Time before = clock_.Now();
  robot_->Begin();
  AwaitCycle(100);
  robot_->End();
  ExpectSoundGrid(cycles_.kept(), robot_->overruns());
  EXPECT_GE(cycles_.kept().front().at, before + kCycle);
  EXPECT_EQ(robot_->lateness().count(), cycles_.kept().size());
  EXPECT_TRUE(robot_->notices().empty());
}

TEST_F(RealtimeRobotTest, FollowsAClockThatDrifts) {
  RobotConfig config = test::PandaRobot();
  config.clock_ppm = -1000;  // a cycle every 1.001001... ms
  Make(config);
  robot_->Begin();
  AwaitCycle(100);
  robot_->End();
  const std::vector<Cycle>& cycles = cycles_.kept();
  for (std::size_t i = 1; i < cycles.size(); ++i) {
    const double step = ToSeconds(cycles[i].at - cycles[i - 1].at);
    const bool postponed = step > 1e-3 / 0.999 + ToSeconds(kTolerated);
    EXPECT_TRUE(postponed || std::abs(step - 1e-3 / 0.999) < 2e-9) << "cycle " << cycles[i].id;
  }
}

TEST_F(RealtimeRobotTest, AStalledCycleIsFollowedByTheNextOnTheGridAndNotByABurst) {
  constexpr int kStalled = 20;
  Make(test::PandaRobot(), [this](int step) {
    if (step == kStalled) rt::SleepUntil(clock_, clock_.Now() + milliseconds(5));
  });
  robot_->Begin();
  AwaitCycle(60);
  robot_->End();
  const auto& cycles = cycles_.kept();
  ExpectSoundGrid(cycles, robot_->overruns());
  // It began at its deadline or later and lasted 5 ms; the next deadline was 1 ms later.
  EXPECT_GE(cycles[kStalled].at - cycles[kStalled - 1].at, milliseconds(5));
  EXPECT_GE(robot_->overruns(), 4u);
  EXPECT_GE(robot_->lateness().max(), milliseconds(4));
}

// The others of its thread may begin their cycles up to a period later, after stalls that met them
// alone; its own state would then go out that much later in every cycle.
TEST_F(RealtimeRobotTest, OnASharedThreadItsCyclesFollowThoseItHadToWaitFor) {
  constexpr int kWaited = 20;
  rt::FiberThread thread({.name = "robots", .lock_memory = false}, {});
  const auto wait = [this](int step) {
    const Time until = clock_.Now() + microseconds(600);
    while (step == kWaited && clock_.Now() < until) rt::FiberThread::GiveWay();
  };
  Make(test::PandaRobot(), wait, &thread);
  robot_->Begin();
  static_cast<void>(thread.Start());
  AwaitCycle(40);
  robot_->End();
  const auto& cycles = cycles_.kept();
  ExpectSoundGrid(cycles, robot_->overruns());
  EXPECT_GE(cycles[kWaited].at - cycles[kWaited - 1].at, kCycle + microseconds(600));
}

TEST_F(RealtimeRobotTest, MakesUpForAStallWithinCatchUpAndPostponesTheRestOfALongerOne) {
  constexpr int kShortStall = 20;
  constexpr int kLongStall = 40;
  RobotConfig config = test::PandaRobot();
  config.catch_up = milliseconds(10);
  test::Undisturbed(
      [&] {
        Make(config, [this](int step) {
          if (step == kShortStall) rt::SleepUntil(clock_, clock_.Now() + milliseconds(5));
          if (step == kLongStall) rt::SleepUntil(clock_, clock_.Now() + milliseconds(30));
        });
        robot_->Begin();
        std::set<std::uint64_t> received;
        while (cycles_.count() < 100) received.insert(AwaitState()->message_id);
        robot_->End();
        for (int late = 1; late < 4; ++late) EXPECT_FALSE(received.contains(kShortStall + late));
        const auto& cycles = cycles_.kept();
        ExpectSoundGrid(cycles, robot_->overruns());
        EXPECT_EQ(cycles[kShortStall].at - cycles[kShortStall - 1].at, kCycle);
        const Duration step = cycles[kLongStall].at - cycles[kLongStall - 1].at;
        EXPECT_GE(step, milliseconds(20));
        EXPECT_LT(step, milliseconds(30)) << "10 ms of 30 are made up for";
        EXPECT_GE(robot_->lateness().max(), milliseconds(29));
      },
      [] { return std::int64_t{5}; });
}

TEST_F(RealtimeRobotTest, PostponesAStallWhenAsManyCommandsAreLostAlready) {
  constexpr int kStalled = 200;
  RobotConfig config = test::PandaRobot();
  config.catch_up = milliseconds(10);
  config.onboard.abort_after_lost = 100'000;
  Make(config, [this](int step) {
    if (step == kStalled) rt::SleepUntil(clock_, clock_.Now() + milliseconds(5));
  });
  ASSERT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
  robot_->Begin();
  for (int i = 0; i < 20; ++i) {  // INT waits for the first; none comes after these
    RobotCommand command;
    command.message_id = AwaitState()->message_id;
    command.q_c = test::kReady;
    robot_->Write(command);
  }
  AwaitCycle(kStalled + 40);
  robot_->End();
  const auto& cycles = cycles_.kept();
  ExpectSoundGrid(cycles, robot_->overruns());
  EXPECT_GE(cycles[kStalled].at - cycles[kStalled - 1].at, milliseconds(5));
}

TEST_F(RealtimeRobotTest, ARobotThatNeverKeepsUpCountsWhatItSkipsAndStillAnswers) {
  test::Undisturbed([this] {
    Make(test::PandaRobot(),
         [this](int) { rt::SleepUntil(clock_, clock_.Now() + microseconds(2100)); });
    robot_->Begin();
    AwaitCycle(30);
    EXPECT_EQ(robot_->mode(), RobotMode::kIdle);
    robot_->End();
    ExpectSoundGrid(cycles_.kept(), robot_->overruns());
    EXPECT_GE(robot_->overruns(), 30u);
  });
}

TEST_F(RealtimeRobotTest, AStateArrivesOnlyAfterItsDelay) {
  RobotConfig config = test::PandaRobot();
  config.link.state.delay = faults::DelayModel(faults::ConstantDelay{microseconds(2300)});
  Make(config);
  std::vector<std::pair<std::uint64_t, Time>> arrivals;
  robot_->Begin();
  while (arrivals.size() < 50) {
    const RobotState* state = AwaitState();
    ASSERT_NE(state, nullptr);
    arrivals.emplace_back(state->message_id, clock_.Now());
  }
  robot_->End();
  std::uint64_t last = 0;
  for (const auto& [id, arrival] : arrivals) {
    EXPECT_GT(id, last);
    last = id;
    EXPECT_GE(arrival, cycles_.kept().at(id - 1).at + microseconds(2300)) << "state " << id;
  }
}

/// When a command was written: between these two instants.
using WriteTime = std::pair<Time, Time>;

/// @param writes  by id of the answered state.
/// @param way     from the write to INT's look at it.
/// @returns how many cycles were served.
int CountServed(const std::vector<Cycle>& cycles, const std::vector<WriteTime>& writes,
                Duration way) {
  int served = 0;
  bool running = false;
  for (const Cycle& cycle : cycles) {
    const bool in_motion = cycle.fate != record::CommandFate::kNone;
    if (running && !in_motion) break;  // ended, by too many losses in a row
    running = in_motion;
    const auto& [earliest, latest] = writes.at(cycle.id - 1);
    if (cycle.fate == record::CommandFate::kServed) {
      ++served;
      EXPECT_LE(earliest, cycle.at - way) << "cycle " << cycle.id << " took a late command";
    } else if (running) {
      EXPECT_GT(latest, cycle.at - way) << "cycle " << cycle.id << " lost a command";
    }
  }
  return served;
}

TEST_F(RealtimeRobotTest, ServesExactlyTheCyclesWhoseCommandArrivedInTime) {
  RobotConfig config = test::PandaRobot();
  const Duration delay = microseconds(120);
  config.link.command.delay = faults::DelayModel(faults::ConstantDelay{delay});
  config.link.d_INT = microseconds(150);
  Make(config);
  ASSERT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
  robot_->Begin();
  std::vector<WriteTime> writes(2000, {Time::max(), Time::max()});
  std::uint64_t id = 0;
  while (id < 400) {
    const RobotState* state = AwaitState();
    ASSERT_NE(state, nullptr);
    id = state->message_id;
    RobotCommand command;
    command.message_id = id;
    command.q_c = test::kReady;
    if (id % 3 == 0) rt::SleepUntil(clock_, clock_.Now() + microseconds(id));  // some too late
    const Time before = clock_.Now();
    robot_->Write(command);
    if (id < writes.size()) writes[id] = {before, clock_.Now()};
  }
  robot_->End();
  EXPECT_GT(CountServed(cycles_.kept(), writes, delay + config.link.d_INT), 0);
}

TEST_F(RealtimeRobotTest, AnswersRequestsBeforeDuringAndAfterItsTime) {
  RobotConfig config = test::PandaRobot();
  config.onboard.abort_after_lost = 100'000;  // there are no commands, and no haste
  test::Undisturbed([&] {
    Make(config);
    JointVector impedance;
    impedance.fill(500);
    EXPECT_EQ(robot_->Configure(setting::JointImpedance{impedance}), SetterStatus::kSuccess);
    EXPECT_EQ(robot_->mode(), RobotMode::kIdle);
    robot_->Begin();
    impedance.fill(-1);
    EXPECT_EQ(robot_->Configure(setting::JointImpedance{impedance}),
              SetterStatus::kInvalidArgumentRejected);
    EXPECT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
    EXPECT_EQ(robot_->Move({}), MoveStatus::kCommandNotPossibleRejected);
    AwaitCycle(cycles_.count() + 2);
    EXPECT_EQ(robot_->mode(), RobotMode::kMove);
    robot_->StopMove();
    while (robot_->last_motion().end == MoveStatus::kMotionStarted) {
    }
    EXPECT_EQ(robot_->last_motion().end, MoveStatus::kPreempted);
    EXPECT_TRUE(robot_->last_motion().violations.empty());
    robot_->End();
    EXPECT_EQ(robot_->mode(), RobotMode::kIdle);
    EXPECT_EQ(robot_->AutomaticErrorRecovery(), RecoveryStatus::kSuccess);
  });
}

TEST_F(RealtimeRobotTest, TwoThreadsMayAskAtOnce) {
  test::Undisturbed([this] {
    Make(test::PandaRobot());
    robot_->Begin();
    std::exception_ptr failure;
    std::jthread other([&] {
      try {
        for (int i = 0; i < 30; ++i) robot_->StopMove();
      } catch (...) {
        failure = std::current_exception();
      }
    });
    for (int i = 0; i < 30; ++i) EXPECT_EQ(robot_->mode(), RobotMode::kIdle);
    other.join();
    if (failure) std::rethrow_exception(failure);
  });
}

/// Holds the robot's thread in its first step until it is let go.
class Gate {
 public:
  HookedPlant::Hook Hook(const MonotonicClock& clock) {
    return [this, &clock](int step) {
      if (step > 1) return;
      held_ = true;
      while (!open_) rt::SleepUntil(clock, clock.Now() + milliseconds(1));
    };
  }
  void AwaitHeld() const {
    while (!held_) std::this_thread::yield();
  }
  void Open() { open_ = true; }

 private:
  std::atomic<bool> held_ = false;
  std::atomic<bool> open_ = false;
};

TEST_F(RealtimeRobotTest, ARequestThatIsNotAnsweredIsAFaultAndNeverDone) {
  test::Undisturbed([this] {
    Gate gate;
    Make(test::PandaRobot(), gate.Hook(clock_));
    robot_->Begin();
    gate.AwaitHeld();
    std::string answer;
    try {
      static_cast<void>(robot_->Move({}));
    } catch (const RobotFault& fault) {
      answer = fault.what();
    }
    gate.Open();
    EXPECT_THAT(answer, HasSubstr("the robot's thread does not answer"));
    AwaitCycle(5);
    EXPECT_EQ(robot_->mode(), RobotMode::kIdle);
  });
}

TEST_F(RealtimeRobotTest, CommandsBeyondTheRingAreLostAndCounted) {
  Gate gate;
  Make(test::PandaRobot(), gate.Hook(clock_));
  robot_->Begin();
  gate.AwaitHeld();
  for (int i = 0; i < 64; ++i) robot_->Write({});
  EXPECT_EQ(robot_->commands_lost(), 0u);
  for (int i = 0; i < 3; ++i) robot_->Write({});
  EXPECT_EQ(robot_->commands_lost(), 3u);
  gate.Open();
  AwaitCycle(5);
  robot_->Write({});
  EXPECT_EQ(robot_->commands_lost(), 3u);
}

TEST_F(RealtimeRobotTest, ACommandWrittenBeforeTheBeginIsLost) {
  RobotConfig config = test::PandaRobot();
  config.link.command.delay = faults::DelayModel();
  Make(config);
  ASSERT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
  for (std::uint64_t id = 0; id < 20; ++id) {
    RobotCommand command;
    command.message_id = id;
    command.q_c = test::kReady;
    robot_->Write(command);
  }
  robot_->Begin();
  AwaitCycle(20);
  robot_->End();
  for (const Cycle& cycle : cycles_.kept()) EXPECT_EQ(cycle.fate, record::CommandFate::kNone);
}

TEST_F(RealtimeRobotTest, NothingHappensAfterItsEnd) {
  Make(test::PandaRobot());
  robot_->Begin();
  AwaitCycle(5);
  robot_->End();
  const std::uint64_t cycles = cycles_.count();
  static_cast<void>(robot_->Read());
  rt::SleepUntil(clock_, clock_.Now() + milliseconds(5));
  robot_->End();
  EXPECT_EQ(cycles_.count(), cycles);
  EXPECT_EQ(robot_->Read(), nullptr);
}

TEST_F(RealtimeRobotTest, MayBeDroppedAtAnyStage) {
  Make(test::PandaRobot());
  robot_.reset();
  Make(test::PandaRobot());
  robot_->Begin();
  robot_.reset();
}

TEST_F(RealtimeRobotTest, ABeginOnAProcessorThatDoesNotExistIsRefused) {
  rt::ThreadSettings thread;
  thread.lock_memory = false;
  thread.cpu = -1;
  RealtimeRobot robot(test::PandaRobot(), std::make_unique<plant::IdealPlant>(), clock_, thread,
                      nullptr);
  EXPECT_THROW(robot.Begin(), InputError);
}

TEST_F(RealtimeRobotTest, ItsThreadAllocatesAndLocksNothing) {
  std::optional<test::RealtimeGuard> guard;
  test::RealtimeGuard::Counts counts;
  const auto answer_five_hundred_cycles = [&] {
    for (int i = 0; i < 600 && cycles_.count() < 500; ++i) {
      const RobotState* state = AwaitState();
      ASSERT_NE(state, nullptr);
      RobotCommand command;
      command.message_id = state->message_id;
      command.q_c = test::kReady;
      robot_->Write(command);
      if (i % 50 == 0) static_cast<void>(robot_->last_motion());
    }
    AwaitCycle(500);
  };
  test::Undisturbed([&] {
    Make(test::PandaRobot(), [&](int step) {  // on the robot's thread
      if (step == 2) guard.emplace();
      if (step == 500) counts = guard->counts();
    });
    ASSERT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
    robot_->Begin();
    answer_five_hundred_cycles();
    robot_->End();
    EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  });
  robot_->End();  // where an attempt was broken off, before what its plant refers to goes
}

TEST_F(RealtimeRobotTest, TwoOnOneThreadTakeEachStepTogether) {
  constexpr int kSteps = 300;
  test::Undisturbed([&] {
    int steps = 0;
    std::optional<test::RealtimeGuard> guard;
    test::RealtimeGuard::Counts counts;
    // As the arms of a model do: the step is taken once both are here.
    const auto meets = [&](int step) {
      ++steps;
      while (steps < 2 * step) rt::FiberThread::GiveWay();
      if (step == 2 && !guard) guard.emplace();
      if (step == kSteps) counts = guard->counts();
    };
    rt::FiberThread thread({.name = "robots", .lock_memory = false},
                           [&steps] { steps = std::numeric_limits<int>::max() / 2; });
    const rt::ThreadSettings shared{.shared = &thread};
    Cycles others(clock_);
    cycles_.Clear();
    RealtimeRobot one(test::PandaRobot(), std::make_unique<HookedPlant>(meets), clock_, shared,
                      &cycles_);
    RealtimeRobot other(test::PandaRobot(), std::make_unique<HookedPlant>(meets), clock_, shared,
                        &others);
    one.Begin();
    other.Begin();
    static_cast<void>(thread.Start());
    ASSERT_EQ(one.Move({}), MoveStatus::kMotionStarted);
    AwaitCycle(kSteps + 2);
    EXPECT_EQ(other.mode(), RobotMode::kIdle);
    one.End();  // and with it the other
    const std::uint64_t last = others.count();
    other.End();
    EXPECT_EQ(others.count(), last);
    EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
    ExpectSoundGrid(cycles_.kept(), one.overruns());
    ExpectSoundGrid(others.kept(), other.overruns());
    // A cycle is postponed by no more than it was late, and the other's step waits for it.
    const Duration apart = kCycle + std::max(one.lateness().max(), other.lateness().max());
    const std::size_t both = std::min(cycles_.kept().size(), others.kept().size());
    for (std::size_t i = 0; i < both; ++i) {
      EXPECT_LT(std::chrono::abs(cycles_.kept()[i].at - others.kept()[i].at), apart);
    }
  });
}

TEST_F(RealtimeRobotTest, ReadsAndWritesAllocateAndLockNothing) {
  Make(test::PandaRobot());
  robot_->Begin();
  const test::RealtimeGuard guard;
  int states = 0;
  while (states < 300) {
    const RobotState* state = AwaitState();
    if (state == nullptr) break;
    ++states;
    RobotCommand command;
    command.message_id = state->message_id;
    robot_->Write(command);
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_EQ(states, 300);
}

}  // namespace
}  // namespace twin::robot::robot_realtime_test
