#include "report/tracking_error.h"

#include <gtest/gtest.h>

#include <vector>

namespace twin::report::report_tracking_error_test {
namespace {

/// State k is measured at 0.1 k at joint 3.
record::CycleRecord Cycle(std::uint64_t k, ControllerMode mode) {
  record::CycleRecord cycle;
  cycle.at = Time(kCycle * static_cast<std::int64_t>(k));
  cycle.state.message_id = k;
  cycle.state.controller_mode = mode;
  cycle.state.q[2] = 0.1 * static_cast<double>(k);
  cycle.state.q_d[2] = 7;
  return cycle;
}

/// The answer to state k wants 0.1 (k + 1) + 0.003 at joint 3.
record::TickRecord Tick(std::uint64_t k) {
  record::TickRecord tick;
  tick.message_id = k;
  tick.q_ext[2] = 0.1 * static_cast<double>(k + 1) + 0.003;
  return tick;
}

record::CycleRecord TorqueCycle(std::uint64_t k) {
  return Cycle(k, ControllerMode::kExternalController);
}

TEST(TrackingErrorTest, IsTheReferenceLessTheMeasurementOfTheSameCycle) {
  TrackingError tracking;
  const auto value = tracking.Add(Cycle(5, ControllerMode::kJointImpedance));
  ASSERT_TRUE(value);
  EXPECT_EQ(value->at, Time(5 * kCycle));
  EXPECT_EQ(value->error[2], 7 - 0.5);
  EXPECT_EQ(value->error[0], 0);
  EXPECT_FALSE(tracking.Add(Tick(5)));
  EXPECT_FALSE(tracking.by_torque());
}

TEST(TrackingErrorTest, GoesOnWhileTheArmComesToRest) {
  TrackingError tracking;
  EXPECT_FALSE(tracking.Add(Cycle(1, ControllerMode::kOther))) << "no motion yet";
  EXPECT_TRUE(tracking.Add(Cycle(2, ControllerMode::kJointImpedance)));
  EXPECT_TRUE(tracking.Add(Cycle(3, ControllerMode::kOther)));
  EXPECT_FALSE(tracking.Add(TorqueCycle(4)));
  EXPECT_FALSE(tracking.Add(Cycle(5, ControllerMode::kOther))) << "q_d was none of the motion's";
}

TEST(TrackingErrorTest, UnderTorquesComparesATargetWithTheCycleItActsIn) {
  TrackingError tracking;
  EXPECT_FALSE(tracking.Add(TorqueCycle(4)));
  EXPECT_FALSE(tracking.Add(Tick(4)));
  const auto value = tracking.Add(TorqueCycle(5));
  ASSERT_TRUE(value);
  EXPECT_EQ(value->at, Time(5 * kCycle));
  EXPECT_NEAR(value->error[2], 0.003, 1e-15);
  EXPECT_TRUE(tracking.by_torque());
}

TEST(TrackingErrorTest, GivesTheSameWhicheverSideComesFirst) {
  for (const std::uint64_t ahead : {1, 2, 128, 4000}) {
    TrackingError tracking;
    std::vector<Time> times;
    const auto take = [&](const std::optional<TrackingError::Value>& value) {
      if (!value) return;
      EXPECT_NEAR(value->error[2], 0.003, 1e-12);
      EXPECT_TRUE(times.empty() || times.back() < value->at);
      times.push_back(value->at);
    };
    for (std::uint64_t k = 1; k <= 10'000; ++k) {
      take(tracking.Add(TorqueCycle(k)));
      if (k > ahead) take(tracking.Add(Tick(k - ahead)));
    }
    EXPECT_EQ(times.size(), 10'000 - ahead) << ahead;
  }
}

TEST(TrackingErrorTest, LeavesOutWhatHasNoPartner) {
  TrackingError tracking;
  EXPECT_FALSE(tracking.Add(Tick(1)));
  EXPECT_FALSE(tracking.Add(TorqueCycle(3))) << "the answer to state 1 acts in cycle 2";
  EXPECT_FALSE(tracking.Add(TorqueCycle(2 + 4096))) << "another cycle in the same slot";
  record::TickRecord silent;
  silent.message_id = 2;
  EXPECT_FALSE(tracking.Add(silent)) << "no target";
}

}  // namespace
}  // namespace twin::report::report_tracking_error_test
