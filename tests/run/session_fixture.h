#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "controllers/joint_trajectory.h"
#include "plugins/backends.h"
#include "twin/run/session.h"
#include "twin/server/served_robot.h"

namespace twin::test {

/// Where the arm rests at first, rad.
inline constexpr JointVector kRest{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};

/// The ideal plant with a hand, over a link with a little jitter; nothing to follow.
[[nodiscard]] inline scenario::Scenario Standing(std::string_view more = "") {
  scenario::Scenario scenario = scenario::Parse(std::string(R"(name: standing
plant: {kind: ideal}
link:
  state_delay: {log_normal: {median: 60 us, sigma: 0.4}}
  command_delay: {log_normal: {median: 60 us, sigma: 0.4}}
tick: {cost: {log_normal: {median: 13 us, sigma: 0.4}}}
controller: {clock_drift: 20 ppm, cost: {log_normal: {median: 60 us, sigma: 0.4}}}
motion:
  trajectory:
    unit: rad
    velocity_scale: 0.2
    acceleration_scale: 0.1
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
)") + std::string(more),
                                                "standing.yaml");
  return scenario;
}

/// Follows nothing: holds still for 100 ms, then asks for a step that no limit allows.
class Jumper final : public control::Controller {
 public:
  control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  void Activate(const RobotState& state, Time) override { q_ = state.q_d; }
  void Update(const RobotState&, Time, control::ControllerOutput& output) noexcept override {
    output.target.joint.q = q_;
    if (++updates_ > 100) output.target.joint.q[0] += 0.2;
  }
  void Deactivate() noexcept override {}

 private:
  JointVector q_{};
  int updates_ = 0;
};

/// Keeps the records that tell two runs apart.
class Log final : public record::RecordSink {
 public:
  Log() {
    cycles.reserve(100'000);
    targets.reserve(100'000);
  }
  void Put(const record::CycleRecord& record) noexcept override {
    if (cycles.size() < cycles.capacity()) cycles.push_back(record.state);
  }
  void Put(const record::TickRecord& record) noexcept override {
    ++ticks;
    const bool written = record.action == record::TickAction::kWritten;
    if (written && targets.size() < targets.capacity()) targets.push_back(record.q_ext[0]);
  }

  std::vector<RobotState> cycles;
  std::vector<double> targets;  ///< of joint 1, rad, where a command was written
  std::uint64_t ticks = 0;
};

/// A session's surroundings, on any drive.
class SessionFixture : public ::testing::Test {
 protected:
  SessionFixture() {
    plugins::RegisterMujoco(backends_);
    plugins::RegisterFci(backends_);
    controllers_.Add("joint_trajectory", [](const control::ControllerRequest& request) {
      controllers::JointTrajectoryOptions options;
      options.command_interface = request.interface;
      return std::make_unique<controllers::JointTrajectoryController>(request.trajectory, options);
    });
    controllers_.Add("jumper", [](const control::ControllerRequest& /*request*/) {
      return std::make_unique<Jumper>();
    });
  }

  [[nodiscard]] std::unique_ptr<run::Session> Open(const scenario::Scenario& scenario,
                                                   record::RecordSink* sink = nullptr,
                                                   const run::RealtimeConfig& settings = {}) const {
    return std::make_unique<run::Session>(scenario, run::Catalogue{backends_, controllers_}, files_,
                                          sink, settings);
  }

  /// A robot in this process, served at free ports; frozen when idle where states keep its time.
  [[nodiscard]] std::unique_ptr<server::ServedRobot> Serve(
      const scenario::Scenario& scenario, backend::RobotTime time,
      record::RecordSink* sink = nullptr) const {
    server::ServedRobotSettings settings{.takes_free_ports = true, .sink = sink};
    if (time == backend::RobotTime::kStates) settings.lockstep = {.freeze_when_idle = true};
    const robot::RobotConfig config = run::MakeServedConfig(scenario, files_);
    auto served = std::make_unique<server::ServedRobot>(config, robot::MakePlant(config),
                                                        std::move(settings));
    served->Start();
    return served;
  }

  /// Joint 1 by `angle`, from where the robot's reference is.
  [[nodiscard]] static run::Motion Turn(const JointVector& q, double angle,
                                        const run::Session& session,
                                        const scenario::Scenario& scenario, std::string name) {
    JointVector goal = q;
    goal[0] += angle;
    return {.name = std::move(name),
            .trajectory = reference::Trajectory({{.q = q}, {.q = goal}}, scenario.motion.timing,
                                                session.robot().limits),
            .controller = scenario.controller,
            .tick = scenario.tick,
            .loop = scenario.loop};
  }
  /// A motion that ends in a reflex.
  [[nodiscard]] static run::Motion Jump(const JointVector& q, const run::Session& session,
                                        const scenario::Scenario& scenario) {
    run::Motion jump = Turn(q, 0.1, session, scenario, "jump");
    jump.controller.type = "jumper";
    jump.tick.generator = loop::Generator::kNone;
    jump.tick.rate_matching = false;
    jump.tick.viability.reset();
    return jump;
  }

  /// There, the hand, and back: what holds on every drive.
  void GoThereAndBack(run::Session& session, const scenario::Scenario& scenario) {
    const run::MotionResult there = session.Move(Turn(kRest, 0.1, session, scenario, "there"));
    ASSERT_TRUE(there.report.succeeded()) << there.report.failure;
    const Time arrived = session.Now();
    const run::HandOutcome hand = session.Command(hand::Move{.width = 0.04, .speed = 0.1});
    EXPECT_EQ(hand.result, HandResult::kSuccess) << hand.failure;
    EXPECT_NEAR(hand.width, 0.04, 1e-3);
    EXPECT_GT(session.Now(), arrived);
    EXPECT_EQ(session.WaitForRest(), run::WaitEnd::kDone);
    const RobotState state = session.ReadState();
    EXPECT_NEAR(state.q_d[0], 0.1, 1e-3);
    const run::MotionResult back =
        session.Move(Turn(state.q_d, -state.q_d[0], session, scenario, "back"));
    ASSERT_TRUE(back.report.succeeded()) << back.report.failure;
    EXPECT_GT(back.begun, there.begun + there.report.simulated / 2);
    EXPECT_NEAR(back.report.q_final[0], 0, 1e-3);
  }

  /// A reflex, recovery, and a motion that works again.
  void FailAndRecover(run::Session& session, const scenario::Scenario& scenario) {
    const run::MotionResult jump = session.Move(Jump(kRest, session, scenario));
    ASSERT_EQ(jump.report.end, backend::MotionEnd::kAborted) << jump.report.failure;
    EXPECT_EQ(session.ReadState().robot_mode, RobotMode::kReflex);
    session.Recover();
    const RobotState state = session.ReadState();
    ASSERT_EQ(state.robot_mode, RobotMode::kIdle);
    const run::MotionResult again = session.Move(Turn(state.q_d, 0.05, session, scenario, "again"));
    EXPECT_TRUE(again.report.succeeded()) << again.report.failure;
  }

  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const run::RunFiles files_{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
};

}  // namespace twin::test
