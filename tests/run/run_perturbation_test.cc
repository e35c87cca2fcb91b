// A push that waits for a motion, in sessions of two: at the same place in it on every robot.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "run/session_fixture.h"
#include "support/bits.h"
#include "support/undisturbed.h"

namespace twin::run::run_perturbation_test {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 300ms

constexpr Duration kPushBegin = 300ms;
constexpr Duration kPushDuration = 400ms;

enum class Place : std::uint8_t { kLockstep, kServedInLockstep, kRealtime };

/// Keeps what the robot measured, and the cycles that took a motion's first command.
class Cycles final : public record::RecordSink {
 public:
  Cycles() { measured.reserve(100'000); }
  void Put(const record::CycleRecord& record) noexcept override {
    if (measured.size() == measured.capacity()) return;
    const bool in_motion = record.fate != record::CommandFate::kNone;
    if (in_motion && !was_in_motion_ && motions < begins.size()) {
      begins[motions++] = measured.size();
    }
    was_in_motion_ = in_motion;
    measured.push_back(record.state);
  }
  void Put(const record::TickRecord& /*record*/) noexcept override {}

  /// Of the `motion`-th motion, from its first cycle to the next one's, or to the end.
  [[nodiscard]] std::vector<RobotState> Of(std::size_t motion) const {
    const std::size_t end = motion + 1 < motions ? begins[motion + 1] : measured.size();
    return {measured.begin() + static_cast<std::ptrdiff_t>(begins[motion]),
            measured.begin() + static_cast<std::ptrdiff_t>(end)};
  }

  std::vector<RobotState> measured;
  std::array<std::size_t, 4> begins{};
  std::size_t motions = 0;

 private:
  bool was_in_motion_ = false;
};

class SessionPerturbationTest : public test::SessionFixture {
 protected:
  /// Two slow motions of joint 1, with a push at the hand in the second, or with nothing.
  [[nodiscard]] static scenario::Scenario TwoMotions(bool with_push) {
    scenario::Scenario scenario = test::Standing();
    scenario.plant.kind = robot::PlantKind::kMujoco;
    scenario.link = scenario::LinkSection();
    scenario.onboard.collision_behavior = Insensitive();
    if (with_push) {
      scenario.perturbations = {plant::Push{.body = "panda_hand",
                                            .begin = kPushBegin,
                                            .motion = 2,
                                            .duration = kPushDuration,
                                            .force = {0, 0, -20}}};
    }
    return scenario;
  }
  [[nodiscard]] static setting::CollisionBehavior Insensitive() {
    setting::CollisionBehavior behavior;
    behavior.upper_torque_acc.fill(100);
    behavior.upper_torque_nominal.fill(100);
    behavior.upper_force_acc.fill(100);
    behavior.upper_force_nominal.fill(100);
    return behavior;
  }

  void Attempt(Place place, bool with_push, Cycles& cycles) {
    scenario::Scenario scenario = TwoMotions(with_push);
    std::unique_ptr<server::ServedRobot> served;
    RealtimeConfig settings;
    if (place == Place::kServedInLockstep) {
      served = Serve(scenario, backend::RobotTime::kStates, &cycles);
      scenario.perturbations.clear();  // the client knows nothing of it
      scenario.backend = "fci";
      settings.remote = {
          .host = "127.0.0.1", .arm_port = served->arm().port, .time = backend::RobotTime::kStates};
      settings.checks_start = false;
    } else if (place == Place::kRealtime) {
      scenario.drive = scenario::Drive::kRealtime;
    }
    {
      const auto session = Open(scenario, served ? nullptr : &cycles, settings);
      session->Begin();
      const MotionResult there = Go(*session, scenario, test::kRest, 0.1);
      ASSERT_TRUE(there.report.succeeded()) << there.report.failure;
      const JointVector q = session->ReadState().q_d;
      const MotionResult back = Go(*session, scenario, q, -0.1);
      ASSERT_TRUE(back.report.succeeded()) << back.report.failure;
      static_cast<void>(session->End());
    }
    if (served) served->End();
    ASSERT_EQ(cycles.motions, 2u);
  }

  /// Cycles from the second motion's first to the first that the push has changed.
  std::optional<std::size_t> FirstPushed(Place place) {
    Cycles pushed;
    Cycles left_alone;
    Attempt(place, true, pushed);
    Attempt(place, false, left_alone);
    if (HasFatalFailure()) return std::nullopt;
    EXPECT_EQ(FirstDifference(pushed.Of(0), left_alone.Of(0)), std::nullopt);
    return FirstDifference(pushed.Of(1), left_alone.Of(1));
  }

 private:
  MotionResult Go(Session& session, const scenario::Scenario& scenario, const JointVector& from,
                  double angle) {
    return session.Move(Turn(from, angle, session, scenario, "turn"));
  }
  [[nodiscard]] static std::optional<std::size_t> FirstDifference(
      const std::vector<RobotState>& a, const std::vector<RobotState>& b) {
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
      if (test::Bits(a[i].q) != test::Bits(b[i].q)) return i;
    }
    return std::nullopt;
  }
};

/// The largest force at the hand, N, from `from` to `to` after the first of the states.
double StrongestForce(const std::vector<RobotState>& states, Duration from, Duration to) {
  double most = 0;
  for (Duration t = from; t < to && t / kCycle < std::ssize(states); t += kCycle) {
    const Vector6& F = states[static_cast<std::size_t>(t / kCycle)].O_F_ext_hat_K;
    most = std::max(most, std::hypot(F[0], F[1], F[2]));
  }
  return most;
}

TEST_F(SessionPerturbationTest, ActsInItsMotionAtTheSameCycleInProcessAndOverTheWire) {
  const auto expected = static_cast<std::size_t>(kPushBegin / kCycle);
  EXPECT_EQ(FirstPushed(Place::kLockstep), expected);
  EXPECT_EQ(FirstPushed(Place::kServedInLockstep), expected);
}

TEST_F(SessionPerturbationTest, ActsInItsMotionOnTheWallClock) {
  test::Undisturbed(
      [&] {
        Cycles cycles;
        Attempt(Place::kRealtime, true, cycles);
        ASSERT_EQ(cycles.motions, 2u);
        const std::vector<RobotState> second = cycles.Of(1);
        EXPECT_LT(StrongestForce(cycles.Of(0), 0s, 10s), 5);
        EXPECT_LT(StrongestForce(second, 0s, kPushBegin), 5);
        EXPECT_GT(StrongestForce(second, kPushBegin, kPushBegin + kPushDuration), 15);
        EXPECT_LT(StrongestForce(second, kPushBegin + kPushDuration + 300ms, 10s), 5);
      },
      [] { return test::kEndsAMotion; }, test::ByWitness(98), 5);
}

}  // namespace
}  // namespace twin::run::run_perturbation_test
