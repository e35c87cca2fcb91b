#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::plant::plant_perturbation_test {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 300ms
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kStep = 1e-3;

/// A scene with a ball of 2 kg that nothing touches and nothing pulls down.
constexpr const char* kBallScene = R"(<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="ball" pos="2 0 1">
      <freejoint/>
      <inertial pos="0.1 0 0" mass="2" diaginertia="0.03 0.02 0.01"/>
      <geom type="sphere" size="0.05" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
</mujoco>
)";

class PerturbationTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<MujocoPlant> WithBall() const {
    MujocoPlantOptions options = BareOptions();
    options.scene = folder_.Write("ball.xml", kBallScene);
    return MujocoPlant::Create(options);
  }

  TemporaryFolder folder_;
};

int BodyId(const MujocoPlant& plant, const char* name) {
  return mj_name2id(&plant.model(), mjOBJ_BODY, name);
}

/// Momentum [p; L about the centre of mass] of the ball, world axes.
Vector6 MomentumOfBall(const MujocoPlant& plant) {
  const int body = BodyId(plant, "ball");
  mjtNum twist[6];
  mj_objectVelocity(&plant.model(), &plant.data(), mjOBJ_BODY, body, twist, 0);
  mjtNum local[3];
  mju_rotVecMatT(local, twist, plant.data().ximat + 9 * body);
  for (int i = 0; i < 3; ++i) local[i] *= plant.model().body_inertia[3 * body + i];
  mjtNum spin[3];
  mju_rotVecMat(spin, local, plant.data().ximat + 9 * body);
  const double m = plant.model().body_mass[body];
  return {m * twist[3], m * twist[4], m * twist[5], spin[0], spin[1], spin[2]};
}

void StepFor(MujocoPlant& plant, Duration time) {
  for (Duration t{}; t < time; t += kCycle) plant.Step({});
}

TEST(PushTest, IsAPulseOfMinimumJerk) {
  const Push push{.body = "x", .begin = 1s, .duration = 500ms, .rise = 200ms, .force = {1, 0, 0}};
  EXPECT_EQ(ShareAt(push, 999ms), 0);
  EXPECT_EQ(ShareAt(push, 1s), 0);
  EXPECT_NEAR(ShareAt(push, 1050ms), 10 / 64. - 15 / 256. + 6 / 1024., 1e-15);
  EXPECT_NEAR(ShareAt(push, 1100ms), 0.5, 1e-15);
  for (const Duration t : {1200ms, 1250ms, 1300ms}) EXPECT_EQ(ShareAt(push, t), 1);
  EXPECT_EQ(ShareAt(push, 1501ms), 0);
  for (Duration t{}; t <= 250ms; t += 7ms) {
    EXPECT_DOUBLE_EQ(ShareAt(push, 1s + t), ShareAt(push, 1500ms - t)) << "falls as it rose";
  }
  // Speed and acceleration are continuous: between points 1 ms apart no second difference is more
  // than the largest acceleration of the polynomial, 10 / sqrt(3) / T^2.
  for (Duration t = 990ms; t <= 1510ms; t += 1ms) {
    const double second = ShareAt(push, t + 1ms) - 2 * ShareAt(push, t) + ShareAt(push, t - 1ms);
    EXPECT_LE(std::abs(second), 10 / std::numbers::sqrt3 / (200. * 200) * 1.0001);
  }
}

TEST(PushTest, WithoutRiseIsThereFromTheFirstToTheLastStep) {
  const Push push{.body = "x", .begin = 10ms, .duration = 5ms, .rise = 0ms};
  int steps = 0;
  for (int k = 0; k < 30; ++k) {
    if (ShareAt(push, k * kCycle + kCycle / 2) == 1) ++steps;
  }
  EXPECT_EQ(steps, 5);
}

TEST_F(PerturbationTest, GivesABodyTheMomentumOfThePulse) {
  const auto plant = WithBall();
  // Rise and fall together are worth one rise at full force.
  const Push push{.body = "ball",
                  .begin = 20ms,
                  .duration = 100ms,
                  .rise = 30ms,
                  .force = {3, -2, 1},
                  .torque = {0.01, 0.02, -0.03},
                  .point = {0.1, 0, 0}};
  plant->Perturb(push);
  plant->Reset(kReady);
  StepFor(*plant, 20ms);
  for (const double p : MomentumOfBall(*plant)) EXPECT_EQ(p, 0) << "before it begins";
  StepFor(*plant, 130ms);
  const Vector6 momentum = MomentumOfBall(*plant);
  // The ball turns about its centre, which is beside its origin: the engine's Euler steps lose
  // 1e-5.
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(momentum[i], push.force[i] * 0.07, 2e-5) << i;
    EXPECT_NEAR(momentum[3 + i], push.torque[i] * 0.07, 1e-4) << i;
  }
}

// F at an arm r about the centre of mass turns the body by r x F.
TEST_F(PerturbationTest, TurnsABodyThatIsPushedBesideItsCentre) {
  const auto plant = WithBall();
  plant->Perturb(Push{
      .body = "ball", .duration = 10ms, .rise = 0ms, .force = {0, 5, 0}, .point = {0.1, 0, 0.2}});
  plant->Reset(kReady);
  StepFor(*plant, 10ms);
  const Vector6 momentum = MomentumOfBall(*plant);
  EXPECT_NEAR(momentum[1], 0.05, 1e-9);
  EXPECT_NEAR(momentum[3], -0.2 * 0.05, 1e-4);
  EXPECT_NEAR(momentum[4], 0, 1e-4);
  EXPECT_NEAR(momentum[5], 0, 1e-4);
}

TEST_F(PerturbationTest, AForceThatWaitsForAMotionBeginsWithThatMotionOnly) {
  const auto plant = WithBall();
  plant->Perturb(Push{.body = "ball",
                      .begin = 5ms,
                      .motion = 2,
                      .duration = 10ms,
                      .rise = 0ms,
                      .force = {0, 5, 0},
                      .point = {0.1, 0, 0}});
  const auto momentum = [&plant] { return MomentumOfBall(*plant)[1]; };
  for (int start = 0; start < 2; ++start) {
    plant->Reset(kReady);
    StepFor(*plant, 20ms);
    plant->BeginMotion();
    StepFor(*plant, 20ms);
    EXPECT_EQ(momentum(), 0) << "it is the second that is waited for";
    plant->BeginMotion();
    StepFor(*plant, 5ms);
    EXPECT_EQ(momentum(), 0) << "before it begins";
    StepFor(*plant, 4ms);
    EXPECT_NEAR(momentum(), 5 * 4e-3, 1e-9);
    plant->BeginMotion();
    StepFor(*plant, 50ms);
    EXPECT_NEAR(momentum(), 5 * 10e-3, 1e-9) << "whole, once, whatever follows";
  }
}

TEST_F(PerturbationTest, AHandThatWaitsForAMotionTakesHoldWhereThePointThenIs) {
  const auto plant = WithBall();
  plant->Perturb(Push{.body = "ball", .duration = 10ms, .rise = 0ms, .force = {5, 0, 0}});
  plant->Perturb(HandSpring{.body = "ball", .motion = 1, .duration = 1h, .damping = 500});
  plant->Reset(kReady);
  const auto x = [&plant] { return plant->data().xpos[3 * BodyId(*plant, "ball")]; };
  StepFor(*plant, 100ms);
  const double held_from = x();
  EXPECT_GT(held_from, 2.001);
  plant->BeginMotion();
  StepFor(*plant, 2s);
  EXPECT_NEAR(x(), held_from, 1e-4) << "the spring has brought it back";
}

TEST_F(PerturbationTest, TheForceTurnsWithTheBodyOnlyInTheFrameOfTheBody) {
  for (const ForceFrame frame : {ForceFrame::kWorld, ForceFrame::kBody}) {
    const auto plant = MujocoPlant::Create(BareOptions());
    const Push push{.body = "panda_link4",
                    .duration = 1h,
                    .rise = 0ms,
                    .force = {1, 2, 3},
                    .torque = {4, 5, 6},
                    .frame = frame};
    plant->Perturb(push);
    plant->Reset({0.3, 0.2, -0.4, -1.6, 0.5, 1.8, 0.1});
    StepFor(*plant, 50ms);
    const int body = BodyId(*plant, "panda_link4");
    const auto turned = MujocoPlant::Create(BareOptions());  // same pose as before the last step
    turned->Reset({0.3, 0.2, -0.4, -1.6, 0.5, 1.8, 0.1});
    turned->Perturb(push);
    StepFor(*turned, 49ms);
    mjtNum expected[3];
    if (frame == ForceFrame::kBody) {
      mju_rotVecMat(expected, push.force.data(), turned->data().xmat + 9 * body);
    } else {
      mju_copy3(expected, push.force.data());
    }
    for (int i = 0; i < 3; ++i) {
      EXPECT_DOUBLE_EQ(plant->data().xfrc_applied[6 * body + i], expected[i]);
    }
  }
}

// A torque J^T F less at the joints holds the arm where it is pushed with F.
TEST_F(PerturbationTest, TheArmRestsWhereTheJointsPushBack) {
  const auto plant = MujocoPlant::Create(BareOptions());
  const Push push{.body = "panda_link8",
                  .duration = 1h,
                  .rise = 0ms,
                  .force = {12, -7, 5},
                  .torque = {0.5, -1, 0.7},
                  .point = {0.02, -0.01, 0.1}};
  plant->Perturb(push);
  plant->Reset(kReady);
  const int body = BodyId(*plant, "panda_link8");
  mjtNum point[3];
  mju_rotVecMat(point, push.point.data(), plant->data().xmat + 9 * body);
  mju_addTo3(point, plant->data().xpos + 3 * body);
  mjtNum Jp[3 * kJoints];
  mjtNum Jr[3 * kJoints];
  mj_jac(&plant->model(), &plant->data(), Jp, Jr, point, body);
  JointDrive drive{.tau = plant->GravityTorque(kReady)};
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (std::size_t r = 0; r < 3; ++r) {
      drive.tau[i] -= Jp[kJoints * r + i] * push.force[r] + Jr[kJoints * r + i] * push.torque[r];
    }
  }
  for (int k = 0; k < 200; ++k) plant->Step(drive);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(plant->sensors().q[i], kReady[i], 1e-9);
    EXPECT_NEAR(plant->sensors().tau_J[i], drive.tau[i], 1e-6) << "the contact shows in tau_J";
  }
}

TEST_F(PerturbationTest, SeveralOnOneBodyAddUpAndCanBeTakenAway) {
  const auto plant = WithBall();
  const Push push{.body = "ball", .duration = 1h, .rise = 0ms, .force = {1, 2, 3}};
  plant->Perturb(push);
  plant->Perturb(push);
  plant->Reset(kReady);
  plant->Step({});
  const int body = BodyId(*plant, "ball");
  for (int i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(plant->data().xfrc_applied[6 * body + i], 2 * push.force[i]);
  }
  plant->ClearPerturbations();
  const Vector6 momentum = MomentumOfBall(*plant);
  StepFor(*plant, 10ms);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(plant->data().xfrc_applied[6 * body + i], 0);
    EXPECT_NEAR(MomentumOfBall(*plant)[i], momentum[i], 1e-8);
  }
}

/// Where the point (0.1, 0, 0) of the ball, its centre of mass, is.
Vector3 CentreOfBall(const MujocoPlant& plant) {
  const double* x = plant.data().xipos + 3 * BodyId(plant, "ball");
  return {x[0], x[1], x[2]};
}

// A mass on a spring: d^2 x / dt^2 = (K (r - x) - D dx) / m, solved here as the engine integrates.
TEST_F(PerturbationTest, TheSpringPullsAsAnOscillatorDoes) {
  const auto plant = WithBall();
  const HandSpring spring{.body = "ball",
                          .point = {0.1, 0, 0},
                          .duration = 1h,
                          .from = Vector3{2.1, 0.05, 1},
                          .stiffness = 200,
                          .damping = 4,
                          .largest_force = 1000};
  plant->Perturb(spring);
  plant->Reset(kReady);
  double y = 0;
  double dy = 0;
  for (int k = 0; k < 400; ++k) {
    plant->Step({});
    dy += kStep * (spring.stiffness * (0.05 - y) - spring.damping * dy) / 2;
    y += kStep * dy;
    ASSERT_NEAR(CentreOfBall(*plant)[1], y, 1e-9) << k;
  }
  EXPECT_NEAR(CentreOfBall(*plant)[0], 2.1, 1e-12);
}

TEST_F(PerturbationTest, TheSpringTakesHoldWhereThePointIsAndLeadsIt) {
  const auto plant = WithBall();
  plant->Perturb(HandSpring{.body = "ball",
                            .point = {0.1, 0, 0},
                            .begin = 100ms,
                            .duration = 1500ms,
                            .by = {0.1, -0.2, 0.05},
                            .stiffness = 2000,
                            .damping = 100});
  plant->Reset(kReady);
  StepFor(*plant, 101ms);
  const int body = BodyId(*plant, "ball");
  EXPECT_LT(mju_norm3(plant->data().xfrc_applied + 6 * body), 1e-3) << "no jerk where it begins";
  StepFor(*plant, 1498ms);
  const Vector3 at_end = CentreOfBall(*plant);
  EXPECT_NEAR(at_end[0], 2.2, 1e-3);
  EXPECT_NEAR(at_end[1], -0.2, 1e-3);
  EXPECT_NEAR(at_end[2], 1.05, 1e-3);
  StepFor(*plant, 10ms);
  EXPECT_EQ(mju_norm3(plant->data().xfrc_applied + 6 * body), 0) << "it has let go";
}

TEST_F(PerturbationTest, TheSpringPullsNoHarderThanItsLargestForce) {
  const auto plant = WithBall();
  plant->Perturb(HandSpring{.body = "ball",
                            .point = {0.1, 0, 0},
                            .duration = 1h,
                            .from = Vector3{2.1, 3, 5},
                            .largest_force = 7});
  plant->Reset(kReady);
  plant->Step({});
  const double* force = plant->data().xfrc_applied + 6 * BodyId(*plant, "ball");
  EXPECT_NEAR(mju_norm3(force), 7, 1e-12);
  EXPECT_NEAR(force[1], 7 * 0.6, 1e-12);
  EXPECT_NEAR(force[2], 7 * 0.8, 1e-12);
}

TEST_F(PerturbationTest, RepeatsToTheByteAfterReset) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  plant->Perturb(Push{.body = "panda_hand", .begin = 50ms, .force = {10, 0, 0}});
  plant->Perturb(
      HandSpring{.body = "panda_link5", .begin = 100ms, .duration = 400ms, .by = {0, 0.1, 0}});
  const auto run = [&plant] {
    plant->Reset(kReady);
    std::vector<JointSensors> seen;
    for (int k = 0; k < 450; ++k) {
      plant->Step({.tau = {0, -2, 0.5, 20, 0.1, 1, 0}});
      seen.push_back(plant->sensors());
    }
    return seen;
  };
  const auto first = run();
  const auto second = run();
  EXPECT_EQ(std::memcmp(first.data(), second.data(), first.size() * sizeof(first[0])), 0);
  EXPECT_EQ(plant->plant_time(), 450ms);
}

TEST_F(PerturbationTest, ActsWithoutAllocationOrLock) {
  MujocoPlantOptions options = DefaultOptions();
  options.perturbations = {
      Push{.body = "panda_hand", .begin = 100ms, .force = {10, 0, 0}, .frame = ForceFrame::kBody},
      HandSpring{.body = "panda_link5", .begin = 300ms, .duration = 400ms, .by = {0, 0.1, 0}},
      Push{.body = "panda_hand", .begin = 50ms, .motion = 2, .force = {0, 10, 0}}};
  const auto plant = MujocoPlant::Create(options);
  const JointDrive drive{.tau = plant->GravityTorque(kReady)};
  const test::RealtimeGuard guard;
  for (int k = 0; k < 1000; ++k) {
    if (k % 400 == 0) plant->BeginMotion();
    plant->Step(drive);
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts.allocations, 0);
  EXPECT_EQ(counts.frees, 0);
  EXPECT_EQ(counts.locks, 0);
  EXPECT_EQ(plant->warning_count(), 0u) << plant->DescribeWarnings();
}

TEST_F(PerturbationTest, RefusesABodyTheModelDoesNotHave) {
  MujocoPlantOptions options = BareOptions();
  for (const char* name : {"panda_hnd", "", "world"}) {
    options.perturbations = {Push{.body = name, .force = {1, 0, 0}}};
    EXPECT_THAT(MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); }),
                AllOf(HasSubstr(std::string("\"") + name + "\""), HasSubstr("panda_link0, "),
                      HasSubstr("panda_link8")));
  }
}

TEST_F(PerturbationTest, RefusesValuesOutOfRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const Perturbation& bad, const char* field) {
    EXPECT_THAT(MessageOf<InputError>([&] { Validate(bad); }), HasSubstr(field));
  };
  refused(Push{.body = "x", .begin = -1ms}, "push: begin is -0.001 s");
  refused(Push{.body = "x", .duration = 0ms, .rise = 0ms}, "push: duration is 0 s");
  refused(Push{.body = "x", .duration = 100ms, .rise = 51ms}, "push: rise is 0.051 s");
  refused(Push{.body = "x", .rise = -1ms}, "push: rise");
  refused(Push{.body = "x", .force = {0, 10001, 0}}, "push: force (N) is 10001");
  refused(Push{.body = "x", .torque = {0, nan, 0}}, "push: torque (Nm) is nan");
  refused(Push{.body = "x", .point = {-101, 0, 0}}, "push: point (m) is -101");
  refused(Push{.body = "x", .motion = 0}, "push: motion is 0; motions count from 1");
  refused(HandSpring{.body = "x", .motion = 0}, "spring: motion is 0");
  refused(HandSpring{.body = "x", .begin = -1ms}, "spring: begin");
  refused(HandSpring{.body = "x", .duration = -1ms}, "spring: duration");
  refused(HandSpring{.body = "x", .from = Vector3{nan, 0, 0}}, "spring: from (m)");
  refused(HandSpring{.body = "x", .by = {0, 0, 101}}, "spring: by (m) is 101");
  refused(HandSpring{.body = "x", .stiffness = -1}, "spring: stiffness (N/m) is -1");
  refused(HandSpring{.body = "x", .damping = 501}, "spring: damping (Ns/m) is 501");
  refused(HandSpring{.body = "x", .largest_force = nan}, "spring: largest_force (N) is nan");
  EXPECT_NO_THROW(Validate(Push{.body = "x"}));
  EXPECT_NO_THROW(Validate(HandSpring{.body = "x"}));
}

}  // namespace
}  // namespace twin::plant::plant_perturbation_test
