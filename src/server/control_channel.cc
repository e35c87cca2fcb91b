#include "twin/server/control_channel.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <functional>
#include <optional>
#include <stop_token>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "server/local_socket.h"
#include "twin/core/error.h"
#include "twin/core/robot_errors.h"
#include "twin/model/transform.h"
#include "twin/server/wake_event.h"

namespace twin::server {
namespace {

using AnswerJson = nlohmann::ordered_json;

constexpr std::size_t kLongestLine = 4096;
constexpr std::size_t kMostConnections = 8;

/// @returns false when the peer is gone or does not read.
bool SendLine(const fci::FileDescriptor& socket, std::string line) {
  line += '\n';
  const ssize_t sent = send(socket.get(), line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  return sent == static_cast<ssize_t>(line.size());
}

std::string Refusal(std::string_view why) {
  return AnswerJson{{"ok", false}, {"error", why}}.dump(-1, ' ', false,
                                                        AnswerJson::error_handler_t::replace);
}

std::string WhyNot(RecoveryStatus status, RobotMode mode) {
  switch (status) {
    case RecoveryStatus::kManualErrorRecoveryRequiredRejected:
      return "a joint is beyond its limit; lead the arm back (guiding)";
    case RecoveryStatus::kCommandNotPossibleRejected:
      return fmt::format("not possible in mode \"{}\", or the arm still moves", Name(mode));
    default: return "the error persists";
  }
}

/// Carries out the requests of a channel.
class ControlledRobot {
 public:
  explicit ControlledRobot(const ControlChannel::Controlled& controlled)
      : robot_(controlled.robot),
        lockstep_(controlled.lockstep),
        place_(controlled.place),
        require_free_(controlled.require_free),
        may_reset_(controlled.may_reset) {}

  /// @throws InputError when the robot refuses; RobotFault.
  void Do(const ControlRequest& request) {
    switch (request.verb) {
      case ControlVerb::kStatus: return;
      case ControlVerb::kPause: return Lockstep("pause").Pause();
      case ControlVerb::kResume: return Lockstep("resume").Resume();
      case ControlVerb::kStep:
        if (Lockstep("step").Step(request.cycles)) return;
        throw InputError("step: time runs, or another step does; pause first");
      case ControlVerb::kUserStop:
        return Operate(request.on ? PanelAction::kPressUserStop : PanelAction::kReleaseUserStop);
      case ControlVerb::kGuiding:
        return Operate(request.on ? PanelAction::kPressGuidingButton
                                  : PanelAction::kReleaseGuidingButton);
      case ControlVerb::kReset: return Reset(request.q);
      case ControlVerb::kPlace: return Place(request);
      case ControlVerb::kSnapshot:
        if (Lockstep("snapshot").Save(request.name)) return;
        throw InputError(fmt::format("snapshot: {}", kOnlyBetween));
      case ControlVerb::kRestore:
        if (Lockstep("restore").Restore(request.name)) return;
        throw InputError(fmt::format("restore: {}", kOnlyBetween));
      case ControlVerb::kRecover: {
        const RecoveryStatus status = robot_.AutomaticErrorRecovery();
        if (status == RecoveryStatus::kSuccess) return;
        throw InputError(fmt::format("recover: refused: {}", WhyNot(status, robot_.mode())));
      }
    }
  }

  /// Whether cycles of a step are left.
  [[nodiscard]] bool IsStepping() const {
    return lockstep_ != nullptr && lockstep_->cycles_left().value_or(0) > 0;
  }

  /// The answer to a request that was carried out. @throws RobotFault.
  [[nodiscard]] std::string Status() const {
    const RobotState state = robot_.state();
    AnswerJson errors = AnswerJson::array();
    for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
      if (state.errors[i]) errors.push_back(Name(static_cast<RobotError>(i)));
    }
    return AnswerJson{{"ok", true},
                      {"cycle", state.message_id},
                      {"time_s", ToSeconds(static_cast<std::int64_t>(state.message_id) * kCycle)},
                      {"mode", Name(robot_.mode())},
                      {"paused", lockstep_ != nullptr && lockstep_->cycles_left().has_value()},
                      {"lockstep", lockstep_ != nullptr},
                      {"errors", errors},
                      {"q", state.q}}
        .dump();
  }

 private:
  static constexpr const char* kOnlyBetween =
      "refused in a motion, and while the hand executes a command";

  robot::AnswerPacedRobot& Lockstep(std::string_view what) const {
    if (lockstep_ != nullptr) return *lockstep_;
    throw InputError(fmt::format(
        "{}: this robot runs on the wall clock, which never stands still; serve it with --drive "
        "lockstep, or --pace 1",
        what));
  }

  void Reset(const std::optional<JointVector>& q) {
    robot::AnswerPacedRobot& robot = Lockstep("reset");
    if (!may_reset_) {
      throw InputError(
          "reset: this robot is served with --reset never, the default; serve it with --reset "
          "on-command");
    }
    if (q && require_free_) require_free_(*q);
    if (robot.Reset(q)) return;
    throw InputError(fmt::format("reset: {}", kOnlyBetween));
  }

  void Place(const ControlRequest& request) {
    const auto about = [&](std::size_t i, const Eigen::Vector3d& axis) {
      return Eigen::AngleAxisd(request.rpy[i], axis);
    };
    const Eigen::Quaterniond turn = about(2, Eigen::Vector3d::UnitZ()) *
                                    about(1, Eigen::Vector3d::UnitY()) *
                                    about(0, Eigen::Vector3d::UnitX());
    place_(request.name, model::Pose(turn, Eigen::Vector3d(request.position.data())));
  }

  void Operate(PanelAction action) {
    if (robot_.Operate(action)) return;
    throw InputError(fmt::format("{}: the robot does not accept it in mode \"{}\"", Name(action),
                                 Name(robot_.mode())));
  }

  robot::ThreadedRobot& robot_;
  robot::AnswerPacedRobot* const lockstep_;
  const std::function<void(const std::string& name, const Transform& X_WB)> place_;
  const std::function<void(const JointVector& q)> require_free_;
  const bool may_reset_;
};

}  // namespace

class ControlChannel::Impl {
 public:
  Impl(const std::filesystem::path& path, const Controlled& controlled, TellPeople tell)
      : path_(path),
        robot_(controlled),
        tell_(std::move(tell)),
        listener_(ListenAt(path)),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}
  ~Impl() {
    thread_.request_stop();
    wake_.Notify();
    thread_.join();
    unlink(path_.c_str());
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

 private:
  struct Connection {
    fci::FileDescriptor socket;
    std::string received{};
    bool steps = false;   ///< its last request is answered when the cycles have run
    bool closed = false;  ///< by the program: nothing more comes
    bool ended = false;
  };

  void Run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      Wait();
      if (stop.stop_requested()) return;
      for (Connection& connection : connections_) Serve(connection);
      std::erase_if(connections_, [](const Connection& connection) { return connection.ended; });
      Accept();  // after those that have ended have made room
    }
  }

  void Wait() {
    constexpr int kForever = -1;
    constexpr int kLookMs = 1;
    bool steps = false;
    waited_.clear();
    waited_.push_back({wake_.fd(), POLLIN, 0});
    waited_.push_back({listener_.get(), POLLIN, 0});
    for (const Connection& connection : connections_) {
      steps = steps || connection.steps;
      if (!connection.steps) waited_.push_back({connection.socket.get(), POLLIN, 0});
    }
    // The result does not matter: each descriptor is tried.
    static_cast<void>(poll(waited_.data(), waited_.size(), steps ? kLookMs : kForever));
  }

  void Accept() {
    while (true) {
      fci::FileDescriptor socket(
          accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
      if (!socket.valid()) return;
      if (connections_.size() < kMostConnections) {
        connections_.push_back({std::move(socket)});
      } else {
        static_cast<void>(SendLine(
            socket, Refusal(fmt::format("{} programs are connected already; end one of them",
                                        kMostConnections))));
      }
    }
  }

  void Serve(Connection& connection) {
    if (!connection.steps) Receive(connection);
    while (!connection.ended) {
      if (connection.steps) {
        if (robot_.IsStepping()) return;
        connection.steps = false;
        AnswerStatus(connection);
        continue;
      }
      const std::size_t end = connection.received.find('\n');
      if (std::min(end, connection.received.size()) > kLongestLine) {
        Answer(connection, Refusal(fmt::format("a request has at most {} bytes", kLongestLine)));
        connection.ended = true;
        return;
      }
      if (end == std::string::npos) break;
      const std::string line = connection.received.substr(0, end);
      connection.received.erase(0, end + 1);
      Take(connection, line);
    }
    connection.ended = connection.ended || connection.closed;
  }

  static void Receive(Connection& connection) {
    std::array<char, kLongestLine> bytes{};
    const ssize_t count = recv(connection.socket.get(), bytes.data(), bytes.size(), 0);
    if (count > 0) connection.received.append(bytes.data(), static_cast<std::size_t>(count));
    const bool is_empty = count < 0 && (errno == EAGAIN || errno == EINTR);
    if (count <= 0 && !is_empty) connection.closed = true;
  }

  void Take(Connection& connection, const std::string& line) {
    ControlRequest request;
    try {
      request = ParseControlRequest(line);
    } catch (const InputError& error) {
      Answer(connection, Refusal(error.what()));
      connection.ended = true;
      return;
    }
    try {
      robot_.Do(request);
      if (request.verb != ControlVerb::kStatus) tell_(fmt::format("control: {}", ToLine(request)));
      connection.steps = request.verb == ControlVerb::kStep;
      if (!connection.steps) AnswerStatus(connection);
    } catch (const Error& error) {
      Answer(connection, Refusal(error.what()));
    }
  }

  void AnswerStatus(Connection& connection) {
    try {
      Answer(connection, robot_.Status());
    } catch (const RobotFault& fault) {
      Answer(connection, Refusal(fault.what()));
    }
  }

  static void Answer(Connection& connection, std::string line) {
    if (!SendLine(connection.socket, std::move(line))) connection.ended = true;
  }

  const std::filesystem::path path_;
  ControlledRobot robot_;
  const TellPeople tell_;
  WakeEvent wake_;
  const fci::FileDescriptor listener_;
  std::vector<Connection> connections_;
  std::vector<pollfd> waited_;
  std::jthread thread_;
};

ControlChannel::ControlChannel(const std::filesystem::path& path, const Controlled& controlled,
                               TellPeople tell)
    : impl_(std::make_unique<Impl>(path, controlled, std::move(tell))) {}

ControlChannel::~ControlChannel() = default;

std::string AskControl(const std::filesystem::path& path, const ControlRequest& request) {
  const std::optional<fci::FileDescriptor> socket = ConnectTo(path);
  if (!socket) {
    throw EnvironmentError(fmt::format(
        "{}: no served robot has its control channel there; start one with panda-twin serve "
        "--control {}",
        path.string(), path.string()));
  }
  // A channel that refuses the connection has answered, and takes nothing.
  static_cast<void>(SendLine(*socket, ToLine(request)));
  std::string answer;
  std::array<char, kLongestLine> bytes{};
  for (ssize_t count = 1; count > 0 && answer.find('\n') == std::string::npos;) {
    count = recv(socket->get(), bytes.data(), bytes.size(), 0);
    if (count > 0) answer.append(bytes.data(), static_cast<std::size_t>(count));
  }
  const std::size_t end = answer.find('\n');
  if (end != std::string::npos) return answer.substr(0, end);
  throw EnvironmentError(
      fmt::format("{}: the served robot ended before it answered", path.string()));
}

}  // namespace twin::server
