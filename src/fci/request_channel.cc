#include "fci/request_channel.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/rt/thread_setup.h"

namespace twin::fci {
namespace {

/// Only Move has two answers; surplus ones are discarded.
constexpr std::size_t kMostAnswers = 2;

FileDescriptor MakeWaker() {
  FileDescriptor fd(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!fd.valid()) {
    throw EnvironmentError(
        "the operating system gives no more file descriptors; close other programs, or raise the "
        "limit (ulimit -n)");
  }
  return fd;
}

/// The thread only waits for bytes; it is not part of the 1 kHz path.
rt::ThreadSettings ReaderSettings() {
  rt::ThreadSettings settings;
  settings.name = "twin-fci-tcp";
  settings.lock_memory = false;
  settings.stack_kb = 0;
  return settings;
}

}  // namespace

RequestChannel::RequestChannel(HeadKind kind, TcpStream stream, std::string peer,
                               std::size_t largest, Duration timeout, Capture* capture,
                               SideSocket side)
    : stream_(std::move(stream)),
      peer_(std::move(peer)),
      timeout_(timeout),
      capture_(capture),
      side_(std::move(side)),
      reader_(kind, largest),
      awake_(MakeWaker()) {
  thread_ =
      rt::StartThread(ReaderSettings(), [this](const std::stop_token& stop) { Run(stop); }).thread;
}

RequestChannel::~RequestChannel() {
  thread_.request_stop();
  const std::uint64_t one = 1;
  // Cannot fail: the counter is far below its limit.
  static_cast<void>(!::write(awake_.get(), &one, sizeof one));
  thread_.join();
  stream_.Close();
}

std::uint32_t RequestChannel::Send(std::string_view name, const Encoder& encode) {
  const std::lock_guard sending(sending_);
  const std::uint32_t id = next_id_++;
  {
    const std::lock_guard lock(mutex_);
    requests_.try_emplace(id);
  }
  try {
    SendAll(name, encode(id));
  } catch (...) {
    Forget(id);
    throw;
  }
  return id;
}

void RequestChannel::SendAll(std::string_view name, std::span<const std::byte> bytes) {
  Keep(stream_.local(), stream_.peer(), bytes);  // before the answer arrives
  while (!bytes.empty()) {
    std::size_t sent = 0;
    const StreamResult result = lost() ? StreamResult::kReset : stream_.Send(bytes, sent);
    if (result == StreamResult::kDone) {
      bytes = bytes.subspan(sent);
      continue;
    }
    if (result == StreamResult::kPending) {
      pollfd poll_for{stream_.fd(), POLLOUT, 0};
      const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(timeout_).count();
      if (::poll(&poll_for, 1, static_cast<int>(ms)) > 0) continue;
      Lose("takes no more requests");
    } else {
      Lose("has broken the connection");
    }
    const std::lock_guard lock(mutex_);
    throw RobotFault(TextLocked(name));
  }
}

std::optional<RequestChannel::Answer> RequestChannel::Await(std::uint32_t id, std::string_view name,
                                                            Duration timeout) {
  std::unique_lock lock(mutex_);
  const auto request = requests_.find(id);
  if (request == requests_.end()) return std::nullopt;
  std::deque<Answer>& answers = request->second;
  changed_.wait_for(lock, timeout, [&] { return !answers.empty() || lost(); });
  if (answers.empty()) {
    if (lost()) throw RobotFault(TextLocked(name));
    return std::nullopt;
  }
  Answer answer = std::move(answers.front());
  answers.pop_front();
  return answer;
}

void RequestChannel::Forget(std::uint32_t id) {
  const std::lock_guard lock(mutex_);
  requests_.erase(id);
}

std::string RequestChannel::WhyLost() const {
  const std::lock_guard lock(mutex_);
  return lost() ? fmt::format("{} {}", peer_, why_lost_) : std::string();
}

std::string RequestChannel::TextLocked(std::string_view name) const {
  return fmt::format(
      "{}: {} {}; see whether it still runs and the network is up, or another program holds it; "
      "then "
      "connect anew",
      name, peer_, why_lost_);
}

void RequestChannel::Lose(std::string why) {
  {
    const std::lock_guard lock(mutex_);
    if (lost()) return;
    why_lost_ = std::move(why);
    lost_.store(true, std::memory_order_release);
  }
  changed_.notify_all();
}

void RequestChannel::Run(const std::stop_token& stop) {
  while (!stop.stop_requested() && !lost()) {
    std::array<pollfd, 3> fds{{{stream_.fd(), POLLIN, 0},
                               {awake_.get(), POLLIN, 0},
                               {side_.fd, POLLIN, 0}}};    // poll ignores negative descriptors
    if (::poll(fds.data(), fds.size(), -1) < 0) continue;  // interrupted
    if (fds[0].revents != 0) {
      ReceiveSome();
    } else if (fds[2].revents != 0) {
      side_.drain();
    }
  }
}

void RequestChannel::ReceiveSome() {
  std::size_t received = 0;
  const StreamResult result = stream_.Receive(reader_.Room(), received);
  if (side_.drain) side_.drain();
  switch (result) {
    case StreamResult::kPending: return;
    case StreamResult::kClosed: Lose("has closed the connection"); return;
    case StreamResult::kReset: Lose("has reset the connection"); return;
    case StreamResult::kDone: break;
  }
  Keep(stream_.peer(), stream_.local(), reader_.Room().first(received));
  reader_.Received(received);
  while (const std::optional<Frame> frame = reader_.Next()) Dispatch(*frame);
  if (const std::string* fault = reader_.fault()) {
    Lose(fmt::format("sends what is no answer ({})", *fault));
  }
}

void RequestChannel::Keep(const Endpoint& from, const Endpoint& to,
                          std::span<const std::byte> bytes) {
  if (capture_ == nullptr) return;
  capture_->Put({.at = capture_->clock().Now(),
                 .transport = record::Transport::kTcp,
                 .from = from,
                 .to = to,
                 .bytes = bytes});
}

void RequestChannel::Dispatch(const Frame& frame) {
  {
    const std::lock_guard lock(mutex_);
    const auto request = requests_.find(frame.head.command_id);
    if (request == requests_.end() || request->second.size() >= kMostAnswers) return;
    request->second.push_back({frame.head, {frame.payload.begin(), frame.payload.end()}});
  }
  changed_.notify_all();
}

}  // namespace twin::fci
