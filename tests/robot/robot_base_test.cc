#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "robot/robot_fixture.h"
#include "support/husky.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::robot::robot_base_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr double kDegree = std::numbers::pi / 180;

/// A drive of a quarter of a minute at most: the robot, where its base really is, and its records.
class Ride : public record::RecordSink {
 public:
  explicit Ride(const BasePose& start = {}) {
    RobotConfig config = test::PandaRobot();
    config.plant.base = test::Husky(start);
    config.base = test::HuskyConfig();
    auto plant = plant::MujocoPlant::Create(config.plant);
    plant_ = plant.get();
    robot_ = std::make_unique<Robot>(config, std::move(plant), events_, deaf_, this);
    robot_->Begin();
  }

  /// Lets time pass. @param twist  asked for every 50 ms; nothing: nobody asks.
  void Go(Duration span, const std::optional<BaseTwist>& twist) {
    const Time end = events_.Now() + span;
    for (Time next = events_.Now(); next < end;) {
      if (twist) base().Drive(*twist);
      next = std::min(end, next + milliseconds(50));
      while (*events_.NextTime() <= next) events_.RunNext();
      events_.AdvanceTo(next);
    }
  }

  /// Lets time pass until the base stands. @returns how long that took; gives up after 10 s.
  Duration GoToStand() {
    const Time begin = events_.Now();
    while (!StandsStill() && events_.Now() < begin + seconds(10)) Go(kCycle, std::nullopt);
    return events_.Now() - begin;
  }

  struct Kept {
    rt::EventQueue events;
    Robot::Snapshot robot;
  };
  [[nodiscard]] Kept Save() { return {events_, robot_->Save()}; }
  void Restore(const Kept& kept) {
    events_ = kept.events;
    robot_->Restore(kept.robot);
  }

  [[nodiscard]] BaseUnit& base() { return *robot_->base(); }
  [[nodiscard]] Robot& robot() { return *robot_; }
  [[nodiscard]] BasePose Truth() const {
    const int body = mj_name2id(&plant_->model(), mjOBJ_BODY, "husky_base_link");
    const double* p = plant_->data().xpos + 3 * body;
    const double* R = plant_->data().xmat + 9 * body;
    return {p[0], p[1], std::atan2(R[3], R[0])};
  }
  [[nodiscard]] double Speed() const { return std::hypot(velocity()[0], velocity()[1]); }
  [[nodiscard]] bool StandsStill() const {
    return Speed() < 1e-3 && std::abs(velocity()[5]) < 1e-3;
  }

  std::vector<BaseState> states;
  double arm_way = 0;    ///< most the end effector went away from where it was, in O, m
  double top_speed = 0;  ///< m/s
  bool violated = false;

 private:
  [[nodiscard]] const double* velocity() const { return plant_->data().qvel; }

  void Put(const record::CycleRecord& record) noexcept override {
    states.push_back(*record.base);
    if (!first_) first_ = record.state.O_T_EE;
    double square = 0;
    for (std::size_t i = 12; i < 15; ++i) {
      square += std::pow(record.state.O_T_EE[i] - (*first_)[i], 2);
    }
    arm_way = std::max(arm_way, std::sqrt(square));
    top_speed = std::max(top_speed, Speed());
    violated = violated || record.violated;
  }
  void Put(const record::TickRecord&) noexcept override {}

  rt::EventQueue events_;
  test::Deaf deaf_;
  plant::MujocoPlant* plant_ = nullptr;
  std::unique_ptr<Robot> robot_;
  std::optional<Transform> first_;
};

TEST(RobotBaseTest, GoesTwoMetresStraight) {
  Ride ride;
  ride.Go(seconds(4), BaseTwist{0.5, 0});  // 0.25 m to speed, 1.5 m, and 0.25 m to a stand
  ride.Go(seconds(2), BaseTwist{});
  const BasePose truth = ride.Truth();
  RecordProperty("x_mm", std::to_string(truth.x * 1e3));
  EXPECT_NEAR(truth.x, 2, 0.005) << "a quarter of a per cent";
  EXPECT_NEAR(truth.y, 0, 0.005);
  EXPECT_NEAR(truth.yaw, 0, 0.2 * kDegree);
  EXPECT_NEAR(ride.base().state().odometry.x, truth.x, 0.002) << "a tenth of a per cent";
}

TEST(RobotBaseTest, TurnsAQuarter) {
  Ride ride;
  const auto turning =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(std::numbers::pi));
  ride.Go(turning, BaseTwist{0, 0.5});  // with what it takes to speed and back: pi / 2
  ride.Go(seconds(2), BaseTwist{});
  const BasePose truth = ride.Truth();
  const BasePose odometry = ride.base().state().odometry;
  RecordProperty("yaw_deg", std::to_string(truth.yaw / kDegree));
  RecordProperty("moved_mm", std::to_string(1e3 * std::hypot(truth.x, truth.y)));
  EXPECT_NEAR(truth.yaw, 90 * kDegree, 1 * kDegree);
  EXPECT_NEAR(odometry.yaw, truth.yaw, 1 * kDegree);
  EXPECT_LT(std::hypot(truth.x, truth.y), 0.03) << "it turns about a point near its middle";
}

TEST(RobotBaseTest, TurnsBackAsItTurned) {
  Ride ride;
  ride.Go(seconds(2), BaseTwist{0, 0.8});
  ride.Go(seconds(2), BaseTwist{});
  const double there = ride.Truth().yaw;
  ride.Go(seconds(2), BaseTwist{0, -0.8});
  ride.Go(seconds(2), BaseTwist{});
  EXPECT_GT(there, 60 * kDegree);
  EXPECT_NEAR(ride.Truth().yaw, 0, 2 * kDegree);
}

TEST(RobotBaseTest, IsNoFasterThanItMay) {
  Ride ride;
  ride.Go(seconds(3), BaseTwist{7, 0});
  EXPECT_NEAR(ride.top_speed, 1, 0.02);
}

TEST(RobotBaseTest, SpeedsUpAsItMay) {
  Ride ride;
  ride.Go(seconds(2), BaseTwist{7, 0});
  double most = 0;
  for (std::size_t k = 1; k < ride.states.size(); ++k) {
    most = std::max(most, ride.states[k].twist_d.v - ride.states[k - 1].twist_d.v);
  }
  EXPECT_NEAR(most / kCycleSeconds, test::HuskyConfig().ordinary.dv, 1e-9);
}

TEST(RobotBaseTest, StopsWhenNobodyAsksAnyMore) {
  Ride ride;
  ride.Go(seconds(4), BaseTwist{1, 0});  // the last command is 50 ms old
  const double from = ride.Truth().x;
  const Duration took = ride.GoToStand();
  const double way = ride.Truth().x - from;
  RecordProperty("ms", std::to_string(took / milliseconds(1)));
  RecordProperty("way_mm", std::to_string(way * 1e3));
  // 0.15 s at 1 m/s, then 1 m/s^2.
  EXPECT_NEAR(ToSeconds(took), 0.15 + 1, 0.15);
  EXPECT_NEAR(way, 0.15 + 0.5, 0.05);
  EXPECT_EQ(ride.base().state().mode, BaseMode::kStanding);
  EXPECT_FALSE(ride.violated) << "the arm takes that for no collision";
}

TEST(RobotBaseTest, StopsAtOnceInAnEmergency) {
  Ride ride;
  ride.Go(seconds(4), BaseTwist{1, 0});
  const double from = ride.Truth().x;
  ride.base().EmergencyStop();
  const Duration took = ride.GoToStand();
  const double way = ride.Truth().x - from;
  RecordProperty("ms", std::to_string(took / milliseconds(1)));
  RecordProperty("way_mm", std::to_string(way * 1e3));
  // 3 m/s^2.
  EXPECT_NEAR(ToSeconds(took), 1.0 / 3, 0.15);
  EXPECT_NEAR(way, 1.0 / 6, 0.04);
  EXPECT_EQ(ride.base().state().mode, BaseMode::kEmergencyStop);
  EXPECT_TRUE(ride.violated) << "at 3 m/s^2 the arm's inertia looks like a collision to INT";
}

TEST(RobotBaseTest, StandsAfterAnEmergencyUntilItIsAskedAgain) {
  Ride ride;
  ride.base().EmergencyStop();
  ride.Go(seconds(1), BaseTwist{1, 0});
  ride.base().Release();
  ride.Go(seconds(1), std::nullopt);
  EXPECT_NEAR(ride.Truth().x, 0, 1e-4);
  ride.Go(seconds(1), BaseTwist{0.5, 0});
  EXPECT_GT(ride.Truth().x, 0.1);
}

TEST(RobotBaseTest, TheArmKeepsItsPoseOnIt) {
  Ride ride;
  ride.Go(seconds(2), BaseTwist{0.8, 0});
  ride.Go(seconds(2), BaseTwist{0.4, -1});
  ride.Go(seconds(2), BaseTwist{-0.5, 1});
  ride.Go(seconds(2), BaseTwist{});
  RecordProperty("arm_mm", std::to_string(ride.arm_way * 1e3));
  EXPECT_LT(ride.arm_way, 0.01);
  EXPECT_FALSE(ride.violated);
}

TEST(RobotBaseTest, DrivesTheSameEveryTime) {
  const auto drive = [] {
    Ride ride({0.3, 0.1, 0.4});
    ride.Go(seconds(1), BaseTwist{0.5, 0.7});
    ride.Go(seconds(1), BaseTwist{-0.2, -1});
    return ride.states;
  };
  EXPECT_EQ(drive(), drive());
}

TEST(RobotBaseTest, CyclesWithoutAllocationOrLock) {
  Ride ride;
  ride.states.reserve(5000);
  const test::RealtimeGuard guard;
  ride.Go(seconds(1), BaseTwist{0.5, 0.7});
  ride.base().EmergencyStop();
  ride.Go(seconds(1), std::nullopt);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
}

TEST(RobotBaseTest, TimeMayStandStillForABaseThatNeitherMovesNorIsAskedTo) {
  Ride ride;
  ride.Go(milliseconds(300), std::nullopt);
  EXPECT_TRUE(ride.base().AtRest());
  ride.base().Drive({0.2, 0});
  EXPECT_FALSE(ride.base().AtRest());
  ride.Go(milliseconds(300), std::nullopt);
  EXPECT_FALSE(ride.base().AtRest());
  (void)ride.GoToStand();
  ride.Go(seconds(1), std::nullopt);
  EXPECT_TRUE(ride.base().AtRest());
}

TEST(RobotBaseTest, GoesOnBitForBitFromASnapshot) {
  Ride ride;
  ride.Go(seconds(1), BaseTwist{0.6, 0.5});
  ride.base().Drive({-0.4, 0.9});  // takes effect in the next cycle
  const Ride::Kept driving = ride.Save();
  const auto go_on = [&ride] {
    ride.states.clear();
    ride.Go(seconds(1), std::nullopt);
    ride.base().EmergencyStop();
    ride.Go(milliseconds(200), BaseTwist{0.3, 0});
    return std::pair(ride.states, ride.Truth());
  };
  const auto [states, truth] = go_on();
  const Ride::Kept stopped = ride.Save();
  for (int again = 0; again < 2; ++again) {
    ride.Restore(driving);
    const auto [repeated, there] = go_on();
    EXPECT_EQ(repeated, states);
    EXPECT_EQ(there, truth);
  }
  ride.base().Release();
  ride.Restore(stopped);
  ride.states.clear();
  ride.Go(milliseconds(300), BaseTwist{0.3, 0});
  EXPECT_EQ(ride.states.back().twist_d, BaseTwist()) << "its emergency stop is pressed again";
}

TEST(RobotBaseTest, TheIdealPlantCarriesNone) {
  RobotConfig config = test::PandaRobot();
  config.plant.base = test::Husky();
  config.base = test::HuskyConfig();
  config.plant_kind = PlantKind::kIdeal;
  EXPECT_THROW(config.Validate(), InputError);
}

}  // namespace
}  // namespace twin::robot::robot_base_test
