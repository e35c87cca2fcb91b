// The barest client of the Franka Control Interface: one thread that blocks at a socket, takes the
// newest state and answers it. Holds the arm where it is: bare_wire_loop HOST PORT SECONDS. What
// this project's client is measured against (wire_realtime_bench.py).

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "twin/core/robot_state.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/requests.h"
#include "twin/rt/thread_setup.h"

namespace {

using twin::RobotCommand;
using twin::RobotState;

constexpr int kPriority = 99;  ///< as this project's communication thread has
constexpr std::size_t kConnectAnswerBytes = 15;
constexpr std::size_t kMoveAnswerBytes = 13;

[[noreturn]] void Fail(const char* what) {
  std::perror(what);
  std::exit(1);
}

void Send(int tcp, const std::vector<std::byte>& frame) {
  if (send(tcp, frame.data(), frame.size(), 0) < 0) Fail("send");
}

/// Whole answers; of one, the status.
int Status(int tcp, std::size_t bytes) {
  std::vector<unsigned char> answer(bytes);
  if (recv(tcp, answer.data(), bytes, MSG_WAITALL) != static_cast<ssize_t>(bytes)) Fail("answer");
  return answer[twin::fci::kArmHeadBytes];
}

/// States in, commands out.
class Wire {
 public:
  Wire() : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in any{};
    any.sin_family = AF_INET;
    if (bind(fd_, reinterpret_cast<sockaddr*>(&any), sizeof any) < 0) Fail("bind");
  }
  ~Wire() { close(fd_); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  [[nodiscard]] std::uint16_t port() const {
    sockaddr_in local{};
    socklen_t size = sizeof local;
    if (getsockname(fd_, reinterpret_cast<sockaddr*>(&local), &size) < 0) Fail("getsockname");
    return ntohs(local.sin_port);
  }

  /// Waits for a state, and takes the newest that is there then.
  RobotState Newest() {
    RobotState state;
    for (int flags = 0; Receive(flags, state); flags = MSG_DONTWAIT) {
    }
    return state;
  }
  void Answer(const RobotCommand& command) {
    twin::fci::CommandBytes bytes;
    twin::fci::Encode(command, bytes);
    sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&robot_), sizeof robot_);
  }

 private:
  bool Receive(int flags, RobotState& state) {
    socklen_t size = sizeof robot_;
    const ssize_t count = recvfrom(fd_, incoming_.data(), incoming_.size(), flags,
                                   reinterpret_cast<sockaddr*>(&robot_), &size);
    if (count < 0) return false;
    const auto bytes = std::span(incoming_).first(static_cast<std::size_t>(count));
    return twin::fci::Decode(bytes, state) == twin::fci::DatagramFault::kNone;
  }

  int fd_;
  sockaddr_in robot_{};
  twin::fci::StateBytes incoming_{};
};

int Connect(const char* host, const char* port) {
  sockaddr_in robot{};
  robot.sin_family = AF_INET;
  robot.sin_port = htons(static_cast<std::uint16_t>(std::stoi(port)));
  if (inet_pton(AF_INET, host, &robot.sin_addr) != 1) Fail(host);
  const int tcp = socket(AF_INET, SOCK_STREAM, 0);
  if (connect(tcp, reinterpret_cast<sockaddr*>(&robot), sizeof robot) < 0) Fail("connect");
  const int one = 1;
  setsockopt(tcp, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
  return tcp;
}

/// Holds the arm for so many states.
void Hold(Wire& wire, std::uint64_t states) {
  RobotState state = wire.Newest();
  while (state.robot_mode != twin::RobotMode::kMove) state = wire.Newest();
  state = wire.Newest();
  const std::uint64_t first = state.message_id;
  RobotCommand command;
  command.q_c = state.q_d;
  while (state.robot_mode == twin::RobotMode::kMove) {
    command.message_id = state.message_id;
    command.motion_generation_finished = state.message_id >= first + states;
    wire.Answer(command);
    state = wire.Newest();
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fputs("usage: bare_wire_loop HOST PORT SECONDS\n", stderr);
    return 2;
  }
  const twin::rt::ThreadSettings settings{.name = "bare", .fifo_priority = kPriority};
  for (const std::string& notice : twin::rt::SetUpThisThread(settings)) {
    std::fprintf(stderr, "%s\n", notice.c_str());
  }
  const int tcp = Connect(argv[1], argv[2]);
  Wire wire;
  using twin::fci::ArmRequest;
  Send(tcp, twin::fci::EncodeRequest(
                0, ArmRequest(twin::fci::Connect{twin::fci::VersionOf(twin::fci::Protocol::k5),
                                                 wire.port()})));
  if (Status(tcp, kConnectAnswerBytes) != 0) Fail("Connect was refused");
  Send(tcp, twin::fci::EncodeRequest(1, ArmRequest(twin::fci::Move())));
  if (Status(tcp, kMoveAnswerBytes) != 1) Fail("Move was refused");
  Hold(wire, static_cast<std::uint64_t>(std::stoi(argv[3])) * 1000);
  const int end = Status(tcp, kMoveAnswerBytes);
  close(tcp);
  if (end != 0) std::fprintf(stderr, "the motion ended with status %d\n", end);
  return end == 0 ? 0 : 1;
}
