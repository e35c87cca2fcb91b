#include "twin/server/control_channel.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <stop_token>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "server/local_socket.h"
#include "twin/core/error.h"
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

}  // namespace

class ControlChannel::Impl {
 public:
  Impl(const std::filesystem::path& path, const ControlledRobot& controlled, TellPeople tell)
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
    bool waits = false;   ///< its last request is answered once the robot has done it
    bool closed = false;  ///< by the program: nothing more comes
    bool ended = false;
  };

  void Run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      Wait();
      if (stop.stop_requested()) return;
      ServeAll();
      Accept();
    }
  }

  void ServeAll() {
    for (Connection& connection : connections_) Serve(connection);
    std::erase_if(connections_, [](const Connection& connection) { return connection.ended; });
  }

  void Wait() {
    constexpr int kForever = -1;
    constexpr int kLookMs = 1;
    bool waits = false;
    waited_.clear();
    waited_.push_back({wake_.fd(), POLLIN, 0});
    waited_.push_back({listener_.get(), POLLIN, 0});
    for (const Connection& connection : connections_) {
      waits = waits || connection.waits;
      if (!connection.waits) waited_.push_back({connection.socket.get(), POLLIN, 0});
    }
    // The result does not matter: each descriptor is tried.
    static_cast<void>(poll(waited_.data(), waited_.size(), waits ? kLookMs : kForever));
  }

  void Accept() {
    while (true) {
      fci::FileDescriptor socket(
          accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
      if (!socket.valid()) return;
      // Connections that have ended since the last call make room.
      if (connections_.size() == kMostConnections) ServeAll();
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
    if (!connection.waits) Receive(connection);
    while (!connection.ended) {
      if (connection.waits) {
        if (robot_.IsBusy()) return;
        connection.waits = false;
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
      connection.waits = TakesTime(request.verb);
      if (!connection.waits) AnswerStatus(connection);
    } catch (const Error& error) {
      Answer(connection, Refusal(error.what()));
    }
  }

  void AnswerStatus(Connection& connection) {
    try {
      Answer(connection, robot_.StatusLine());
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

ControlChannel::ControlChannel(const std::filesystem::path& path, const ControlledRobot& controlled,
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
