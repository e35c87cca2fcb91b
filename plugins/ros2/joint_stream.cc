#include "plugins/ros2/joint_stream.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/error.h"
#include "twin/core/robot_state.h"

namespace twin::ros2 {
namespace {

/// Of one motion; a stream may go on for so long.
constexpr twin::Duration kLongest = std::chrono::hours(23);
constexpr twin::Duration kBetweenComplaints = std::chrono::seconds(1);

std::string TextOf(const Guid& writer) {
  return fmt::format("{:02x}", fmt::join(writer.begin(), writer.begin() + 12, ""));
}

}  // namespace

/// One stretch of the stream.
class JointStream::Follow final : public ArmWork {
 public:
  Follow(JointStream& stream, double rate_hz) : stream_(stream), rate_hz_(rate_hz) {}

  /// From the stream's thread.
  void Put(const Command& command) noexcept { commands_.Publish(command); }

  void Run(run::Session& session, const scenario::Scenario& client) override {
    const RobotState state = session.ReadState();
    RequireReady(state);
    run::Motion motion =
        run::MotionOn(client, "robot_joint_commands", control::CommandInterface::kJointPosition,
                      run::StandingFor(state.q_d, kLongest, session.robot().limits));
    motion.source_rate_hz = std::clamp(rate_hz_, 1.0, 1000.0);
    const run::MotionResult result = MoveByOwnController(session, std::move(motion));
    if (!result.report.failure.empty()) throw RobotFault(result.report.failure);
  }

  std::unique_ptr<control::Controller> MakeController(
      const control::ControllerRequest& /*request*/) override;

  void End(const std::string& why, bool gave_up) override {
    is_over_ = true;
    if (gave_up) return stream_.parts_.tell("ROS 2: robot_joint_commands: the motion was ended");
    stream_.parts_.tell(
        why.empty()
            ? std::string("ROS 2: robot_joint_commands: no command for 0.5 s; the arm rests")
            : fmt::format("ROS 2: robot_joint_commands: {}; arm it again", why));
    if (!why.empty()) stream_.Disarm();
  }

  [[nodiscard]] bool is_over() const noexcept { return is_over_; }

 private:
  class Controller;

  JointStream& stream_;
  const double rate_hz_;
  rt::LatestValue<Command> commands_;
  std::atomic<bool> is_over_{false};
};

/// Passes commands on as they come.
///
/// Threads, real-time: as control::Controller.
class JointStream::Follow::Controller final : public control::Controller {
 public:
  explicit Controller(rt::LatestValue<Command>& commands) : commands_(commands) {}

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }

  void Activate(const RobotState& state, Time /*now*/) override {
    static_cast<void>(commands_.Refresh());
    const JointVector& q = commands_.value().q;
    for (std::size_t j = 0; commands_.has_value() && j < kJoints; ++j) {
      if (std::abs(q[j] - state.q_d[j]) <= kStartTolerance) continue;
      throw InputError(fmt::format(
          "joint {} is commanded to {:.4f} rad, and the arm is at {:.4f} rad; they may differ by {} "
          "rad at the start: begin to command from where the arm is",
          j + 1, q[j], state.q_d[j], kStartTolerance));
    }
    q_ = state.q_d;
    is_first_ = true;
    origin_.reset();
  }

  void Update(const RobotState& /*state*/, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override {
    output.fresh = is_first_;
    if (is_first_) {
      heard_ = sampled_ = now;
      is_first_ = false;
    }
    if (commands_.Refresh() || (!origin_ && commands_.has_value())) {
      const Command& command = commands_.value();
      // The sender's clock has another zero, and may be set.
      if (!origin_ || command.sampled_at - *origin_ < sampled_ - Time() ||
          command.sampled_at - *origin_ > now - Time() + kSilence) {
        origin_ = Time() + (command.sampled_at - now);
      }
      sampled_ = Time() + (command.sampled_at - *origin_);
      q_ = command.q;
      heard_ = now;
      output.fresh = true;
    }
    output.target.joint.q = q_;
    output.sampled_at = sampled_;
    output.finished = now - heard_ > kSilence;
  }

  void Deactivate() noexcept override {}

 private:
  rt::LatestValue<Command>& commands_;
  JointVector q_{};
  bool is_first_ = true;
  std::optional<Time> origin_;  ///< of the sender's clock, on the run's
  Time sampled_{};              ///< of q_, on the run's clock
  Time heard_{};
};

std::unique_ptr<control::Controller> JointStream::Follow::MakeController(
    const control::ControllerRequest& /*request*/) {
  return std::make_unique<Controller>(commands_);
}

JointStream::JointStream(Parts parts) : parts_(std::move(parts)) {
  arrivals_.reserve(kMeasured);
}

void JointStream::Arm() {
  const std::lock_guard lock(mutex_);
  is_armed_ = true;
  told_unarmed_ = false;
  arrivals_.clear();
}

void JointStream::Disarm() {
  std::shared_ptr<Follow> current;
  {
    const std::lock_guard lock(mutex_);
    is_armed_ = false;
    current = current_.lock();
  }
  if (current) parts_.arm.GiveUp(*current);
}

bool JointStream::is_armed() const {
  const std::lock_guard lock(mutex_);
  return is_armed_;
}

JointVector JointStream::PositionsOf(const msg::JointState& message) const {
  if (message.position.empty()) {
    throw InputError("a command has no positions; the arm follows positions alone");
  }
  JointVector q{};
  for (std::size_t j = 0; j < kJoints; ++j) {
    const auto name = std::ranges::find(message.name, parts_.names[j]);
    const auto at = static_cast<std::size_t>(name - message.name.begin());
    if (name == message.name.end() || at >= message.position.size()) {
      throw InputError(fmt::format("a command lacks {}", parts_.names[j]));
    }
    q[j] = message.position[at];
    if (q[j] >= parts_.limits.q_min[j] && q[j] <= parts_.limits.q_max[j]) continue;
    throw InputError(fmt::format("{} is commanded to {} rad, and has [{:.4f}, {:.4f}] rad",
                                 parts_.names[j], q[j], parts_.limits.q_min[j],
                                 parts_.limits.q_max[j]));
  }
  return q;
}

void JointStream::Complain(std::string_view why) {
  const Time now = clock_.Now();
  if (complained_ && now - *complained_ < kBetweenComplaints) return;
  complained_ = now;
  parts_.tell(fmt::format("ROS 2: robot_joint_commands: {}; it is ignored", why));
}

void JointStream::Put(const msg::JointState& message, const Guid& writer) {
  const Time now = clock_.Now();
  const std::lock_guard lock(mutex_);
  if (!is_armed_) {
    if (std::exchange(told_unarmed_, true)) return;
    return Complain(
        fmt::format("participant {} commands the arm, which is not armed for it (call "
                    "~/arm, or serve with --ros-arm)",
                    TextOf(writer)));
  }
  const bool is_silent = !last_ || now - *last_ > kSilence;
  if (writer != writer_ && !is_silent) {
    return Complain(fmt::format("participant {} commands the arm too, while {} leads it",
                                TextOf(writer), TextOf(writer_)));
  }
  try {
    const Time stamp = FromMessage(message.header.stamp);
    const Command command{.q = PositionsOf(message), .sampled_at = stamp == Time() ? now : stamp};
    if (is_silent || writer != writer_) arrivals_.clear();
    writer_ = writer;
    last_ = now;
    const std::shared_ptr<Follow> current = current_.lock();
    if (current && !current->is_over()) return current->Put(command);
    Measure(command, now);
  } catch (const InputError& error) {
    Complain(error.what());
  }
}

void JointStream::Measure(const Command& command, Time now) {
  arrivals_.push_back(now);
  if (arrivals_.size() < kMeasured) return;
  const double rate_hz =
      static_cast<double>(arrivals_.size() - 1) / ToSeconds(arrivals_.back() - arrivals_.front());
  arrivals_.clear();
  auto follow = std::make_shared<Follow>(*this, rate_hz);
  current_ = follow;
  follow->Put(command);
  parts_.tell(fmt::format("ROS 2: robot_joint_commands: the arm follows {}, {:.0f} commands/s",
                          TextOf(writer_), rate_hz));
  parts_.arm.Begin(std::move(follow));
}

}  // namespace twin::ros2
