// The paper's arithmetic of sampling jitter, as INT's monitor sees it: jerk error = speed x third
// difference of the displacements / T^3.
#include <chrono>
#include <cmath>

#include <gtest/gtest.h>

#include "loop/loop_fixture.h"

namespace twin::loop::loop_sampling_jitter_test {
namespace {

using std::chrono::microseconds;

/// Brings joint 1 to 1 rad/s within a second and keeps it there; one sample is taken `displaced`
/// late.
class OneDisplacedSample final : public control::Controller {
 public:
  explicit OneDisplacedSample(Duration displaced) : displaced_(displaced) {}

  control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  void Activate(const RobotState& state, Time) override { start_ = state.q_d; }
  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept override {
    if (first_ == 0) first_ = state.message_id;
    static_cast<void>(now);
    double t = ToSeconds(kCycle * static_cast<std::int64_t>(state.message_id - first_));
    if (state.message_id - first_ == kDisplaced) t += ToSeconds(displaced_);
    output.target.joint.q = start_;
    output.target.joint.q[0] += t <= 1 ? t * t * t * (1 - t / 2) : 0.5 + (t - 1);
    output.has_velocity = true;
  }
  void Deactivate() noexcept override {}

  static constexpr std::uint64_t kDisplaced = 1500;

 private:
  Duration displaced_;
  JointVector start_{};
  std::uint64_t first_ = 0;
};

/// A raw stream of the bare loop: what is sampled in a cycle is filed in the next.
test::LockstepMotion RawStream() {
  test::LockstepMotion motion;
  motion.kind = LoopKind::kBare;
  motion.tick.generator = Generator::kNone;
  motion.time_limit = std::chrono::seconds(2);
  return motion;
}

TEST(SamplingJitterTest, OneSample4MicrosecondsLateAtOneRadianPerSecondIsTwelveThousandOfJerk) {
  // With the limit out of the way, so that the monitor's whole pattern 1, -3, 3, -1 passes.
  auto motion = RawStream();
  motion.robot.onboard.limits.dddq_max.fill(1e5);
  motion.robot.onboard.limits.ddq_max.fill(1e3);
  OneDisplacedSample controller(microseconds(4));
  test::Keeper keeper;
  static_cast<void>(motion.Run(controller, 1, &keeper));
  double largest = 0;
  std::vector<double> pattern;
  for (const record::CycleRecord& cycle : keeper.cycles) {
    if (cycle.state.message_id > 1900) break;  // from there on the drive stops the motion
    largest = std::max(largest, std::abs(cycle.dddq_d[0]));
    if (std::abs(cycle.dddq_d[0]) > 1000) pattern.push_back(cycle.dddq_d[0]);
  }
  EXPECT_NEAR(largest, 1.2e4, 0.01 * 1.2e4);
  ASSERT_EQ(pattern.size(), 4u);
  EXPECT_NEAR(pattern[0], 4e3, 40);
  EXPECT_NEAR(pattern[1], -1.2e4, 120);
  EXPECT_NEAR(pattern[2], 1.2e4, 120);
  EXPECT_NEAR(pattern[3], -4e3, 40);
}

TEST(SamplingJitterTest, ThatIsAboveTheLimitAndAborts) {
  auto motion = RawStream();
  OneDisplacedSample controller(microseconds(4));
  const RunReport report = motion.Run(controller);
  EXPECT_EQ(report.end, backend::MotionEnd::kAborted);
  EXPECT_EQ(FormatErrors(report.errors), "[\"joint_motion_generator_acceleration_discontinuity\"]");
  ASSERT_EQ(report.violations.size(), 1u);
  EXPECT_EQ(report.violations[0].axis, 0);
  EXPECT_NEAR(report.violations[0].value, -1.2e4, 120);
}

TEST(SamplingJitterTest, WithoutTheDisplacementTheSameStreamPasses) {
  auto motion = RawStream();
  OneDisplacedSample controller(Duration::zero());
  EXPECT_EQ(motion.Run(controller).end, backend::MotionEnd::kPreempted) << "it never ends itself";
}

/// The motion of a raw stream whose samples carry uniform noise of +-`noise` rad on all joints.
RunReport NoisyStream(double noise) {
  auto motion = RawStream();
  motion.controller_loop.target_noise = noise;
  test::Swing swing;
  return motion.Run(swing);
}

TEST(SamplingJitterTest, NoiseOfAMicroradianOnARawStreamAborts) {
  const RunReport report = NoisyStream(1e-6);
  EXPECT_EQ(report.end, backend::MotionEnd::kAborted);
  EXPECT_EQ(FormatErrors(report.errors), "[\"joint_motion_generator_acceleration_discontinuity\"]");
}

TEST(SamplingJitterTest, NoiseOfATenthOfItPasses) {
  EXPECT_EQ(NoisyStream(1e-7).end, backend::MotionEnd::kPreempted)
      << "noise is never at rest: the time limit ends it";
}

TEST(SamplingJitterTest, BehindTheGeneratorNoiseOnPositionIsScaledByLambdaAlone) {
  // With the source's own velocity given, what is left of 1e-6 rad is 1e-9 per cycle.
  auto motion = RawStream();
  motion.tick.generator = Generator::kJoint;
  motion.controller_loop.target_noise = 1e-6;
  OneDisplacedSample controller(Duration::zero());
  test::Keeper keeper;
  const RunReport report = motion.Run(controller, 1, &keeper);
  EXPECT_EQ(report.end, backend::MotionEnd::kPreempted) << report.failure;
}

}  // namespace
}  // namespace twin::loop::loop_sampling_jitter_test
