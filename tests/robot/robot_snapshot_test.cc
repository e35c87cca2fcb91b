// A robot goes back to a snapshot with all that it consists of: random sessions with motions,
// reflexes, contact, the hand, switches and messages in flight repeat bit for bit.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "robot/robot_fixture.h"
#include "twin/core/random.h"
#include "twin/fci/datagrams.h"
#include "twin/plant/contact_watch.h"
#include "twin/plant/observers.h"
#include "twin/robot/answer_paced_robot.h"

namespace twin::robot::robot_snapshot_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// FNV-1a.
class Fingerprint {
 public:
  void Add(std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes) {
      hash_ = (hash_ ^ std::to_integer<std::uint64_t>(byte)) * 1099511628211u;
    }
  }
  template <typename T>
  void AddValues(const T* values, std::size_t count) {
    Add(std::as_bytes(std::span(values, count)));
  }
  [[nodiscard]] std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037u;
};

/// What a session went through.
struct Seen {
  int motions = 0;
  int reflexes = 0;
  int switches = 0;
  int hand_commands = 0;
  int placed = 0;
  int refused_places = 0;
};

/// A workstation and a person that act at random. A value: a copy goes on as the original does.
class Actor {
 public:
  /// Between two cycles.
  void Act(Robot& robot, int box) {
    ++cycle_;
    const RobotMode mode = robot.mode();
    if (mode == RobotMode::kReflex && last_mode_ != RobotMode::kReflex) ++seen.reflexes;
    last_mode_ = mode;
    if (mode == RobotMode::kIdle && Draw(0) < 0.03) BeginMotion(robot);
    if (mode == RobotMode::kReflex && Draw(1) < 0.02) {
      static_cast<void>(robot.AutomaticErrorRecovery());
    }
    Switch(robot, mode);
    if (Draw(4) < 0.003) Configure(robot);
    if (Draw(5) < 0.004) Grip(robot);
    if (Draw(6) < 0.004) Place(robot, box);
  }

  /// The answer to a state that has arrived.
  void Answer(Robot& robot, const RobotState& state) {
    const bool in_motion = state.motion_generator_mode != MotionGeneratorMode::kIdle;
    if (!in_motion || !leads_) begin_ = state;
    leads_ = in_motion;
    if (!in_motion || Draw(7) < 0.01) return;
    RobotCommand command;
    command.message_id = state.message_id;
    const double t = static_cast<double>(state.message_id - begin_.message_id) * kCycleSeconds;
    constexpr double kOmega = 2 * std::numbers::pi * 0.4;
    command.q_c = begin_.q_d;
    for (const std::size_t i : {0, 3, 5}) {
      command.q_c[i] += 0.15 * (1 - std::cos(kOmega * t));
      command.dq_c[i] = 0.15 * kOmega * std::sin(kOmega * t);
    }
    if (Draw(8) < 0.001) command.q_c[1] += 0.1;  // and a reflex
    if (Draw(8) < 0.001) command.dq_c[1] += 0.5;
    command.motion_generation_finished = Draw(9) < 0.002;
    robot.Send(command);
  }

  Seen seen{};

 private:
  [[nodiscard]] double Draw(std::uint32_t what) const { return random_.Uniform(cycle_, what); }

  void BeginMotion(Robot& robot) {
    const MotionModes modes{
        Draw(2) < 0.5 ? ControllerMode::kJointImpedance : ControllerMode::kCartesianImpedance,
        Draw(3) < 0.5 ? MotionGeneratorMode::kJointPosition : MotionGeneratorMode::kJointVelocity};
    if (robot.Move(modes) == MoveStatus::kMotionStarted) ++seen.motions;
  }

  void Switch(Robot& robot, RobotMode mode) {
    const double u = Draw(10);
    const auto operate = [&](PanelAction action) {
      seen.switches += robot.Operate(action) ? 1 : 0;
    };
    if (mode == RobotMode::kUserStopped && u < 0.01) operate(PanelAction::kReleaseUserStop);
    if (mode == RobotMode::kGuiding && u < 0.01) operate(PanelAction::kReleaseGuidingButton);
    if (mode == RobotMode::kOther && u < 0.01) operate(PanelAction::kOpenBrakes);
    if (u > 0.9995) operate(PanelAction::kPressUserStop);
    if (u > 0.9985 && u <= 0.999) operate(PanelAction::kPressGuidingButton);
    if (u > 0.999 && u <= 0.9995) operate(PanelAction::kCloseBrakes);
  }

  void Configure(Robot& robot) {
    setting::CollisionBehavior behavior;
    behavior.upper_torque_nominal.fill(20 + 40 * Draw(11));
    behavior.upper_force_nominal.fill(20 + 60 * Draw(12));
    static_cast<void>(robot.Configure(behavior));
    static_cast<void>(robot.Configure(setting::Load{.m_load = 0.2 * Draw(13)}));
  }

  void Grip(Robot& robot) {
    const double u = Draw(14);
    const HandCommand command = u < 0.2   ? HandCommand(hand::Homing())
                                : u < 0.5 ? HandCommand(hand::Move{0.08 * Draw(15), 0.05})
                                : u < 0.9 ? HandCommand(hand::Grasp{0.05, 0.1, 60 * Draw(15) + 1})
                                          : HandCommand(hand::Stop());
    seen.hand_commands += robot.StartHand(command).ticket != 0 ? 1 : 0;
  }

  /// About the hand, and somewhat above.
  void Place(Robot& robot, int box) {
    Transform X_WB = kIdentityTransform;
    X_WB[12] = robot.state().O_T_EE[12] + 0.2 * (Draw(16) - 0.5);
    X_WB[13] = robot.state().O_T_EE[13] + 0.2 * (Draw(17) - 0.5);
    X_WB[14] = robot.state().O_T_EE[14] + 0.3 * (Draw(18) - 0.3);
    ++(robot.Place(box, X_WB) ? seen.refused_places : seen.placed);
  }

  Random random_{4711, RandomStream::kTest};
  std::uint64_t cycle_ = 0;
  RobotMode last_mode_ = RobotMode::kOther;
  RobotState begin_;  ///< before the motion's first command
  bool leads_ = false;
};

faults::DirectionConfig Rough() {
  faults::DirectionConfig direction;
  direction.delay = faults::DelayModel(faults::LogNormalDelay{
      .median = microseconds(150), .sigma = 0.6, .offset = microseconds(20)});
  direction.loss = faults::LossModel(
      faults::GilbertElliottLoss{.good_to_bad = 0.005, .bad_to_good = 0.3, .loss_bad = 0.8});
  direction.duplication = 0.05;
  direction.duplicate_delay = faults::DelayModel(faults::ConstantDelay{milliseconds(3)});
  direction.reordering = 0.03;
  direction.reorder_by = milliseconds(7);
  return direction;
}

/// All that a robot has, at once: hand, objects, noise, elastic joints, disturbances, a rough link,
/// a clock that drifts, switches by script.
RobotConfig Everything() {
  RobotConfig config = test::PandaRobot();
  config.plant.scene = TWIN_SOURCE_DIR "/models/scenes/table_box.xml";
  config.plant.hand = plant::HandKind::kFrankaHand;
  config.plant.elasticity = plant::ElasticityProfile::kStatic;
  config.plant.noise = {.q_rad = 1e-5, .dq_rad_per_s = 1e-4, .tau_J_Nm = 0.02};
  config.plant.perturbations = {
      plant::Push{
          .body = "panda_link4", .begin = milliseconds(300), .motion = 2, .force = {15, 9, 0}},
      plant::HandSpring{.body = "panda_hand", .begin = seconds(2), .by = {0, 0.05, 0.02}},
      plant::HandSpring{.body = "panda_hand",
                        .begin = milliseconds(50),
                        .motion = 5,
                        .duration = seconds(3),
                        .by = {0, -0.05, 0.02}}};
  config.link = {.state = Rough(), .command = Rough()};
  config.panel = {{milliseconds(1700), PanelAction::kPressUserStop},
                  {milliseconds(1900), PanelAction::kReleaseUserStop},
                  {milliseconds(4100), PanelAction::kPressUserStop},
                  {milliseconds(4300), PanelAction::kReleaseUserStop}};
  config.clock_ppm = 80;
  config.viability = 19;
  config.seed = 5;
  return config;
}

class Session final : public rt::EventHandler, public record::RecordSink {
 public:
  explicit Session(const RobotConfig& config) {
    auto plant = plant::MujocoPlant::Create(config.plant);
    engine_ = plant.get();
    box_ = plant::FreeBodyNamed(engine_->model(), "box");
    robot_ = std::make_unique<Robot>(config, std::move(plant), events_, *this, this);
    watch_ = std::make_unique<plant::ContactWatch>(*engine_);
    robot_->Begin();
  }

  struct Kept {
    rt::EventQueue events;
    Robot::Snapshot robot;
    Actor actor;
  };
  [[nodiscard]] Kept Save() { return {events_, robot_->Save(), actor_}; }
  void Restore(const Kept& kept) {
    events_ = kept.events;
    robot_->Restore(kept.robot);
    actor_ = kept.actor;
  }

  /// @returns a fingerprint of each cycle.
  std::vector<std::uint64_t> Run(std::size_t cycles) {
    cycles_.clear();
    while (cycles_.size() < cycles) Step();
    return cycles_;
  }
  /// Until messages are on the way in both directions or twice in one.
  void RunUntilMessagesFly() {
    while (events_.pending() < 4) Run(1);
  }
  /// Until a command is on the way that the next cycle may execute.
  void RunUntilACommandFlies() {
    do {
      command_flies_ = false;
      Step();
    } while (!command_flies_);
  }

  [[nodiscard]] const Seen& seen() const { return actor_.seen; }
  [[nodiscard]] RobotMode mode() const { return robot_->mode(); }
  [[nodiscard]] std::uint64_t touches() const { return watch_->cycles(); }

 private:
  /// Runs an event; the actor acts after each cycle.
  void Step() {
    const std::size_t before = cycles_.size();
    events_.RunNext();
    if (cycles_.size() > before) actor_.Act(*robot_, box_);
  }
  void OnEvent(Time, std::uint64_t) noexcept override {
    const std::size_t before = events_.pending();
    actor_.Answer(*robot_, robot_->states().Take());
    command_flies_ = events_.pending() > before;
  }
  void Put(const record::TickRecord&) noexcept override {}
  void Put(const record::CycleRecord& record) noexcept override {
    EXPECT_GT(record.at, last_at_) << "the times of records rise, whatever the robot goes back to";
    last_at_ = record.at;
    watch_->Look(record.at);
    Fingerprint print;
    fci::StateBytes bytes;
    fci::Encode(record.state, bytes);
    print.Add(bytes);
    print.AddValues(record.dddq_d.data(), record.dddq_d.size());
    const std::array<std::int64_t, 6> counts{static_cast<std::int64_t>(record.fate),
                                             record.lost_in_row,
                                             record.dropped,
                                             record.violated ? 1 : 0,
                                             events_.Now().time_since_epoch().count(),
                                             static_cast<std::int64_t>(events_.pending())};
    print.AddValues(counts.data(), counts.size());
    const HandState hand = robot_->hand_state();
    const std::array<double, 5> fingers{hand.width, hand.max_width, hand.is_grasped ? 1.0 : 0.0,
                                        static_cast<double>(hand.message_id),
                                        static_cast<double>(hand.temperature)};
    print.AddValues(fingers.data(), fingers.size());
    const mjData& data = engine_->data();
    const auto nv = static_cast<std::size_t>(engine_->model().nv);
    print.AddValues(data.qpos, static_cast<std::size_t>(engine_->model().nq));
    print.AddValues(data.qvel, nv);
    print.AddValues(data.qacc_warmstart, nv);
    print.AddValues(&data.time, 1);
    cycles_.push_back(print.hash());
  }

  rt::EventQueue events_;
  plant::MujocoPlant* engine_ = nullptr;
  std::unique_ptr<Robot> robot_;
  std::unique_ptr<plant::ContactWatch> watch_;
  Actor actor_;
  int box_ = 0;
  bool command_flies_ = false;
  std::vector<std::uint64_t> cycles_;
  Time last_at_{Duration(-1)};
};

/// @returns the first cycle in which two runs differ, or their length.
std::size_t Agreement(const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b) {
  return static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
}

TEST(RobotSnapshotTest, GoesOnBitForBitFromASnapshotEachTime) {
  constexpr std::size_t kCycles = 2500;
  Session session(Everything());
  std::vector<Session::Kept> kept;
  int in_motion = 0;
  for (int i = 0; i < 6; ++i) {
    session.Run(700);
    session.RunUntilMessagesFly();
    if (i % 2 == 1) session.RunUntilACommandFlies();
    in_motion += session.mode() == RobotMode::kMove ? 1 : 0;
    kept.push_back(session.Save());
    const std::vector<std::uint64_t> went_on = session.Run(kCycles);
    // Not only to the one just taken: from anywhere to anywhere.
    const Session::Kept& other = kept[static_cast<std::size_t>(i) / 2];
    for (int again = 0; again < 2; ++again) {
      session.Restore(other);
      session.Run(300);
      session.Restore(kept.back());
      ASSERT_EQ(Agreement(went_on, session.Run(kCycles)), kCycles) << "snapshot " << i;
    }
    session.Restore(kept.back());
  }
  session.Run(kCycles);
  const Seen& seen = session.seen();
  EXPECT_GE(in_motion, 1);
  EXPECT_GE(seen.motions, 5);
  EXPECT_GE(seen.reflexes, 3);
  EXPECT_GE(seen.switches, 4);
  EXPECT_GE(seen.hand_commands, 10);
  EXPECT_GE(seen.placed, 5);
  EXPECT_GE(seen.refused_places, 1);
  EXPECT_GT(session.touches(), 100u);
}

TEST(RobotSnapshotTest, TheIdealPlantGoesBackToo) {
  RobotConfig config = test::PandaRobot();
  config.plant_kind = PlantKind::kIdeal;
  config.plant.hand = plant::HandKind::kFrankaHand;
  rt::EventQueue events;
  test::Deaf deaf;
  Robot robot(config, MakePlant(config).plant, events, deaf, nullptr);
  robot.Begin();
  const auto run = [&] {
    while (events.Now() < Time(milliseconds(400))) events.RunNext();
  };
  static_cast<void>(robot.StartHand(hand::Move{0.02, 0.1}));
  while (events.Now() < Time(milliseconds(100))) events.RunNext();
  const rt::EventQueue queue = events;
  const Robot::Snapshot snapshot = robot.Save();
  run();
  const HandState hand = robot.hand_state();
  const std::uint64_t id = robot.state().message_id;
  events = queue;
  robot.Restore(snapshot);
  EXPECT_NE(robot.hand_state(), hand);
  EXPECT_EQ(robot.state().message_id, snapshot.message_id());
  run();
  EXPECT_EQ(robot.hand_state(), hand);
  EXPECT_EQ(robot.state().message_id, id);
}

/// A wire on which nothing comes.
class Unplugged final : public WorkstationPort, public rt::Arrival {
 public:
  bool Receive(ReceivedCommand&) noexcept override { return false; }
  void Deliver(const RobotState&) noexcept override {}
  bool AwaitUntil(Time) noexcept override {
    std::this_thread::sleep_for(microseconds(100));
    return false;
  }
};

// A client that has not asked yet would wait for ever otherwise.
TEST(RobotSnapshotTest, HowMotionsAndHandCommandsEndedIsToldAfterItAndAfterAResetToo) {
  RobotConfig config = test::PandaRobot();
  config.plant_kind = PlantKind::kIdeal;
  config.plant.hand = plant::HandKind::kFrankaHand;
  const MonotonicClock clock;
  Unplugged wire;
  AnswerPacedRobot robot(config, MakePlant(config).plant, wire, wire, clock,
                         {.name = "robot", .lock_memory = false}, nullptr, {});
  robot.Begin();
  const auto until = [](const auto& holds) {
    while (!holds()) std::this_thread::yield();
  };
  const auto move_hand = [&](double width) {
    const HandTicket ticket = robot.StartHand(hand::Move{width, 0.1}).ticket;
    until([&] { return robot.HandOutcome(ticket).has_value(); });
    return ticket;
  };
  until([&] { return robot.state().message_id > 0; });
  ASSERT_TRUE(robot.Save("new"));
  for (const bool restores : {false, true}) {
    ASSERT_EQ(robot.Move({}), MoveStatus::kMotionStarted);
    robot.StopMove();
    until([&] { return robot.mode() == RobotMode::kIdle; });
    const HandTicket aborted = robot.StartHand(hand::Move{0.05, 0.1}).ticket;
    const HandTicket ended = move_hand(0.02);
    ASSERT_TRUE(restores ? robot.Restore("new") : robot.Reset({}));
    EXPECT_EQ(robot.report().last_motion.end, MoveStatus::kPreempted);
    EXPECT_EQ(robot.last_motion().end, MoveStatus::kPreempted);
    EXPECT_GT(move_hand(0.03), ended);
    EXPECT_EQ(robot.HandOutcome(ended), HandResult::kSuccess);
    EXPECT_EQ(robot.HandOutcome(aborted), HandResult::kAborted);
    EXPECT_FALSE(robot.HandOutcome(ended + 9)) << "unknown";
  }
}

}  // namespace
}  // namespace twin::robot::robot_snapshot_test
