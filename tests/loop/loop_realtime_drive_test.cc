// The wall clock's drive. Nothing here depends on how well this machine keeps time: a motion that
// it disturbed (several commands lost in a row, which INT may rightly answer with an abort) is run
// again.
#include "twin/loop/realtime_drive.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "loop/loop_fixture.h"
#include "support/realtime_guard.h"
#include "twin/rt/sleep.h"

namespace twin::loop {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// Counts what a thread's records say, without keeping them.
class Counter final : public rt::RecordSink {
 public:
  void Put(const rt::CycleRecord& record) noexcept override {
    ++cycles;
    if (record.violated) ++violations;
    longest_loss = std::max(longest_loss, record.lost_in_row);
    last_state = record.state;
  }
  void Put(const rt::TickRecord& record) noexcept override {
    ++ticks;
    if (record.action == rt::TickAction::kWritten) ++written;
  }

  std::uint64_t cycles = 0;
  std::uint64_t violations = 0;
  std::uint32_t longest_loss = 0;
  std::uint64_t ticks = 0;
  std::uint64_t written = 0;
  RobotState last_state;
};

/// A twelfth of joint 7's acceleration: two free-running loops make a jerk of 2 ddq / T of it, and
/// states out of time, which are not answered, several times its own jerk.
test::Swing GentleSwing() {
  test::Swing swing;
  swing.amplitude = 0.05;
  return swing;
}

constexpr const char* kDisturbed = "this machine disturbed every attempt";

class RealtimeDriveTest : public ::testing::Test {
 protected:
  RealtimeDriveTest() { plugins::RegisterMujoco(registry_); }

  RunReport Run(control::Controller& controller, rt::RecordSink* sink = nullptr) {
    const backend::Connection connection = registry_.Find("mujoco")(
        {robot_, backend::RealtimeHost{clock_, {.name = "twin-int", .fifo_priority = 98}}, sink});
    return RunInRealtime(clock_, connection,
                         {.backend = *connection.backend,
                          .controller = controller,
                          .modes = {},
                          .kind = kind_,
                          .tick = tick_,
                          .controller_loop = controller_loop_,
                          .seed = 1,
                          .time_limit = time_limit_,
                          .sink = sink,
                          .progress = progress_,
                          .event = {},
                          .interrupted = interrupted_});
  }

  /// What an undisturbed run of a controller came to; null when this machine disturbed every one.
  /// @param make  a controller for each attempt.
  template <typename Make>
  auto RunUndisturbed(Make make) {
    struct Outcome {
      decltype(make()) controller;
      Counter counter;
      RunReport report;
    };
    constexpr int kAttempts = 10;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      std::unique_ptr<Outcome> outcome(new Outcome{make(), {}, {}});
      outcome->report = Run(outcome->controller, &outcome->counter);
      const bool disturbed =
          outcome->counter.longest_loss > 3 || outcome->report.robot_timings.overruns > 3;
      if (outcome->report.succeeded() || !disturbed) return outcome;
    }
    return std::unique_ptr<Outcome>();
  }

  backend::Registry registry_;
  MonotonicClock clock_;
  robot::RobotConfig robot_ = test::IdealPanda();
  LoopKind kind_ = LoopKind::kAsynchronous;
  TickConfig tick_;
  ControllerLoopConfig controller_loop_;
  Duration time_limit_ = seconds(20);
  const volatile bool* interrupted_ = nullptr;
  std::function<void(Time)> progress_;
};

/// Stands still, and does what a test wants in its update number `at`.
class Nuisance final : public control::Controller {
 public:
  control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  void Activate(const RobotState& state, Time) override {
    if (refuses) throw InputError("this controller does not want to start");
    q_ = state.q_d;
  }
  void Update(const RobotState&, Time, control::ControllerOutput& output) noexcept override {
    output.target.joint.q = q_;
    ++updates;
    if (updates == at) {
      if (stall > Duration::zero()) rt::SleepUntil(clock_, clock_.Now() + stall);
      if (gives_nan) output.target.joint.q[2] = std::nan("");
    }
    output.finished = updates >= last;
  }
  void Deactivate() noexcept override { ++deactivated; }

  bool refuses = false;
  bool gives_nan = false;
  Duration stall{};
  std::uint64_t at = 200;
  std::uint64_t last = 600;
  std::uint64_t updates = 0;
  int deactivated = 0;

 private:
  const MonotonicClock clock_;
  JointVector q_{};
};

TEST_F(RealtimeDriveTest, RunsAMotionToItsEnd) {
  const auto run = RunUndisturbed(&GentleSwing);
  if (run == nullptr) GTEST_SKIP() << kDisturbed;
  const RunReport& report = run->report;
  EXPECT_TRUE(report.succeeded()) << report.failure;
  EXPECT_NEAR(report.q_final[6], robot_.q_start[6], 2e-4);
  EXPECT_EQ(run->controller.deactivated, 1);
  EXPECT_EQ(run->counter.violations, 0u);
  EXPECT_EQ(report.timings.written, report.timings.d_EXT.count());
  EXPECT_GT(report.robot_timings.lateness.count(), 500u);
}

TEST_F(RealtimeDriveTest, RunsTheSynchronousAndTheBareLoop) {
  for (const LoopKind kind : {LoopKind::kSynchronous, LoopKind::kBare}) {
    kind_ = kind;
    tick_.period_tolerance = Duration::zero();
    controller_loop_.phase = microseconds(500);
    const auto run = RunUndisturbed(&GentleSwing);
    if (run == nullptr) GTEST_SKIP() << kDisturbed;
    EXPECT_TRUE(run->report.succeeded()) << run->report.failure;
    EXPECT_EQ(run->controller.deactivated, 1);
  }
}

TEST_F(RealtimeDriveTest, ARobotWhoseClockDriftsIsFollowed) {
  robot_.clock_ppm = 500;
  const auto run = RunUndisturbed(&GentleSwing);
  if (run == nullptr) GTEST_SKIP() << kDisturbed;
  EXPECT_TRUE(run->report.succeeded()) << run->report.failure;
}

TEST_F(RealtimeDriveTest, AControllerThatStallsFor200MillisecondsAbortsNothing) {
  const auto run = RunUndisturbed([] {
    Nuisance nuisance;
    nuisance.stall = milliseconds(200);
    return nuisance;
  });
  if (run == nullptr) GTEST_SKIP() << kDisturbed;
  EXPECT_TRUE(run->report.succeeded()) << run->report.failure;
  EXPECT_GE(run->report.controller_overruns, 150u) << "counted, and no burst to make up for them";
  EXPECT_EQ(run->counter.violations, 0u);
}

TEST_F(RealtimeDriveTest, AnInvalidTargetStopsTheMotionAndLeavesTheLastTicks) {
  Nuisance nuisance;
  nuisance.gives_nan = true;
  Counter counter;
  const RunReport report = Run(nuisance, &counter);
  EXPECT_NE(report.failure.find("no valid command"), std::string::npos) << report.failure;
  EXPECT_EQ(report.end, backend::MotionEnd::kPreempted);
  EXPECT_EQ(counter.violations, 0u) << "it never reached the robot";
  ASSERT_FALSE(report.evidence.empty());
  EXPECT_NE(DescribeTick(report.evidence.front()).find("state "), std::string::npos);
}

TEST_F(RealtimeDriveTest, AControllerThatRefusesToStartEndsAllThreads) {
  Nuisance nuisance;
  nuisance.refuses = true;
  EXPECT_THROW(static_cast<void>(Run(nuisance)), InputError);
}

TEST_F(RealtimeDriveTest, AMotionThatOutlastsItsTimeIsStopped) {
  Nuisance nuisance;
  nuisance.last = 1'000'000'000;
  time_limit_ = milliseconds(400);
  const RunReport report = Run(nuisance);
  EXPECT_NE(report.failure.find("did not end within"), std::string::npos) << report.failure;
  EXPECT_EQ(report.end, backend::MotionEnd::kPreempted);
  EXPECT_EQ(nuisance.deactivated, 1);
}

TEST_F(RealtimeDriveTest, AnInterruptStopsTheArm) {
  Nuisance nuisance;
  nuisance.last = 1'000'000'000;
  const volatile bool interrupted = true;
  interrupted_ = &interrupted;
  EXPECT_FALSE(Run(nuisance).succeeded());
}

TEST_F(RealtimeDriveTest, ALinkThatLosesEveryStateIsReported) {
  robot_.link.state.loss = rt::LossModel(rt::IndependentLoss{1});
  Nuisance nuisance;
  EXPECT_THROW(static_cast<void>(Run(nuisance)), RobotFault);
}

/// Counts on the communication's thread and on the robot's.
class GuardedSink final : public rt::RecordSink {
 public:
  static constexpr int kFirst = 200;
  static constexpr int kTicks = 10000;

  /// Of the calling thread, so far.
  static std::int64_t PageFaults() noexcept {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_minflt + usage.ru_majflt;
  }

  struct Side {
    std::unique_ptr<test::RealtimeGuard> guard;  ///< made on the thread it counts
    int count = 0;
    test::RealtimeGuard::Counts found{-1, -1, -1};
    std::int64_t page_faults = -1;
    std::int64_t page_faults_before = 0;

    void Count() noexcept {
      ++count;
      if (count == kFirst) {
        guard = std::make_unique<test::RealtimeGuard>();
        page_faults_before = PageFaults();
      }
      if (count == kFirst + kTicks) {
        found = guard->counts();
        page_faults = PageFaults() - page_faults_before;
      }
    }
  };

  void Put(const rt::CycleRecord&) noexcept override {
    robot.Count();
    if (robot.count >= kFirst + kTicks + kTicks / 5) done = true;
  }
  void Put(const rt::TickRecord&) noexcept override { communication.Count(); }

  Side robot;
  Side communication;
  std::atomic<bool> done{false};  ///< the run may end
};

TEST_F(RealtimeDriveTest, NoAllocationLockOrPageFaultInTenThousandTicksOfEitherThread) {
  robot_.plant_kind = robot::PlantKind::kMujoco;
  robot_.plant.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
  robot_.plant.hand = plant::HandKind::kNone;
  robot_.onboard.rotor_inertia.fill(0.3);
  test::Swing swing = GentleSwing();
  swing.endless = true;
  time_limit_ = seconds(60);
  // A machine that loses time now and then has ticks to spare, and no reason to abort.
  robot_.onboard.abort_after_lost = 100'000;
  GuardedSink sink;
  volatile bool interrupted = false;
  progress_ = [&](Time) { interrupted = sink.done; };  // on the thread that looks at it
  interrupted_ = &interrupted;
  const RunReport report = Run(swing, &sink);
  EXPECT_EQ(report.end, backend::MotionEnd::kPreempted) << report.failure;
  for (const GuardedSink::Side* side : {&sink.robot, &sink.communication}) {
    ASSERT_GE(side->count, GuardedSink::kFirst + GuardedSink::kTicks);
    EXPECT_EQ(side->found.allocations, 0);
    EXPECT_EQ(side->found.frees, 0);
    EXPECT_EQ(side->found.locks, 0);
    // Where memory may not be locked, the report says so, and pages may go.
    // ThreadSanitizer's own pages come as they are needed.
#ifndef __SANITIZE_THREAD__
    if (report.notices.empty()) {
      EXPECT_EQ(side->page_faults, 0);
    }
#endif
  }
}

}  // namespace
}  // namespace twin::loop
