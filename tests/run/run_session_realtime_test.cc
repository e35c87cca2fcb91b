// Sessions whose time is not virtual: in this process on the wall clock, and over the wire.

#include <chrono>
#include <memory>
#include <string_view>

#include <gtest/gtest.h>

#include "run/session_fixture.h"
#include "support/undisturbed.h"

namespace twin::run::run_session_realtime_test {
namespace {

enum class Place : std::uint8_t { kInProcess, kServedOnTheWallClock, kServedInLockstep };

class SessionRealtimeTest : public test::SessionFixture,
                            public ::testing::WithParamInterface<Place> {
 protected:
  /// A scenario of moderate speed: states out of time must break no limit.
  [[nodiscard]] static scenario::Scenario Slow() {
    scenario::Scenario scenario = test::Standing();
    scenario.link = scenario::LinkSection();
    scenario.link.d_INT = Duration::zero();
    scenario.motion.timing.velocity_scale = 0.05;
    scenario.motion.timing.acceleration_scale = 0.02;
    scenario.motion.timing.jerk_scale = 0.02;
    return scenario;
  }

  /// One attempt: a robot, a session on it, and what is done there.
  template <typename Do>
  void Attempt(Do act) {
    scenario::Scenario scenario = Slow();
    RealtimeConfig settings;
    std::unique_ptr<server::ServedRobot> served;
    if (GetParam() == Place::kInProcess) {
      scenario.drive = scenario::Drive::kRealtime;
    } else {
      const auto time = GetParam() == Place::kServedInLockstep ? backend::RobotTime::kStates
                                                               : backend::RobotTime::kWall;
      served = Serve(scenario, time);
      scenario.backend = "fci";
      settings.remote = {.host = "127.0.0.1", .arm_port = served->arm().port, .time = time};
      settings.checks_start = false;
    }
    const auto session = Open(scenario, nullptr, settings);
    session->Begin();
    act(*session, scenario);
    static_cast<void>(session->End());
  }

  /// It bears all losses but those that end a motion. A twin in lockstep waits.
  template <typename Do>
  void AttemptUndisturbed(Do act) {
    const std::int64_t needed =
        GetParam() == Place::kServedInLockstep ? test::kNothingExcuses : test::kEndsAMotion;
    test::Undisturbed([&] { Attempt(act); }, [needed] { return needed; }, test::ByWitness(98), 5);
  }
};

TEST_P(SessionRealtimeTest, RunsAMotionAHandCommandAndAMotionFromThere) {
  AttemptUndisturbed([this](Session& session, const scenario::Scenario& scenario) {
    GoThereAndBack(session, scenario);
  });
}

TEST_P(SessionRealtimeTest, GoesOnAfterAReflexOnceRecovered) {
  AttemptUndisturbed([this](Session& session, const scenario::Scenario& scenario) {
    FailAndRecover(session, scenario);
  });
}

INSTANTIATE_TEST_SUITE_P(All, SessionRealtimeTest,
                         ::testing::Values(Place::kInProcess, Place::kServedOnTheWallClock,
                                           Place::kServedInLockstep),
                         [](const auto& place) {
                           switch (place.param) {
                             case Place::kInProcess: return "InProcess";
                             case Place::kServedOnTheWallClock: return "ServedOnTheWallClock";
                             case Place::kServedInLockstep: return "ServedInLockstep";
                           }
                           return "";
                         });

}  // namespace
}  // namespace twin::run::run_session_realtime_test
