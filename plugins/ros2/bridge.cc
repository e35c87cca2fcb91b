#include "plugins/ros2/bridge.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "plugins/fci/fci_hand.h"
#include "plugins/ros2/arm_commander.h"
#include "plugins/ros2/conversions.h"
#include "plugins/ros2/franka_services.h"
#include "plugins/ros2/franka_state.h"
#include "plugins/ros2/gripper_action.h"
#include "plugins/ros2/hand_commander.h"
#include "plugins/ros2/joint_stream.h"
#include "plugins/ros2/robot_description.h"
#include "plugins/ros2/trajectory_action.h"
#include "twin/core/calendar_clock.h"
#include "twin/core/error.h"
#include "twin/rt/host_time.h"

namespace twin::ros2 {
namespace {

/// Between looks for new cycles.
constexpr twin::Duration kLook = kCycle;
/// Between looks at the hand: 30 Hz, as franka_gripper publishes.
constexpr twin::Duration kHandPeriod = std::chrono::milliseconds(33);
/// After a hand that did not answer, which may have taken a while.
constexpr twin::Duration kHandRetry = std::chrono::seconds(10);
/// Between repetitions of the last state while time stands.
constexpr twin::Duration kRepeat = std::chrono::milliseconds(50);
/// Stamps that lie farther behind the calendar follow it.
constexpr twin::Duration kMostBehind = std::chrono::milliseconds(100);

}  // namespace

class Bridge::Impl {
 public:
  Impl(const BridgeOptions& options, BridgedRobot robot, StateTap& tap);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  [[nodiscard]] std::string Introduction() const;

 private:
  void ServeArm();
  void ServeHand();
  void Run(const std::stop_token& stop);
  void Take(const record::CycleRecord& record);
  void FollowCalendar(Time at);
  void ReadHand(Time at);
  [[nodiscard]] std::optional<Lockstep> MakeLockstep();
  /// robot_joint_states. Threads: one at a time.
  void PublishForController(const RobotState& state, const msg::Time& stamp);
  /// A connection for a command, or the kept one.
  [[nodiscard]] std::shared_ptr<backend::Hand> ConnectHand();
  [[nodiscard]] msg::JointState JointsOf(const RobotState& state, bool with_fingers) const;
  [[nodiscard]] Time StampOf(Time at) const {
    return at + twin::Duration(origin_ns_.load(std::memory_order_relaxed));
  }
  [[nodiscard]] Time Now() const { return StampOf(tap_.last_at()); }

  const BridgeOptions options_;
  const BridgedRobot robot_;
  const JointNames names_;
  StateTap& tap_;
  const MonotonicClock clock_;
  const CalendarClock calendar_;
  std::atomic<std::int64_t> origin_ns_;  ///< of the robot's time, in the calendar's
  Node node_;
  std::unique_ptr<Publisher<msg::JointState>> joint_states_;
  std::unique_ptr<Publisher<msg::JointState>> robot_joint_states_;
  std::unique_ptr<Publisher<msg::Clock>> clock_topic_;  ///< null: another robot's bridge has it
  std::unique_ptr<Publisher<msg::String>> description_;
  std::mutex hand_mutex_;  ///< guards the next
  std::shared_ptr<plugins::FciHand> kept_hand_;
  std::unique_ptr<ArmCommander> arm_;
  std::unique_ptr<HandCommander> hand_;
  std::unique_ptr<JointStream> stream_;
  std::unique_ptr<TrajectoryAction> arm_action_;
  std::unique_ptr<FrankaArmServices> franka_arm_;
  std::unique_ptr<GripperAction> hand_action_;
  std::unique_ptr<FrankaHandActions> franka_hand_;
  std::unique_ptr<FrankaTopics> franka_topics_;
  std::unique_ptr<SimulationServices> simulation_;  ///< null: none
  std::unique_ptr<CameraTopics> cameras_;           ///< null: none
  // Of the publishing thread:
  Time hand_due_{};
  double width_ = 0;
  record::CycleRecord last_;  ///< in lockstep, as the next
  Time repeat_at_{};
  bool follows_calendar_;
  std::jthread thread_;
};

Bridge::Impl::Impl(const BridgeOptions& options, BridgedRobot robot, StateTap& tap)
    : options_(options),
      robot_(std::move(robot)),
      names_(NamesOf(options.joint_prefix)),
      tap_(tap),
      origin_ns_(options.lockstep_hz ? 0 : calendar_.Now().time_since_epoch().count()),
      node_(options.node),
      follows_calendar_(robot_.follows_wall_clock) {
  joint_states_ = node_.Advertise<msg::JointState>("joint_states", {});
  robot_joint_states_ = node_.Advertise<msg::JointState>("robot_joint_states", {.depth = 1});
  if (options_.has_clock) clock_topic_ = node_.Advertise<msg::Clock>("/clock", {.depth = 1});
  description_ =
      node_.Advertise<msg::String>("robot_description", {.is_latched = true, .depth = 1});
  const bool has_hand = robot_.client.robot.hand == plant::HandKind::kFrankaHand;
  const auto hand = robot_.data.urdf.parent_path() / ".." / "hand" / "hand.urdf";
  description_->Publish(
      {.data = DescriptionOf(robot_.data.urdf, has_hand ? hand : std::filesystem::path())});
  franka_topics_ = std::make_unique<FrankaTopics>(node_);
  ServeArm();
  if (has_hand) ServeHand();
  if (robot_.simulation) {
    simulation_ = std::make_unique<SimulationServices>(node_, *robot_.simulation,
                                                       [this] { return ToMessage(Now()); });
  }
  if (robot_.cameras) {
    cameras_ =
        std::make_unique<CameraTopics>(node_, *robot_.cameras, [this] { return ToMessage(Now()); });
  }
  node_.Announce();
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

Bridge::Impl::~Impl() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  cameras_.reset();
  node_.End();  // no handler runs any more
  arm_.reset();
  hand_.reset();
}

void Bridge::Impl::ServeArm() {
  arm_ = std::make_unique<ArmCommander>(
      ArmCommander::Parts{.catalogue = robot_.catalogue,
                          .files = robot_.files,
                          .client = robot_.client,
                          .settings = robot_.settings,
                          .states = robot_.keeps_connection ? &tap_ : nullptr,
                          .tell = options_.node.tell});
  arm_action_ = std::make_unique<TrajectoryAction>(
      node_, options_.arm_action, *arm_, names_, [this] { return Now(); },
      [this] {
        return stream_ && stream_->is_leading()
                   ? "the arm follows " + node_.Resolve("robot_joint_commands") +
                         "; end that, or disarm it by " + node_.Resolve("~/arm")
                   : std::string();
      });
  franka_arm_ =
      std::make_unique<FrankaArmServices>(node_, *arm_, [this] { return ToMessage(Now()); });
  stream_ = std::make_unique<JointStream>(
      JointStream::Parts{.arm = *arm_,
                         .names = names_,
                         .limits = robot_.data.limits,
                         .now = [this] { return Now(); },
                         .tell = [this](std::string_view line) { node_.Tell(line); },
                         .lockstep = MakeLockstep()});
  if (options_.arms) stream_->Arm();
  node_.Subscribe<msg::JointState>("robot_joint_commands", {.depth = 1},
                                   [this](const msg::JointState& message, const Guid& writer) {
                                     stream_->Put(message, writer);
                                   });
  node_.Serve<SetBool>("~/arm", [this](const SetBool::Request& request, const auto& reply) {
    if (!request.data) {
      stream_->Disarm();
      return reply({.success = true, .message = "disarmed"});
    }
    stream_->Arm();
    reply({.success = true, .message = "robot_joint_commands is armed"});
  });
  node_.Serve<Trigger>("~/recover", [this](const Trigger::Request&, const auto& reply) {
    Recover(*arm_, [reply](const std::string& why) {
      reply({.success = why.empty(), .message = why.empty() ? "the robot is Idle" : why});
    });
  });
}

std::optional<Lockstep> Bridge::Impl::MakeLockstep() {
  if (!options_.lockstep_hz) return std::nullopt;
  return Lockstep{.period_cycles = static_cast<int>(std::lround(1000 / *options_.lockstep_hz)),
                  .publish = [this](const RobotState& state) {
                    // The robot waits for the answer to this state: its last cycle's.
                    const Time stamp = StampOf(tap_.last_at());
                    PublishForController(state, ToMessage(stamp));
                    return stamp;
                  }};
}

void Bridge::Impl::PublishForController(const RobotState& state, const msg::Time& stamp) {
  if (!robot_joint_states_->has_readers()) return;
  msg::JointState joints = JointsOf(state, false);
  joints.header.stamp = stamp;
  robot_joint_states_->Publish(joints);
}

void Bridge::Impl::ServeHand() {
  hand_ = std::make_unique<HandCommander>([this] { return ConnectHand(); });
  hand_action_ = std::make_unique<GripperAction>(node_, options_.hand_action, *hand_,
                                                 [this] { return ToMessage(Now()); });
  franka_hand_ =
      std::make_unique<FrankaHandActions>(node_, *hand_, [this] { return ToMessage(Now()); });
}

std::shared_ptr<backend::Hand> Bridge::Impl::ConnectHand() {
  const backend::RobotAddress& at = robot_.settings.remote;
  const auto connect = [&at] {
    const auto port =
        at.hand_port != 0 ? at.hand_port : static_cast<std::uint16_t>(at.arm_port + 1);
    return std::make_shared<plugins::FciHand>(at.host, port, nullptr);
  };
  if (!robot_.keeps_connection) return connect();
  const std::lock_guard lock(hand_mutex_);
  if (!kept_hand_) kept_hand_ = connect();
  return kept_hand_;
}

std::string Bridge::Impl::Introduction() const {
  std::string text = fmt::format(
      "  ROS 2 domain {}, {}; topics {}, {}, /clock\n", options_.node.dds.domain,
      options_.node.dds.discovery == Discovery::kThisMachine
          ? "nodes of this machine (ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST)"
          : "nodes of EVERY machine of the network: each can move the robot, without a password",
      node_.Resolve("joint_states"), node_.Resolve("robot_description"));
  text += fmt::format("        actions {}", node_.Resolve(options_.arm_action));
  if (hand_) text += fmt::format(", {}", node_.Resolve(options_.hand_action));
  text += fmt::format(
      "\n        {} {}\n", node_.Resolve("robot_joint_commands"),
      options_.arms ? "is armed" : fmt::format("is not armed: call {}", node_.Resolve("~/arm")));
  return text;
}

msg::JointState Bridge::Impl::JointsOf(const RobotState& state, bool with_fingers) const {
  msg::JointState joints;
  joints.name.assign(names_.begin(), names_.end());
  joints.position = ToVector(state.q);
  joints.velocity = ToVector(state.dq);
  joints.effort = ToVector(state.tau_J);
  for (int finger = 1; with_fingers && finger <= 2; ++finger) {
    joints.name.push_back(fmt::format("{}{}", options_.finger_prefix, finger));
    joints.position.push_back(width_ / 2);
    joints.velocity.push_back(0);
    joints.effort.push_back(0);
  }
  return joints;
}

void Bridge::Impl::FollowCalendar(Time at) {
  if (robot_.simulation && robot_.simulation->is_paused && robot_.simulation->is_paused()) {
    follows_calendar_ = false;  // from the first pause on, time is the robot's alone
  }
  if (!follows_calendar_) return;
  const twin::Duration behind = calendar_.Now() - StampOf(at);
  if (behind > kMostBehind) origin_ns_ += behind.count();
}

void Bridge::Impl::ReadHand(Time at) {
  const bool is_known = robot_.hand || (hand_ && robot_.keeps_connection);
  const bool is_due = at >= hand_due_ || hand_due_ - at > kHandRetry;  // or time began anew
  if (!is_known || !is_due) return;
  hand_due_ = at + kHandPeriod;
  try {
    width_ = robot_.hand ? robot_.hand().width : ConnectHand()->ReadState().width;
  } catch (const Error&) {
    // The last one stays: the robot ends, or the hand is not there.
    hand_due_ = at + kHandRetry;
    const std::lock_guard lock(hand_mutex_);
    kept_hand_.reset();
  }
}

void Bridge::Impl::Take(const record::CycleRecord& record) {
  if (options_.lockstep_hz) last_ = record;
  const msg::Time stamp = ToMessage(StampOf(record.at));
  if (!options_.lockstep_hz) PublishForController(record.state, stamp);
  const auto every = static_cast<std::uint64_t>(std::lround(1000 / options_.rate_hz));
  const auto cycle = static_cast<std::uint64_t>(record.at.time_since_epoch() / kCycle);
  if (cycle % every != 0) return;
  if (joint_states_->has_readers()) {
    msg::JointState joints = JointsOf(record.state, hand_ != nullptr);
    joints.header.stamp = stamp;
    joint_states_->Publish(joints);
  }
  franka_topics_->Publish(record.state, stamp, names_);
  if (clock_topic_ && clock_topic_->has_readers()) clock_topic_->Publish({.clock = stamp});
}

void Bridge::Impl::Run(const std::stop_token& stop) {
  Time next = clock_.Now();
  while (!stop.stop_requested()) {
    Time newest{};
    while (tap_.TryPop([&](const record::CycleRecord& record) {
      newest = record.at;
      Take(record);
    })) {
    }
    if (newest != Time()) {
      FollowCalendar(newest);
      ReadHand(newest);
    }
    if (simulation_) simulation_->Look();
    if (options_.lockstep_hz && clock_.Now() >= repeat_at_ && !arm_->is_busy()) {
      // Time stands: the first answer is due to this one.
      PublishForController(last_.state, ToMessage(StampOf(last_.at)));
      repeat_at_ = clock_.Now() + kRepeat;
    }
    next = std::max(next + kLook, clock_.Now());
    rt::SleepUntil(clock_, next);
  }
}

Bridge::Bridge(const BridgeOptions& options, BridgedRobot robot, StateTap& tap)
    : impl_(std::make_unique<Impl>(options, std::move(robot), tap)) {}

Bridge::~Bridge() = default;

std::string Bridge::Introduction() const {
  return impl_->Introduction();
}

}  // namespace twin::ros2
