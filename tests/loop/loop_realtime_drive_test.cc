// The wall clock's drive. Nothing here depends on how well this machine keeps time: a run that
// failed is run again when a witness saw the machine late by several cycles in a row, which INT may
// rightly answer with an abort.
#include "twin/loop/drive.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "loop/loop_fixture.h"
#include "support/effort.h"
#include "support/realtime_guard.h"
#include "support/undisturbed.h"
#include "twin/rt/host_time.h"

namespace twin::loop::loop_realtime_drive_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// Counts what a thread's records say, without keeping them.
class Counter final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override {
    ++cycles;
    if (record.violated) ++violations;
  }
  void Put(const record::TickRecord&) noexcept override {}

  std::uint64_t cycles = 0;
  std::uint64_t violations = 0;
};

/// Cycles in a row that a motion does not bear without a trace.
constexpr std::int64_t kNotBorne = 4;
/// By the priority of the robot's thread; the communication's has more.
const test::WatchHost kWitness = test::ByWitness(98);

/// A twelfth of joint 7's acceleration: two free-running loops make a jerk of 2 ddq / T of it, and
/// states out of time, which are not answered, several times its own jerk.
test::Swing GentleSwing() {
  test::Swing swing;
  swing.amplitude = 0.05;
  return swing;
}

class RealtimeDriveTest : public ::testing::Test {
 protected:
  RealtimeDriveTest() { plugins::RegisterMujoco(registry_); }

  RunReport Run(control::Controller& controller, record::RecordSink* sink = nullptr) {
    const auto drive = MakeRealtimeDrive(registry_.Find("mujoco"), robot_, sink, {});
    drive->Begin();
    RunReport report = drive->Run({.backend = *drive->connection().backend,
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
    report.robot_timings = drive->End();
    return report;
  }

  /// A run of a controller, and what is claimed of it.
  /// @param make  a controller for each attempt.
  template <typename Make, typename Claims>
  void RunUndisturbed(Make make, Claims claims) {
    std::optional<Counter> counter;
    RunReport report;
    test::Undisturbed(
        [&] {
          auto controller = make();
          report = {};
          report = Run(controller, &counter.emplace());
          claims(report, controller, *counter);
        },
        [] { return kNotBorne; }, kWitness);
  }

  backend::Registry registry_;
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

/// What every motion that ends as it should has in common.
void ExpectSuccess(const RunReport& report, const test::Swing& swing, const Counter& counter) {
  EXPECT_TRUE(report.succeeded()) << report.failure;
  EXPECT_EQ(swing.deactivated, 1);
  EXPECT_EQ(counter.violations, 0u);
}

TEST_F(RealtimeDriveTest, RunsAMotionToItsEnd) {
  RunUndisturbed(&GentleSwing,
                 [this](const RunReport& report, const test::Swing& swing, const Counter& counter) {
                   ExpectSuccess(report, swing, counter);
                   EXPECT_NEAR(report.q_final[6], robot_.q_start[6], 2e-4);
                   EXPECT_EQ(report.timings.written, report.timings.d_EXT.count());
                   EXPECT_GT(report.robot_timings.lateness.count(), 500u);
                 });
}

TEST_F(RealtimeDriveTest, AMotionStopsBeforeALimitOfTheLab) {
  tick_.limits = test::PandaLimits();
  tick_.lab.emplace().dq_max.emplace().fill(0.05);
  RunUndisturbed(&GentleSwing,
                 [](const RunReport& report, const test::Swing&, const Counter& counter) {
                   ASSERT_TRUE(report.limit) << report.failure;
                   EXPECT_EQ(report.limit->axis, 6);
                   EXPECT_EQ(report.end, backend::MotionEnd::kPreempted) << report.failure;
                   EXPECT_EQ(counter.violations, 0U);
                 });
}

TEST_F(RealtimeDriveTest, RunsTheSynchronousLoop) {
  kind_ = LoopKind::kSynchronous;
  controller_loop_.phase = microseconds(500);
  RunUndisturbed(&GentleSwing, &ExpectSuccess);
}

TEST_F(RealtimeDriveTest, RunsTheBareLoop) {
  kind_ = LoopKind::kBare;
  RunUndisturbed(&GentleSwing, &ExpectSuccess);
}

TEST_F(RealtimeDriveTest, ARobotWhoseClockDriftsIsFollowed) {
  robot_.clock_ppm = 500;
  RunUndisturbed(&GentleSwing, &ExpectSuccess);
}

TEST_F(RealtimeDriveTest, AControllerThatStallsFor200MillisecondsAbortsNothing) {
  const auto stalling = [] {
    Nuisance nuisance;
    nuisance.stall = milliseconds(200);
    return nuisance;
  };
  RunUndisturbed(stalling, [](const RunReport& report, const Nuisance&, const Counter& counter) {
    EXPECT_TRUE(report.succeeded()) << report.failure;
    EXPECT_GE(report.controller_overruns, 150u) << "counted, and no burst to make up for them";
    EXPECT_EQ(counter.violations, 0u);
  });
}

TEST_F(RealtimeDriveTest, AnInvalidTargetStopsTheMotionAndLeavesTheLastTicks) {
  const auto invalid = [] {
    Nuisance nuisance;
    nuisance.gives_nan = true;
    return nuisance;
  };
  RunUndisturbed(invalid, [](const RunReport& report, const Nuisance&, const Counter& counter) {
    EXPECT_NE(report.failure.find("no valid command"), std::string::npos) << report.failure;
    EXPECT_EQ(report.end, backend::MotionEnd::kPreempted);
    EXPECT_EQ(counter.violations, 0u) << "it never reached the robot";
    ASSERT_FALSE(report.evidence.empty());
    EXPECT_NE(DescribeTick(report.evidence.front()).find("state "), std::string::npos);
  });
}

TEST_F(RealtimeDriveTest, AControllerThatRefusesToStartEndsAllThreads) {
  std::optional<Counter> counter;
  test::Undisturbed(
      [&] {
        Nuisance nuisance;
        nuisance.refuses = true;
        EXPECT_THROW(static_cast<void>(Run(nuisance, &counter.emplace())), InputError);
      },
      [] { return kNotBorne; }, kWitness);
}

Nuisance Endless() {
  Nuisance nuisance;
  nuisance.last = 1'000'000'000;
  return nuisance;
}

TEST_F(RealtimeDriveTest, AMotionThatOutlastsItsTimeIsStopped) {
  time_limit_ = milliseconds(400);
  RunUndisturbed(&Endless, [](const RunReport& report, const Nuisance& nuisance, const Counter&) {
    EXPECT_NE(report.failure.find("did not end within"), std::string::npos) << report.failure;
    EXPECT_EQ(report.end, backend::MotionEnd::kPreempted);
    EXPECT_EQ(nuisance.deactivated, 1);
  });
}

TEST_F(RealtimeDriveTest, AnInterruptStopsTheArm) {
  const volatile bool interrupted = true;
  interrupted_ = &interrupted;
  RunUndisturbed(&Endless, [](const RunReport& report, const Nuisance&, const Counter&) {
    EXPECT_FALSE(report.succeeded());
  });
}

TEST_F(RealtimeDriveTest, ALinkThatLosesEveryStateIsReported) {
  robot_.link.state.loss = faults::LossModel(faults::IndependentLoss{1});
  Nuisance nuisance;
  EXPECT_THROW(static_cast<void>(Run(nuisance)), RobotFault);
}

/// Of each side.
constexpr int kGuardedTicks = test::Repetitions(10'000);

/// Counts on the communication's thread and on the robot's.
class GuardedSink final : public record::RecordSink {
 public:
  /// Counted is what happens behind the first ticks.
  static constexpr int kFirst = 200;

  /// Of the calling thread, so far.
  static std::int64_t PageFaults() noexcept {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_minflt + usage.ru_majflt;
  }

  struct Side {
    std::unique_ptr<test::RealtimeGuard> guard;  ///< made on the thread it counts
    int count = 0;
    test::RealtimeGuard::Counts found;
    std::int64_t page_faults = 0;
    std::int64_t page_faults_before = 0;

    /// @returns true at the last tick that counts.
    bool Count() noexcept {
      ++count;
      if (count == kFirst) {
        guard = std::make_unique<test::RealtimeGuard>();
        page_faults_before = PageFaults();
      }
      if (count > kFirst && count <= kFirst + kGuardedTicks) {
        found = guard->counts();
        page_faults = PageFaults() - page_faults_before;
      }
      return count == kFirst + kGuardedTicks;
    }
  };

  void Put(const record::CycleRecord& record) noexcept override {
    counter.Put(record);
    if (robot.Count()) ++sides_done;
  }
  void Put(const record::TickRecord&) noexcept override {
    if (communication.Count()) ++sides_done;
  }

  Counter counter;
  Side robot;
  Side communication;
  std::atomic<int> sides_done{0};
};

TEST_F(RealtimeDriveTest, NoAllocationLockOrPageFaultInThousandsOfTicksOfEitherThread) {
  robot_.plant_kind = robot::PlantKind::kMujoco;
  robot_.plant.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
  robot_.plant.hand = plant::HandKind::kNone;
  robot_.onboard.rotor_inertia.fill(0.3);
  test::Swing swing = GentleSwing();
  swing.endless = true;
  time_limit_ = seconds(40);
  // A machine that loses time now and then has ticks to spare, and no reason to abort.
  robot_.onboard.abort_after_lost = 100'000;
  GuardedSink sink;
  volatile bool interrupted = false;
  progress_ = [&](Time) { interrupted = sink.sides_done == 2; };  // on the thread that looks at it
  interrupted_ = &interrupted;
  std::vector<std::string> notices;
  // Its guards count once.
  constexpr int kAttempts = 1;
  test::Undisturbed(
      [&] {
        const RunReport report = Run(swing, &sink);
        notices = report.notices;
        EXPECT_EQ(report.end, backend::MotionEnd::kPreempted) << report.failure;
        EXPECT_EQ(sink.sides_done, 2) << report.failure;
      },
      [] { return kNotBorne; }, kWitness, kAttempts);
  for (const GuardedSink::Side* side : {&sink.robot, &sink.communication}) {
    EXPECT_EQ(side->found, test::RealtimeGuard::Counts{});
    // Where memory may not be locked, the report says so, and pages may go.
    // ThreadSanitizer's own pages come as they are needed.
#ifndef __SANITIZE_THREAD__
    if (notices.empty()) {
      EXPECT_EQ(side->page_faults, 0);
    }
#endif
  }
}

}  // namespace
}  // namespace twin::loop::loop_realtime_drive_test
