// A robot in motion, a wire that is dead for as long as can be bridged, and a client that answers
// each state with what it makes of one that is older: with regard to the commands in flight, and
// without.
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "robot/robot_fixture.h"
#include "twin/core/random.h"
#include "twin/plant/ideal_plant.h"
#include "twin/reference/viability_in_flight.h"

namespace twin::reference::reference_late_client_test {
namespace {

using std::chrono::milliseconds;

constexpr int kMotionMs = 2000;

enum class Wish { kWild, kSmooth };

class LateClient final : public rt::EventHandler {
 public:
  LateClient(int in_flight, bool velocities, Wish wish, bool regards)
      : in_flight_(in_flight),
        velocities_(velocities),
        wish_(wish),
        regards_(regards),
        late_(test::PandaLimits(), in_flight),
        unaware_(test::PandaLimits()) {}

  void OnEvent(Time, std::uint64_t) noexcept override {
    if (robot->states().has_new()) Answer(robot->states().Take());
  }
  robot::Robot* robot = nullptr;

 private:
  void Answer(const RobotState& state) {
    states_.push_back(state);
    if (states_.size() > static_cast<std::size_t>(in_flight_) + 1) {
      states_.erase(states_.begin());
      since_.erase(since_.begin());
    }
    const InFlight done = Made(states_.front());
    since_.push_back(done);
    if (!done.sent) return;
    RobotCommand command;
    command.message_id = state.message_id;
    (velocities_ ? command.dq_c : command.q_c) = done.c;
    robot->Send(command);
  }

  [[nodiscard]] InFlight Made(const RobotState& old) {
    const JointVector wish = Wished(old);
    if (!regards_) {
      const auto outcome = velocities_ ? unaware_.NextVelocity(old.q_d, old.dq_d, old.ddq_d, wish)
                                       : unaware_.Next(old.q_d, old.dq_d, old.ddq_d, wish);
      return {true, velocities_ ? outcome.dq_c : outcome.q_c};
    }
    const auto outcome = velocities_
                             ? late_.NextVelocity(old.q_d, old.dq_d, old.ddq_d, since_, wish)
                             : late_.Next(old.q_d, old.dq_d, old.ddq_d, since_, wish);
    return {outcome.send, outcome.c};
  }

  /// Moves the joints by which the arm cannot touch itself.
  [[nodiscard]] JointVector Wished(const RobotState& old) {
    JointVector wish = velocities_ ? JointVector{} : test::kReady;
    const double t = 1e-3 * static_cast<double>(++answered_);
    const double omega = 6.283185307;  // 1 Hz
    for (const std::size_t joint : {0, 6}) {
      if (wish_ == Wish::kWild) {
        const double jump = std::sin(1e3 * random_.Uniform(++draws_));
        wish[joint] = velocities_ ? jump : old.q_d[joint] + jump;
      } else if (velocities_) {
        wish[joint] = 0.6 * omega * 0.1 * std::sin(omega * t) * (1 - std::cos(omega * t));
      } else {
        wish[joint] += 0.1 * std::pow(1 - std::cos(omega * t), 2);
      }
    }
    return wish;
  }

  int in_flight_;
  bool velocities_;
  Wish wish_;
  bool regards_;
  ViabilityInFlight late_;
  ViabilityFilter unaware_;
  const Random random_{5, RandomStream::kTest};
  std::uint64_t draws_ = 0;
  std::uint64_t answered_ = 0;
  std::vector<RobotState> states_;
  std::vector<InFlight> since_;
};

class Tally final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override {
    violations += record.violated ? 1 : 0;
    served += record.fate == record::CommandFate::kServed ? 1 : 0;
  }
  void Put(const record::TickRecord&) noexcept override {}
  int violations = 0;
  int served = 0;
};

class LateClientTest : public ::testing::TestWithParam<std::tuple<int, bool, Wish>> {
 protected:
  [[nodiscard]] static Tally Run(bool regards) {
    const auto [in_flight, velocities, wish] = GetParam();
    robot::RobotConfig config = test::PandaRobot();
    faults::ScriptedLoss dead;
    for (std::uint64_t k = 1; k < 20; ++k) {
      dead.runs.push_back({97 * k, static_cast<std::uint32_t>(19 - 2 * in_flight)});
    }
    config.link.command.loss = faults::LossModel(dead);
    rt::EventQueue events;
    LateClient client(in_flight, velocities, wish, regards);
    Tally tally;
    robot::Robot robot(config, std::make_unique<plant::IdealPlant>(), events, client, &tally);
    client.robot = &robot;
    robot.Begin();
    EXPECT_EQ(robot.Move({ControllerMode::kJointImpedance,
                          velocities ? MotionGeneratorMode::kJointVelocity
                                     : MotionGeneratorMode::kJointPosition}),
              MoveStatus::kMotionStarted);
    while (events.Now() < Time(milliseconds(kMotionMs))) EXPECT_TRUE(events.RunNext());
    EXPECT_EQ(robot.mode() == RobotMode::kMove, tally.violations == 0);
    return tally;
  }
};

TEST_P(LateClientTest, NoLimitIsBrokenWhateverIsWishedAndLost) {
  const Tally tally = Run(true);
  EXPECT_EQ(tally.violations, 0);
  EXPECT_GT(tally.served, kMotionMs / 5);
}

std::string NameOf(const ::testing::TestParamInfo<LateClientTest::ParamType>& param) {
  const auto [in_flight, velocities, wish] = param.param;
  return std::to_string(in_flight) + (velocities ? "Velocities" : "Positions") +
         (wish == Wish::kWild ? "Wild" : "Smooth");
}

INSTANTIATE_TEST_SUITE_P(InFlight, LateClientTest,
                         ::testing::Combine(::testing::Values(1, 2), ::testing::Bool(),
                                            ::testing::Values(Wish::kWild, Wish::kSmooth)),
                         NameOf);

/// Not with smooth velocities of one cycle's delay: that stream needs no regard.
class UnawareClientTest : public LateClientTest {};

TEST_P(UnawareClientTest, TheRobotEndsTheMotion) {
  EXPECT_GT(Run(false).violations, 0);
}

INSTANTIATE_TEST_SUITE_P(
    InFlight, UnawareClientTest,
    ::testing::Values(std::tuple{1, false, Wish::kWild}, std::tuple{2, false, Wish::kWild},
                      std::tuple{1, false, Wish::kSmooth}, std::tuple{2, false, Wish::kSmooth},
                      std::tuple{1, true, Wish::kWild}, std::tuple{2, true, Wish::kWild},
                      std::tuple{2, true, Wish::kSmooth}),
    NameOf);

}  // namespace
}  // namespace twin::reference::reference_late_client_test
