// The paper's baselines: the synchronous loop (RS) and the bare loop (LF).
#include "twin/loop/inline_loops.h"

#include <chrono>
#include <numeric>

#include <gtest/gtest.h>

#include "loop/loop_fixture.h"

namespace twin::loop::loop_inline_loops_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using test::Keeper;

faults::DelayModel Constant(Duration value) {
  return faults::DelayModel(faults::ConstantDelay{value});
}

/// One whole beat of a workstation's timer against a robot 54.6 ppm faster.
constexpr Duration kBeat = milliseconds(18320);

test::LockstepMotion Synchronous(Duration wake, Duration cost, Duration phase) {
  test::LockstepMotion motion;
  motion.kind = LoopKind::kSynchronous;
  motion.robot.link.state.delay = Constant(microseconds(60));
  motion.robot.link.command.delay = Constant(microseconds(60));
  motion.controller_loop.clock_ppm = -54.6;
  motion.controller_loop.phase = phase;
  motion.controller_loop.wake_delay = Constant(wake);
  motion.controller_loop.cost = Constant(cost);
  motion.time_limit = kBeat;
  return motion;
}

struct Losses {
  double share = 0;
  std::uint32_t longest = 0;
};

Losses LossesOf(const Keeper& keeper) {
  Losses losses;
  for (const record::CycleRecord& cycle : keeper.cycles) {
    losses.longest = std::max(losses.longest, cycle.lost_in_row);
  }
  const double served = static_cast<double>(keeper.Count(record::CommandFate::kServed));
  const double held = static_cast<double>(keeper.Count(record::CommandFate::kHeld));
  losses.share = held / (served + held);
  return losses;
}

/// Stands still and never ends: what is counted is the loop's, not the motion's.
class Stand final : public control::Controller {
 public:
  control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  void Activate(const RobotState& state, Time) override { q_ = state.q_d; }
  void Update(const RobotState&, Time now, control::ControllerOutput& output) noexcept override {
    output.target.joint.q = q_;
    updates.push_back(now);
  }
  void Deactivate() noexcept override {}

  std::vector<Time> updates;

 private:
  JointVector q_{};
};

TEST(SynchronousLoopTest, OverAWholeBeatTheBandOfBadPhasesGoesHalfUnserved) {
  // A cycle whose state comes later than T - cost after the wake-up overruns, one whose state comes
  // within the wake-up's delay waits for the next: a band of (cost + delay)/T of all phases, in
  // which every second cycle goes unserved, whatever the phase at the start.
  constexpr Duration kWake = microseconds(25);
  constexpr Duration kCost = microseconds(90);
  const double expected = ToSeconds(kWake + kCost) / ToSeconds(kCycle) / 2;
  for (const int phase_us : {0, 200, 400, 600, 800}) {
    Stand stand;
    Keeper keeper;
    static_cast<void>(Synchronous(kWake, kCost, microseconds(phase_us)).Run(stand, 1, &keeper));
    const Losses losses = LossesOf(keeper);
    EXPECT_NEAR(losses.share, expected, 0.1 * expected) << "phase " << phase_us << " us";
    EXPECT_LE(losses.longest, 5u);
  }
}

TEST(SynchronousLoopTest, WithoutDriftThePhaseAloneDecides) {
  Stand stand;
  Keeper good, bad;
  auto motion = Synchronous(microseconds(25), microseconds(90), microseconds(500));
  motion.controller_loop.clock_ppm = 0;
  motion.time_limit = milliseconds(2000);
  static_cast<void>(motion.Run(stand, 1, &good));
  EXPECT_EQ(LossesOf(good).share, 0);
  // The state arrives 970 us after the wake-up: 90 us of work do not fit in what is left.
  motion.controller_loop.phase = microseconds(65);
  static_cast<void>(motion.Run(stand, 1, &bad));
  EXPECT_NEAR(LossesOf(bad).share, 0.5, 0.01);
}

TEST(SynchronousLoopTest, SkipsToItsGridAfterAnOverrun) {
  Stand stand;
  Keeper keeper;
  auto motion = Synchronous(Duration::zero(), microseconds(2500), microseconds(500));
  motion.controller_loop.clock_ppm = 0;
  motion.time_limit = milliseconds(400);
  motion.robot.onboard.abort_after_lost = 1000;
  static_cast<void>(motion.Run(stand, 1, &keeper));
  ASSERT_GT(stand.updates.size(), 10u);
  for (std::size_t i = 1; i < stand.updates.size(); ++i) {
    EXPECT_EQ(stand.updates[i] - stand.updates[i - 1], milliseconds(4))
        << "2.5 ms of work begun 0.56 ms after the wake-up: the fourth instant is next, no burst";
  }
}

TEST(BareLoopTest, ServesEveryCycleAndSamplesWithTheRobotsTime) {
  test::LockstepMotion motion;
  motion.kind = LoopKind::kBare;
  motion.tick.generator = Generator::kNone;
  motion.tick.cost = Constant(microseconds(12));
  test::Swing swing;
  Keeper keeper;
  const RunReport report = motion.Run(swing, 1, &keeper);
  EXPECT_TRUE(report.succeeded()) << report.failure;
  EXPECT_EQ(keeper.Count(record::CommandFate::kHeld), 0u);
}

TEST(BareLoopTest, ACostAboveTheCycleAnswersTheNewestStateQueued) {
  test::LockstepMotion motion;
  motion.kind = LoopKind::kBare;
  motion.controller_loop.cost = Constant(microseconds(1500));
  motion.robot.onboard.abort_after_lost = 1000;
  motion.time_limit = milliseconds(300);
  Stand stand;
  static_cast<void>(motion.Run(stand));
  ASSERT_GT(stand.updates.size(), 50u);
  for (std::size_t i = 1; i < stand.updates.size(); ++i) {
    const Duration step = stand.updates[i] - stand.updates[i - 1];
    EXPECT_TRUE(step == milliseconds(1) || step == milliseconds(2)) << "no wait for a fresh one";
  }
}

TEST(InlineLoopsTest, RepeatToTheBitWithTheSeed) {
  for (const LoopKind kind : {LoopKind::kSynchronous, LoopKind::kBare}) {
    test::LockstepMotion motion;
    motion.kind = kind;
    motion.controller_loop.phase = microseconds(400);
    motion.controller_loop.cost =
        faults::DelayModel(faults::LogNormalDelay{microseconds(50), 0.4, {}});
    test::Swing swing;
    Keeper first, second;
    static_cast<void>(motion.Run(swing, 7, &first));
    static_cast<void>(motion.Run(swing, 7, &second));
    ASSERT_EQ(first.cycles.size(), second.cycles.size());
    for (std::size_t i = 0; i < first.cycles.size(); ++i) {
      ASSERT_EQ(first.cycles[i].state.q_d, second.cycles[i].state.q_d);
    }
  }
}

TEST(InlineLoopsTest, TheAsynchronousLoopServesWhatTheSynchronousOneMisses) {
  Stand stand;
  Keeper synchronous, asynchronous;
  auto motion = Synchronous(microseconds(25), microseconds(90), microseconds(300));
  static_cast<void>(motion.Run(stand, 1, &synchronous));
  motion.kind = LoopKind::kAsynchronous;
  motion.tick.cost = Constant(microseconds(13));
  motion.tick.period_tolerance = microseconds(250);
  static_cast<void>(motion.Run(stand, 1, &asynchronous));
  EXPECT_GT(LossesOf(synchronous).share, 0.03);
  EXPECT_EQ(LossesOf(asynchronous).share, 0);
}

}  // namespace
}  // namespace twin::loop::loop_inline_loops_test
