#include "twin/teleop/teleoperator.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"
#include "teleop/teleop_fixture.h"
#include "twin/core/error.h"
#include "twin/core/random.h"

namespace twin::teleop::teleop_teleoperator_test {
namespace {

using std::chrono::milliseconds;
using test::Rig;

WireConfig BadWire() {
  WireConfig wire;
  for (faults::DirectionConfig* direction : {&wire.to_robot, &wire.from_robot}) {
    direction->delay = faults::DelayModel(faults::ConstantDelay{milliseconds(300)});
    direction->loss = faults::LossModel(faults::IndependentLoss{0.1});
  }
  return wire;
}

TEST(TeleoperatorTest, RestsWhereItBeginsUntilSomebodyLeads) {
  Rig rig;
  rig.device.silent = true;
  rig.Run(500);
  EXPECT_EQ(rig.target.O_T_EE, rig.start);
}

TEST(TeleoperatorTest, LeadsTheArmByTheStick) {
  Rig rig;
  rig.Run(10);
  rig.device.now.axes[2] = 0.5;
  rig.Run(1000);
  EXPECT_GT(rig.target.O_T_EE[14] - rig.start[14], 0.05);
}

TEST(TeleoperatorTest, DoesNotDriveTheBaseWhileTheArmIsLed) {
  Rig rig;
  rig.device.now.axes[0] = 0.5;
  rig.Run(500);
  EXPECT_EQ(rig.base.drives, 0);
}

TEST(TeleoperatorTest, DrivesTheBaseAndLeavesTheArmWhereItIs) {
  Rig rig;
  rig.Run(10);
  ++rig.device.now.mode_presses;
  rig.Run(10);
  rig.device.now.axes[0] = 1;
  rig.Run(3000);
  EXPECT_NEAR(rig.base.state.twist.v, TeleoperatorConfig().ahead.speed, 1e-3);
  EXPECT_EQ(rig.target.O_T_EE, rig.start);
}

TEST(TeleoperatorTest, ComesToRestWhenSamplesStayAway) {
  Rig rig;
  rig.Run(10);
  rig.device.now.axes[2] = 0.5;
  rig.Run(600);
  rig.device.silent = true;
  rig.Run(200);
  EXPECT_GT(rig.Speed(), 0.05);  // not yet
  rig.Run(800);
  EXPECT_EQ(rig.Speed(), 0);
}

TEST(TeleoperatorTest, HoldsAtOnceWhenTheDeviceIsLost) {
  Rig rig;
  rig.Run(10);
  rig.device.now.axes[2] = 0.5;
  rig.Run(600);
  rig.device.is_lost = true;
  rig.Run(700);
  EXPECT_EQ(rig.Speed(), 0);
  EXPECT_TRUE(rig.teleoperator.TakeStatus().holding);
}

TEST(TeleoperatorTest, DoesNotGoOnByItselfWhenSamplesComeBack) {
  Rig rig;
  rig.Run(10);
  rig.device.now.axes[2] = 0.5;
  rig.Run(600);
  rig.device.silent = true;
  rig.Run(1000);
  rig.device.silent = false;
  rig.Run(500);
  EXPECT_EQ(rig.Speed(), 0);
}

TEST(TeleoperatorTest, TellsTheOperatorThatItHolds) {
  Rig rig;
  rig.Run(10);
  EXPECT_FALSE(rig.device.felt.holding);
  rig.device.silent = true;
  rig.Run(300);
  EXPECT_TRUE(rig.device.felt.holding);
}

TEST(TeleoperatorTest, IsStoppedByTheFirstSample) {
  Rig rig;
  ++rig.device.now.stop_presses;
  rig.Run(10);
  EXPECT_EQ(rig.base.stops, 1);
}

TEST(TeleoperatorTest, StopsTheBaseOnceAndReleasesItOnce) {
  Rig rig;
  rig.Run(10);
  ++rig.device.now.stop_presses;
  rig.Run(100);
  EXPECT_EQ(rig.base.stops, 1);
  ++rig.device.now.release_presses;
  rig.Run(100);
  EXPECT_EQ(rig.base.releases, 1);
}

TEST(TeleoperatorTest, IsFinishedOnlyWhenAllRests) {
  Rig rig;
  rig.Run(10);
  rig.device.now.axes[2] = 1;
  rig.Run(600);
  ++rig.device.now.end_presses;
  rig.Run(2);
  EXPECT_FALSE(rig.teleoperator.finished());
  rig.Run(1500);
  EXPECT_TRUE(rig.teleoperator.finished());
  EXPECT_EQ(rig.Speed(), 0);
}

TEST(TeleoperatorTest, CountsTheHandsPressesForWhoAttends) {
  Rig rig;
  rig.Run(10);
  ++rig.device.now.gripper_presses;
  rig.Run(10);
  EXPECT_EQ(rig.teleoperator.gripper_presses(), 1U);
}

TEST(TeleoperatorTest, TellsWhichSampleHasArrived) {
  Rig rig({}, BadWire());
  rig.Run(1000);
  const auto late = static_cast<double>(rig.device.now.sequence - rig.device.felt.echo);
  EXPECT_GE(late, 600);
  EXPECT_LE(late, 660);
}

/// All that was commanded, by third differences, while modes are switched under full deflection.
struct Abrupt {
  double arm = 0;   ///< m/s^3
  double base = 0;  ///< m/s^3
};

Abrupt WorstJerkWhileSwitching(const WireConfig& wire) {
  Rig rig({}, wire);
  rig.Run(10);
  const Random random(5, RandomStream::kTest);
  Abrupt worst;
  std::vector<double> z(3, rig.start[14]);
  std::vector<double> v(2, 0.0);
  for (std::uint64_t i = 0; i < 30'000; ++i) {
    if (i % 250 == 0) {
      rig.device.now.axes[0] = random.Uniform(i, 0) < 0.4 ? 0 : 2 * random.Uniform(i, 1) - 1;
      rig.device.now.axes[2] = rig.device.now.axes[0];
    }
    if (i % 1700 == 900) ++rig.device.now.mode_presses;
    rig.Step();
    const double z_now = rig.target.O_T_EE[14];
    const double v_now = rig.base.state.twist.v;
    worst.arm = std::max(worst.arm, std::abs(z_now - 3 * z[0] + 3 * z[1] - z[2]) / 1e-9);
    worst.base = std::max(worst.base, std::abs(v_now - 2 * v[0] + v[1]) / 1e-6);
    z = {z_now, z[0], z[1]};
    v = {v_now, v[0]};
  }
  return worst;
}

TEST(TeleoperatorTest, SwitchesModesWithoutAStepInTheArmsJerk) {
  EXPECT_LE(WorstJerkWhileSwitching({}).arm, TeleoperatorConfig().along.jerk * 1.02);
}

TEST(TeleoperatorTest, SwitchesModesWithoutAStepInTheBasesJerk) {
  EXPECT_LE(WorstJerkWhileSwitching({}).base, TeleoperatorConfig().ahead.jerk * 1.02);
}

TEST(TeleoperatorTest, KeepsItsBoundsOverABadWire) {
  const Abrupt worst = WorstJerkWhileSwitching(BadWire());
  EXPECT_LE(worst.arm, TeleoperatorConfig().along.jerk * 1.02);
  EXPECT_LE(worst.base, TeleoperatorConfig().ahead.jerk * 1.02);
}

TEST(TeleoperatorTest, LeadsTheArmWithinASecondAfterAGentleBaseStands) {
  TeleoperatorConfig config;
  config.ahead = {.speed = 0.5, .acceleration = 0.3, .jerk = 4};
  Rig rig(config);
  rig.Run(10);
  ++rig.device.now.mode_presses;
  rig.Run(10);
  rig.device.now.axes[0] = 1;
  rig.Run(3000);
  rig.device.now.axes[0] = 0;
  ++rig.device.now.mode_presses;
  rig.Run(1667 + 1000);  // 0.5 m/s at 0.3 m/s^2, and a second
  EXPECT_EQ(rig.teleoperator.TakeStatus().mode, Mode::kArm);
}

TEST(TeleoperatorTest, ReportsThePeaksThatAreSeenFromOutside) {
  Rig rig;
  rig.Run(10);
  rig.device.now.axes[2] = 1;
  double fastest = 0;
  for (int i = 0; i < 800; ++i) {
    rig.Step();
    fastest = std::max(fastest, rig.Speed());
  }
  EXPECT_NEAR(rig.teleoperator.TakeStatus().peaks.along.speed, fastest, 1e-9);
}

/// Drives the base at full speed, stops it, and drives on; the release comes so long after the
/// stop.
void StopAndGoOn(Rig& rig, int stopped_for) {
  rig.Run(10);
  ++rig.device.now.mode_presses;
  rig.Run(10);
  rig.device.now.axes[0] = 1;
  rig.Run(3000);
  ++rig.device.now.stop_presses;
  rig.Run(stopped_for);
  ++rig.device.now.release_presses;
  rig.device.now.axes[0] = 0;
  rig.Run(10);
  rig.device.now.axes[0] = 1;
  rig.Run(3000);
}

TEST(TeleoperatorTest, DoesNotCountAnEmergencyStopAsAbrupt) {
  for (const int stopped_for : {1, 500}) {
    Rig rig;
    StopAndGoOn(rig, stopped_for);
    const Peaks& ahead = rig.teleoperator.TakeStatus().peaks.ahead;
    EXPECT_NEAR(rig.base.state.twist.v, TeleoperatorConfig().ahead.speed, 1e-3);
    EXPECT_LE(ahead.jerk, TeleoperatorConfig().ahead.jerk * 1.02);
    EXPECT_LE(ahead.acceleration, TeleoperatorConfig().ahead.acceleration * 1.02);
  }
}

TEST(TeleoperatorTest, CountsWhatIsDrivenAfterAnEmergencyStop) {
  Rig rig;
  rig.Run(10);
  ++rig.device.now.mode_presses;
  ++rig.device.now.stop_presses;
  rig.Run(10);
  ++rig.device.now.release_presses;
  rig.Run(10);
  rig.device.now.axes[0] = 1;
  rig.Run(3000);
  EXPECT_NEAR(rig.teleoperator.TakeStatus().peaks.ahead.speed, TeleoperatorConfig().ahead.speed,
              1e-3);
}

TEST(TeleoperatorTest, DoesNotCountHowAStopShakesTheArm) {
  Rig rig;
  rig.Run(10);
  ++rig.device.now.mode_presses;
  rig.Run(10);
  ++rig.device.now.stop_presses;
  rig.Run(2);
  const auto shaken_to = [&] {
    rig.now += kCycle;
    rig.state.O_T_EE[12] = rig.target.O_T_EE[12] + 0.05;
    static_cast<void>(rig.teleoperator.Next(rig.state, rig.now));
    return rig.teleoperator.TakeStatus().most_drive_error;
  };
  EXPECT_LT(shaken_to(), 0.01);
  ++rig.device.now.release_presses;
  rig.base.state.twist.v = 0.3;  // it brakes still
  EXPECT_LT(shaken_to(), 0.01);
  rig.base.state.twist.v = 0;
  EXPECT_NEAR(shaken_to(), 0.05, 1e-3);
}

std::vector<Transform> PosesOf(std::uint64_t seed) {
  Rig rig({}, BadWire());
  Teleoperator other({.device = rig.device, .limits = twin::test::PandaLimits()}, {}, BadWire(),
                     seed);
  other.Begin(rig.start, Time{});
  std::vector<Transform> poses;
  for (int i = 1; i < 3000; ++i) {
    rig.device.now.axes[1] = std::sin(i * 0.004);
    poses.push_back(other.Next(rig.state, Time{milliseconds(i)}).O_T_EE);
  }
  return poses;
}

TEST(TeleoperatorTest, RepeatsBitByBitWithItsSeed) {
  EXPECT_EQ(PosesOf(3), PosesOf(3));
}

TEST(TeleoperatorTest, DiffersWithAnotherSeed) {
  EXPECT_NE(PosesOf(3), PosesOf(4));
}

TEST(TeleoperatorTest, TakesNoMemoryAndNoLocks) {
  Rig rig({}, BadWire());
  rig.device.now.axes[0] = 0.4;
  const twin::test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    if (i % 300 == 0) ++rig.device.now.mode_presses;
    if (i == 600) ++rig.device.now.stop_presses;
    if (i == 700) rig.device.now.kind = AxisKind::kPose;
    if (i == 800) ++rig.device.now.release_presses;
    rig.Step();
  }
  EXPECT_EQ(guard.counts(), twin::test::RealtimeGuard::Counts());
}

/// A rig whose arm is where the posture was a millisecond ago, and whose operator turns joints.
class JointRig : public Rig {
 public:
  JointRig() {
    device.now.joint = 1;
    Run(10);
  }
  void Turn(std::uint8_t joint, double share, int milliseconds) {
    device.now.joint = joint;
    device.now.axes[0] = share;
    Run(milliseconds);
  }
  /// One millisecond on; keeps the largest changes of the reference within one.
  void Step() {
    const reference::PoseTarget before = target;
    Rig::Step();
    state.q = teleoperator.posture()->q;
    double jump = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      jump = std::max(jump, std::abs(target.O_T_EE[12 + i] - before.O_T_EE[12 + i]));
      largest_change = std::max(largest_change, std::abs(target.O_dP_EE[i] - before.O_dP_EE[i]));
    }
    largest_step = std::max(largest_step, jump);
  }
  void Run(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) Step();
  }
  [[nodiscard]] double q(std::uint8_t joint) const { return teleoperator.posture()->q[joint - 1U]; }

  double largest_step = 0;    ///< of the reference in a millisecond along an axis, m
  double largest_change = 0;  ///< of its velocity, m/s
};

TEST(TurnedJointTest, TurnsAloneAtTheSpeedOfItsBounds) {
  JointRig rig;
  rig.Turn(6, 1, 500);
  const double began = rig.q(6);
  rig.Turn(6, 1, 1000);
  EXPECT_NEAR(rig.q(6) - began, TeleoperatorConfig().joint.speed, 1e-3);
  for (const std::uint8_t other : {1, 2, 3, 4, 5, 7}) {
    EXPECT_EQ(rig.q(other), test::kReady[other - 1U]);
  }
}

TEST(TurnedJointTest, TakesTheHandAlong) {
  JointRig rig;
  rig.Turn(4, 1, 700);
  rig.Turn(4, 0, 2000);
  JointVector q = test::kReady;
  q[3] = rig.q(4);
  const Transform there = model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(rig.target.O_T_EE[i], there[i], 1e-5);
}

TEST(TurnedJointTest, DoesNotMoveTheHandFasterThanItMay) {
  TeleoperatorConfig config;
  config.along.speed = 0.05;
  Rig rig(config);
  rig.device.now.joint = 1;
  rig.Run(10);
  rig.device.now.axes[0] = 1;
  rig.Run(1500);
  EXPECT_NEAR(rig.Speed(), config.along.speed, 1e-3);
}

TEST(TurnedJointTest, RestsWhenItsKeyIsReleased) {
  JointRig rig;
  rig.Turn(2, -1, 600);
  rig.Turn(2, 0, 1000);
  const double stands = rig.q(2);
  rig.Run(1000);
  EXPECT_NEAR(rig.q(2), stands, 1e-9);
}

TEST(TurnedJointTest, StopsBeforeEitherEndAndSaysWhich) {
  for (std::uint8_t joint = 1; joint <= 7; ++joint) {
    for (const double way : {-1.0, 1.0}) {
      JointRig rig;
      rig.Turn(joint, way, 20000);
      const JointLimits limits = twin::test::PandaLimits();
      const double end = way > 0 ? limits.q_max[joint - 1U] : limits.q_min[joint - 1U];
      EXPECT_GE(way * (end - rig.q(joint)), MotionGuard::kJointMargin - 1e-3)
          << "joint " << int{joint} << " towards " << end;
      EXPECT_NE(rig.device.felt.limit.bound, Bound::kNone) << "joint " << int{joint};
      const double stands = rig.q(joint);
      rig.Run(500);
      EXPECT_NEAR(rig.q(joint), stands, 1e-3) << "joint " << int{joint};
      if (joint == 1 || joint == 7) {
        EXPECT_EQ(rig.device.felt.limit, (ActiveBound{Bound::kJointEnd, joint}));
      }
      rig.Turn(joint, -way, 1000);
      EXPECT_GT(way * (stands - rig.q(joint)), 0.1) << "it does not come back";
    }
  }
}

TEST(TurnedJointTest, ChangesBetweenHandAndJointsWithoutAStep) {
  JointRig rig;
  for (int round = 0; round < 3; ++round) {
    rig.Turn(4, -1, 700);
    rig.Turn(6, 0.8, 700);  // while joint 4 still turns
    rig.device.now.joint = 0;
    rig.Run(700);  // a stick that is not centred leads nothing
    rig.device.now.axes = {};
    rig.Run(10);
    rig.device.now.axes = {0.5, -0.5, 0.5, 0.5, 0, 0};
    rig.Run(900);
    rig.device.now.axes = {};
    rig.Run(10);
  }
  const TeleoperatorConfig config;
  EXPECT_LE(rig.largest_step, 1.02e-3 * config.along.speed);
  EXPECT_LE(rig.largest_change, 1.5e-3 * config.along.acceleration);
}

TEST(TurnedJointTest, LeavesThePostureWhereTheHandGoesOn) {
  JointRig rig;
  rig.Turn(1, 1, 500);
  rig.Turn(1, 0, 1000);
  rig.device.now.joint = 0;
  const double stands = rig.q(1);
  rig.Run(100);
  EXPECT_EQ(rig.device.felt.joint, 0);
  EXPECT_NEAR(rig.q(1), stands, 1e-6);
}

TEST(TurnedJointTest, TakesNoMemoryAndNoLocks) {
  Rig rig;
  rig.device.now.joint = 3;
  const twin::test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    rig.device.now.axes[0] = i > 5 ? 1 : 0;
    if (i == 500) rig.device.now.joint = 5;
    rig.Step();
  }
  EXPECT_EQ(guard.counts(), twin::test::RealtimeGuard::Counts());
}

TEST(TeleoperatorConfigTest, NamesTheFieldThatIsOutOfRange) {
  TeleoperatorConfig config;
  config.along.jerk = -1;
  try {
    config.Validate();
    FAIL() << "it was taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("arm.along.jerk"), std::string::npos);
  }
}

TEST(TeleoperatorConfigTest, ReadsWhatAScenarioGives) {
  const control::Parameters parameters{
      {.key = "stale_after", .values = {"150 ms"}},
      {.key = "arm.along.speed", .values = {"0.1 m/s"}},
      {.key = "workspace.low", .values = {"0 m", "-1 m", "0 m"}, .is_list = true},
      {.key = "feedback.passive", .values = {"false"}}};
  control::ParameterReader reader(parameters, "operator.settings");
  const TeleoperatorConfig config = ReadTeleoperatorConfig(reader);
  reader.RefuseUnread();
  TeleoperatorConfig expected;
  expected.stale_after = milliseconds(150);
  expected.along.speed = 0.1;
  expected.workspace.low = {0, -1, 0};
  expected.feedback.passive = false;
  EXPECT_EQ(config, expected);
}

}  // namespace
}  // namespace twin::teleop::teleop_teleoperator_test
