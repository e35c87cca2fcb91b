#include "plugins/ros2/joint_stream.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "plugins/ros2/conversions.h"
#include "twin/core/error.h"
#include "twin/core/robot_state.h"

namespace twin::ros2 {
namespace {

/// Of one motion; a stream may go on for so long.
constexpr twin::Duration kLongest = std::chrono::hours(23);
/// Highest believable rate of commands, Hz: a controller_manager's 1 kHz with jitter.
constexpr double kMostRate = 1500;
constexpr twin::Duration kBetweenComplaints = std::chrono::seconds(1);

std::string TextOf(const Guid& writer) {
  return fmt::format("{:02x}", fmt::join(writer.begin(), writer.begin() + 12, ""));
}

/// @throws InputError for a first command that is far from the arm.
void RequireNear(const JointVector& q, const JointVector& q_d) {
  for (std::size_t j = 0; j < kJoints; ++j) {
    if (std::abs(q[j] - q_d[j]) <= JointStream::kStartTolerance) continue;
    throw InputError(fmt::format(
        "joint {} is commanded to {:.4f} rad, and the arm is at {:.4f} rad; they may differ by {} "
        "rad at the start: begin to command from where the arm is",
        j + 1, q[j], q_d[j], JointStream::kStartTolerance));
  }
}

}  // namespace

/// One stretch of the stream.
class JointStream::Follow final : public ArmWork {
 public:
  Follow(JointStream& stream, double rate_hz) : stream_(stream), rate_hz_(rate_hz) {}

  /// From the stream's thread.
  void Put(const JointCommand& command) {
    stream_.parts_.lockstep ? answers_.Put(command) : commands_.Publish(command);
  }
  void Stop() { answers_.Stop(); }

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
            ? std::string("ROS 2: robot_joint_commands: the commands have ended; the arm rests")
            : fmt::format("ROS 2: robot_joint_commands: {}; arm it again", why));
    if (!why.empty()) stream_.Disarm();
  }

  [[nodiscard]] bool is_over() const noexcept { return is_over_; }

 private:
  class Controller;
  class LockstepController;

  JointStream& stream_;
  const double rate_hz_;
  LockstepAnswers answers_;  ///< in lockstep
  rt::LatestValue<JointCommand> commands_;
  std::atomic<bool> is_over_{false};
};

/// Passes commands on as they come.
///
/// Threads, real-time: as control::Controller.
class JointStream::Follow::Controller final : public control::Controller {
 public:
  explicit Controller(rt::LatestValue<JointCommand>& commands) : commands_(commands) {}

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }

  void Activate(const RobotState& state, Time /*now*/) override {
    static_cast<void>(commands_.Refresh());
    if (commands_.has_value()) RequireNear(commands_.value().q, state.q_d);
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
      const JointCommand& command = commands_.value();
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
  rt::LatestValue<JointCommand>& commands_;
  JointVector q_{};
  bool is_first_ = true;
  std::optional<Time> origin_;  ///< of the sender's clock, on the run's
  Time sampled_{};              ///< of q_, on the run's clock
  Time heard_{};
};

/// Publishes states, and waits for the answer to each. Of lockstep alone: Update() waits.
///
/// Threads: as control::Controller.
class JointStream::Follow::LockstepController final : public control::Controller {
 public:
  LockstepController(const Lockstep& lockstep, LockstepAnswers& answers)
      : lockstep_(lockstep), answers_(answers) {}

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  void Activate(const RobotState& state, Time /*now*/) override {
    q_d_ = state.q_d;
    cycles_ = 0;
  }
  void Update(const RobotState& state, Time /*now*/,
              control::ControllerOutput& output) noexcept override {
    output.fresh = cycles_++ % lockstep_.period_cycles == 0;
    if (!output.fresh || output.failed) return;
    if (output.finished) {  // the last target again, as a source that rests
      *output.sampled_at += lockstep_.period_cycles * kCycle;
      return;
    }
    const auto answer = answers_.Await(lockstep_.publish(state), lockstep_.timeout);
    if (answers_.is_stopped()) {
      output.finished = output.sampled_at.has_value();
      output.failed = !output.finished;  // it has never been commanded
      if (output.finished) *output.sampled_at += lockstep_.period_cycles * kCycle;
      return;
    }
    output.failed = !answer || !IsNear(answer->q);
    if (output.failed) return;
    output.target.joint.q = answer->q;
    output.sampled_at = answer->sampled_at;
  }
  void Deactivate() noexcept override {}
  [[nodiscard]] std::string Explain() const override {
    return is_far_ ? fmt::format(
                         "the first command is more than {} rad from the arm; begin to "
                         "command from where the arm is",
                         kStartTolerance)
                   : fmt::format("no command has answered a state for {} s",
                                 ToSeconds(lockstep_.timeout));
  }

 private:
  /// Of the first command.
  bool IsNear(const JointVector& q) noexcept {
    if (cycles_ == 1) {
      is_far_ = !std::ranges::equal(
          q, q_d_, [](double a, double b) { return std::abs(a - b) <= kStartTolerance; });
    }
    return !is_far_;
  }

  const Lockstep& lockstep_;
  LockstepAnswers& answers_;
  JointVector q_d_{};
  std::uint64_t cycles_ = 0;
  bool is_far_ = false;
};

std::unique_ptr<control::Controller> JointStream::Follow::MakeController(
    const control::ControllerRequest& /*request*/) {
  if (stream_.parts_.lockstep) {
    return std::make_unique<LockstepController>(*stream_.parts_.lockstep, answers_);
  }
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
  if (!current) return;
  // In lockstep the motion ends by a command, as all else does: a stop has a time of its own.
  parts_.lockstep ? current->Stop() : parts_.arm.GiveUp(*current);
}

bool JointStream::is_leading() const {
  const std::lock_guard lock(mutex_);
  const std::shared_ptr<Follow> current = current_.lock();
  return current && !current->is_over();
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

void JointStream::RequireTimely(Time stamp) const {
  if (stamp == Time() || parts_.lockstep) return;
  const twin::Duration age = parts_.now() - stamp;
  if (age <= kOldest && age >= -kOldest) return;
  throw InputError(fmt::format(
      "a command is stamped {:.3f} s {}; {} s are permitted. See that both ends use the same clock "
      "(use_sim_time), or leave the stamp 0",
      std::abs(ToSeconds(age)), age > twin::Duration::zero() ? "ago" : "ahead",
      ToSeconds(kOldest)));
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
    complained_.reset();  // it is told once: now
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
    RequireTimely(stamp);
    const JointCommand command{.q = PositionsOf(message),
                               .sampled_at = stamp == Time() ? now : stamp};
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

void JointStream::Measure(const JointCommand& command, Time now) {
  if (parts_.lockstep) return BeginToFollow(command, 1000.0 / parts_.lockstep->period_cycles);
  arrivals_.push_back(now);
  if (arrivals_.size() < kMeasured) return;
  const double rate_hz =
      static_cast<double>(arrivals_.size() - 1) / ToSeconds(arrivals_.back() - arrivals_.front());
  arrivals_.clear();
  if (rate_hz > kMostRate) return;  // a backlog that comes at once: measured anew
  BeginToFollow(command, rate_hz);
}

void JointStream::BeginToFollow(const JointCommand& command, double rate_hz) {
  auto follow = std::make_shared<Follow>(*this, rate_hz);
  follow->Put(command);
  current_ = follow;
  if (!parts_.arm.TryBegin(follow)) {
    current_.reset();
    return Complain("the arm is busy with a goal or a request");
  }
  parts_.tell(fmt::format("ROS 2: robot_joint_commands: the arm follows {}, {:.0f} commands/s",
                          TextOf(writer_), rate_hz));
}

}  // namespace twin::ros2
