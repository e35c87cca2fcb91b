#include "campaign/goal_world.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "campaign/lab_rules.h"
#include "campaign/rare_things.h"
#include "campaign/world.h"
#include "conformance/dice.h"
#include "conformance/reference_rules.h"
#include "twin/backend/registry.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/onboard/goal_approach.h"
#include "twin/run/robot_config.h"
#include "twin/scenario/robot_data.h"

namespace twin::campaign {
namespace {

using scenario::Scenario;
using test::Dice;

constexpr double kArrived = 1e-3;     ///< rad
constexpr double kInRange = 0.02;     ///< rad, from where a joint can no longer move to its end
constexpr int kStartCycles = 100;     ///< until a motion shows, and until a command has arrived
constexpr int kBrakeCycles = 1000;    ///< from the largest velocity to rest
constexpr double kSlowestPart = 5.0;  ///< s, of a way: its begin and its end

/// Without an application, people or what could be touched. A Panda takes streams only.
Scenario DrawRobot(Dice& dice, std::uint64_t seed) {
  Scenario world = DrawWorld(seed);
  world.robot.model = dice.Chance(0.3) ? "panda" : "fr3";
  world.robot.q_start = kReady;
  world.motion = {};
  world.robot.hand = plant::HandKind::kFrankaHand;
  world.hand.clear();
  world.panel.clear();
  world.onboard.filters = {};
  world.objects.clear();
  world.base.reset();
  world.limits = {};
  world.plant.armature = true;
  world.onboard.collision_behavior = scenario::NoCollisionBehavior();
  return world;
}

/// Limits of a lab that INT keeps by itself; most goals lie beyond them, and where the arm begins
/// does not.
model::LabLimits DrawGuard(Dice& dice) {
  model::LabLimits guard;
  if (!dice.Chance(0.4)) return guard;
  if (dice.Chance(0.3)) guard.v_max = dice.Between(0.3, 2);
  if (dice.Chance(0.3)) guard.w_max = dice.Between(0.5, 3);
  if (dice.Chance(0.3)) guard.dq_max.emplace().fill(dice.Between(0.3, 2.6));
  if (dice.Chance(0.6)) {
    const double reach = dice.Between(0.5, 0.9);
    guard.regions.push_back(
        {.name = "room",
         .shape = model::LimitBox{{-reach, -reach, -0.1}, {reach, reach, dice.Between(0.8, 1.2)}}});
  }
  if (dice.Chance(0.4)) {
    guard.regions.push_back(
        {.name = "wall",
         .shape = model::HalfSpace{{dice.Between(-1, 1), 1, 0}, dice.Between(0.4, 0.8)}});
  }
  return guard;
}

class GoalWorld final : private rt::EventHandler, private record::RecordSink {
 public:
  GoalWorld(std::uint64_t seed, const run::Catalogue& catalogue, const run::RunFiles& files)
      : dice_(~seed),
        stream_dice_(~seed ^ (std::uint64_t{1} << 51)),
        robot_dice_(~seed ^ (std::uint64_t{1} << 52)),
        world_(DrawRobot(robot_dice_, seed)),
        data_(scenario::LoadRobotData(files.models, world_.robot.model, world_.robot.hand)),
        guard_(DrawGuard(dice_)),
        config_(WithGuard(run::MakeRobotConfig(world_, data_, files), guard_)),
        connection_(catalogue.backends.Find("mujoco")(
            {config_, backend::VirtualTime{events_, *this}, this})) {}

  Outcome Run() {
    Outcome outcome;
    Pass(1);
    for (int motions = dice_.Whole(1, 3); motions > 0 && !finding_; --motions) {
      if (last_.robot_mode == RobotMode::kIdle) Move();
    }
    outcome.end = "goals";
    if (finding_) finding_->text += fmt::format("; after: {}", fmt::join(done_, ", "));
    outcome.finding = std::move(finding_);
    outcome.cycles = cycles_;
    outcome.states_hash = hash_.value();
    return outcome;
  }

 private:
  static robot::RobotConfig WithGuard(robot::RobotConfig config, const model::LabLimits& guard) {
    config.onboard.guard = guard;
    return config;
  }

  [[nodiscard]] bool IsIdeal() const { return world_.plant.kind == robot::PlantKind::kIdeal; }
  [[nodiscard]] bool Loses() const {
    return world_.link.command.loss != scenario::Loss() ||
           world_.link.state.loss != scenario::Loss();
  }

  void Note(std::string_view invariant, const test::Finding& finding) {
    if (finding && !finding_) finding_ = Finding{invariant, *finding};
  }

  // --- The robot

  void OnEvent(Time, std::uint64_t) noexcept override {
    Time arrival{};
    static_cast<void>(connection_.backend->Read(backend::ReadRule::kNewest, read_, arrival));
  }

  void Put(const record::TickRecord&) noexcept override {}

  void Put(const record::CycleRecord& record) noexcept override {
    const RobotState& state = record.state;
    Note("finite", test::FindNotFinite(state));
    if (cycles_++ > 0) CheckStep(record);
    hash_.AddNumbers(state.q_d.data(), kJoints);
    last_ = state;
  }

  void CheckStep(const record::CycleRecord& record) {
    const RobotState& state = record.state;
    if (state.message_id != last_.message_id + 1) {
      Note("ids", fmt::format("state {} follows state {}", state.message_id, last_.message_id));
    }
    has_losses_ = has_losses_ || record.lost_in_row != 0;
    if (record.violated) CheckError(record);
    Note("guard", FindBeyondLab(state, guard_, config_.onboard.guard_has_hand));
    const bool moves = last_.robot_mode == RobotMode::kMove && state.robot_mode == RobotMode::kMove;
    if (!moves) return;
    Note("reference", test::FindBrokenDifferences(last_, state));
    const JointLimits& limits = is_stream_ ? config_.onboard.limits : data_.limits;
    Note("reference", test::FindBeyondLimits(last_, state, limits));
    if (is_stream_) return;
    if (record.lost_in_row != 0) {
      Note("holds", fmt::format("cycle {}: {} lost of a motion to goals", state.message_id,
                                record.lost_in_row));
    }
    for (std::size_t i = 0; i < kJoints; ++i) {
      if (std::abs(state.dq_d[i]) <= dq_most_[i] * (1 + 1e-9)) continue;
      Note("reference", fmt::format("cycle {}: joint {} at {} rad/s, and the client allows {}",
                                    state.message_id, i + 1, state.dq_d[i], dq_most_[i]));
    }
  }

  void CheckError(const record::CycleRecord& record) {
    const RobotError error = record.violation.error;
    if (has_losses_) return;  // which may end a stream in many ways
    was_refused_ = error == RobotError::kJointMotionGeneratorPositionLimitsViolation;
    if (was_refused_ && is_beyond_) return;
    // Where the arm is and how fast it moves together may end any motion, and so may its body.
    if (!Name(error).starts_with("joint_motion_generator")) return;
    Note("errors", fmt::format("cycle {}: {}", record.state.message_id, Name(error)));
  }

  void Pass(int cycles) {
    for (const std::uint64_t end = cycles_ + static_cast<std::uint64_t>(cycles);
         cycles_ < end && !finding_ && events_.RunNext();) {
    }
  }

  template <typename Condition>
  bool PassUntil(int most, Condition holds) {
    for (; most > 0 && !finding_; --most) {
      if (holds()) return true;
      Pass(1);
    }
    return false;
  }

  // --- The client

  void Move() {
    for (std::size_t i = 0; i < kJoints; ++i) {
      dq_most_[i] = data_.limits.dq_max[i] * dice_.Between(0.05, 1.2);
    }
    is_stream_ = stream_dice_.Chance(0.3) || world_.robot.model == "panda";
    done_.emplace_back(is_stream_ ? "stream" : "motion");
    is_beyond_ = was_refused_ = has_losses_ = false;
    MotionModes modes;
    if (is_stream_ && robot_dice_.Chance(0.3)) {
      modes.generator = MotionGeneratorMode::kJointVelocity;
    }
    if (!is_stream_) modes.asynchronous = dq_most_;
    connection_.backend->Start(modes);
    const bool is_seen = PassUntil(kStartCycles, [&] { return IsMoving(); });
    // An arm that was stopped before it met itself is still where it was.
    if (last_.robot_mode == RobotMode::kReflex) return;
    if (!is_seen) {
      return Note("session", "a started motion does not show in a state");
    }
    begun_ = last_.message_id;
    if (is_stream_) return Stream();
    Pass(dice_.Whole(0, 300));
    for (int goals = dice_.Whole(1, 6); goals > 0 && IsMoving(); --goals) {
      Send(DrawGoal());
      Pass(dice_.Chance(0.5) ? dice_.Whole(1, 100) : dice_.Whole(100, 2000));
    }
    if (IsMoving() && dice_.Chance(0.3)) Arrive();
    if (IsMoving() && dice_.Chance(0.1)) return GoBeyond();
    if (IsMoving()) return End();
    Recover();
  }

  /// The client itself makes the way to its goals, by the states that it reads.
  void Stream() {
    for (int goals = stream_dice_.Whole(1, 4); goals > 0; --goals) {
      const JointVector goal = DrawGoal();
      for (int cycles = stream_dice_.Whole(100, 1500); cycles > 0 && IsMoving(); --cycles) {
        RobotCommand command;
        command.message_id = read_.message_id;
        const auto next = onboard::ApproachStep({read_.q_d, read_.dq_d, read_.ddq_d, {}}, goal,
                                                dq_most_, data_.limits);
        command.q_c = next.q_d;
        command.dq_c = next.dq_d;
        connection_.backend->Write(command);
        Pass(1);
      }
    }
    if (stream_dice_.Chance(0.5)) connection_.backend->Stop();  // else its silence ends the motion
    if (!PassUntil(kBrakeCycles, [&] { return last_.robot_mode != RobotMode::kMove; })) {
      return Note("session", "a stream that ended is still a motion");
    }
    if (last_.robot_mode == RobotMode::kReflex) Recover();
  }

  [[nodiscard]] bool IsMoving() const { return last_.robot_mode == RobotMode::kMove && !finding_; }

  JointVector DrawGoal() {
    JointVector goal = last_.q_d;
    const bool is_near = dice_.Chance(0.3);
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double room = kInRange + data_.limits.StillZone(i);
      const double least = data_.limits.q_min[i] + room;
      const double most = data_.limits.q_max[i] - room;
      goal[i] = is_near ? std::clamp(goal[i] + dice_.Between(-0.1, 0.1), least, most)
                        : dice_.Between(least, most);
    }
    return goal;
  }

  /// As many times as a client likes, for any state of the motion that it has read.
  void Send(const JointVector& goal) {
    done_.emplace_back("goal");
    RobotCommand command;
    command.q_c = goal;
    for (int times = dice_.Chance(0.2) ? dice_.Whole(2, 5) : 1; times > 0; --times) {
      const std::uint64_t newest = std::max(read_.message_id, begun_);
      const auto back = static_cast<std::uint64_t>(dice_.Chance(0.3) ? dice_.Whole(0, 100) : 0);
      command.message_id = std::max(begun_, newest - std::min(newest, back));
      connection_.backend->Write(command);
      if (dice_.Chance(0.3)) Pass(1);
    }
  }

  /// Tells the last goal until it is reached.
  void Arrive() {
    done_.emplace_back("arrive");
    const JointVector goal = DrawGoal();
    double longest = 0;
    for (std::size_t i = 0; i < kJoints; ++i) {
      longest = std::max(longest, std::abs(goal[i] - last_.q_d[i]) / dq_most_[i]);
    }
    const auto is_there = [&] {
      return std::ranges::equal(last_.q_d, goal,
                                [](double a, double b) { return std::abs(a - b) <= kArrived; });
    };
    for (double left = 2 * longest + kSlowestPart; left > 0 && !is_there(); left -= 0.1) {
      if (!IsMoving()) return;
      Send(goal);
      Pass(100);
    }
    if (!is_there() && IsMoving()) {
      Note("finish", fmt::format("a goal is not reached: {} for {}", fmt::join(last_.q_d, ", "),
                                 fmt::join(goal, ", ")));
    }
  }

  void GoBeyond() {
    done_.emplace_back("goal beyond");
    JointVector goal = last_.q_d;
    const auto joint = static_cast<std::size_t>(dice_.Whole(0, kJoints - 1));
    const double by = dice_.Between(1e-6, 1);
    goal[joint] =
        dice_.Chance(0.5) ? data_.limits.q_max[joint] + by : data_.limits.q_min[joint] - by;
    is_beyond_ = true;
    Send(goal);
    Pass(kStartCycles);
    if (!was_refused_ && IsMoving() && !Loses()) {
      Note("specification", "a goal beyond a joint's range is taken");
    }
    IsMoving() ? End() : Recover();
  }

  void End() {
    const bool finishes = dice_.Chance(0.7);
    done_.emplace_back(finishes ? "finish" : "stop");
    if (!finishes) connection_.backend->Stop();
    RobotCommand last;
    last.motion_generation_finished = true;
    for (int i = 0; i < kBrakeCycles && IsMoving(); ++i) {
      last.message_id = std::max(read_.message_id, begun_);
      if (finishes) connection_.backend->Write(last);
      Pass(1);
    }
    if (finding_) return;
    const auto end = connection_.backend->Describe().last_end;
    const auto expected = finishes ? backend::MotionEnd::kSuccess : backend::MotionEnd::kPreempted;
    if (end == backend::MotionEnd::kAborted) return Recover();  // by what the body measured
    if (last_.robot_mode == RobotMode::kIdle && end == expected) return;
    Note("finish", fmt::format("a motion that should end with {} is in mode {}, its end {}",
                               NameOf(expected), Name(last_.robot_mode), NameOf(end)));
  }

  void Recover() {
    if (finding_) return;
    done_.emplace_back("recovery");
    std::string why;
    const auto recovers = [&] {
      try {
        connection_.backend->Recover();
      } catch (const RobotFault& fault) {  // it has not come to rest
        why = fault.what();
        return false;
      }
      return true;
    };
    if (!PassUntil(2 * kBrakeCycles, recovers) && IsIdeal()) return Note("session", why);
    PassUntil(kBrakeCycles, [&] { return last_.robot_mode == RobotMode::kIdle; });
  }

  Dice dice_;
  Dice stream_dice_;  ///< so that motions to goals do not depend on streams
  Dice robot_dice_;   ///< nor either on the robot
  const Scenario world_;
  const scenario::RobotData data_;
  const model::LabLimits guard_;
  const robot::RobotConfig config_;
  rt::EventQueue events_;
  backend::Connection connection_;
  std::optional<Finding> finding_;
  std::vector<std::string> done_;
  RobotState last_;  ///< that the robot sent
  RobotState read_;  ///< that the client read
  std::uint64_t cycles_ = 0;
  WordHash hash_;
  JointVector dq_most_{};     ///< that the client allows, rad/s
  std::uint64_t begun_ = 0;   ///< id of the motion's first state
  bool is_stream_ = false;    ///< the motion is not one to goals
  bool has_losses_ = false;   ///< of commands in this motion
  bool is_beyond_ = false;    ///< the client sent a goal beyond the range
  bool was_refused_ = false;  ///< INT found it
};

}  // namespace

bool IsGoalWorld(std::uint64_t seed) {
  return seed % 64 == 44;
}

Outcome RunGoalWorld(std::uint64_t seed, const run::Catalogue& catalogue,
                     const run::RunFiles& files) {
  try {
    return GoalWorld(seed, catalogue, files).Run();
  } catch (const InputError& error) {
    Outcome refused;
    refused.refusal = error.what();
    return refused;
  } catch (const Error& error) {
    Outcome failed;
    failed.finding = Finding{"errors", error.what()};
    return failed;
  }
}

}  // namespace twin::campaign
