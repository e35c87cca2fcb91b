#include "twin/fci/hand_client.h"

#include <array>
#include <condition_variable>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "fci/request_channel.h"
#include "twin/core/error.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/hand_state_id.h"
#include "twin/fci/requests.h"

namespace twin::fci {
namespace {

constexpr std::size_t kRemembered = 8;
/// Longest frame of an answer, bytes: Connect's.
constexpr std::size_t kLargestHandAnswer = 14;
/// Time for the answers to an aborted command and to Stop.
constexpr Duration kAtOnce = std::chrono::seconds(1);
constexpr Duration kNextState = std::chrono::milliseconds(100);

std::vector<std::byte> Encoded(HandDevice device, std::uint32_t id, const HandRequest& request) {
  return device == HandDevice::kCobotPump ? EncodeVacuumRequest(id, request)
                                          : EncodeRequest(id, request);
}

/// Reads a state of either device. @returns whether it is one.
bool DecodeState(HandDevice device, std::span<const std::byte> bytes, HandState& state) {
  if (device == HandDevice::kFrankaHand) return Decode(bytes, state) == DatagramFault::kNone;
  VacuumState& pump = state.pump.emplace();
  if (Decode(bytes, pump) != DatagramFault::kNone) return false;
  state.message_id = pump.message_id;
  state.is_grasped = pump.part_present;
  return true;
}

}  // namespace

/// Holds the newest state; the channel's reader thread fills it.
class HandClient::Mailbox {
 public:
  Mailbox(HandDevice device, std::uint32_t robot, const Endpoint& local, Capture* capture)
      : device_(device), robot_(robot), capture_(capture), socket_(clock_, local) {}

  [[nodiscard]] std::uint16_t port() const noexcept { return socket_.local().port; }
  [[nodiscard]] int fd() const noexcept { return socket_.fd(); }

  void Drain() {
    std::array<std::byte, kHandStateBytes> bytes{};
    while (const std::optional<Datagram> datagram = socket_.Receive(bytes)) {
      Keep(*datagram);
      HandState state;
      if (!IsFromHand(datagram->from)) continue;
      if (!DecodeState(device_, datagram->bytes, state)) continue;
      if (!from_) socket_.ListenOnlyTo(from_.emplace(datagram->from));
      const std::lock_guard lock(mutex_);
      if (newest_ && !IsNewer(state.message_id, newest_->message_id)) continue;
      newest_ = state;
      has_fresh_ = true;
      came_.notify_all();
    }
  }
  /// Marks the newest state as old, because the hand has acted since.
  void Age() {
    const std::lock_guard lock(mutex_);
    has_fresh_ = false;
  }
  /// @param first  timeout while no state has ever arrived.
  std::optional<HandState> Await(Duration first) {
    std::unique_lock lock(mutex_);
    came_.wait_for(lock, newest_ ? kNextState : first, [this] { return has_fresh_; });
    has_fresh_ = newest_.has_value();  // after a timeout, the next call does not wait again
    return newest_;
  }

 private:
  [[nodiscard]] bool IsFromHand(const Endpoint& from) const noexcept {
    return from_ ? from == *from_ : from.address == robot_;
  }
  void Keep(const Datagram& datagram) {
    if (capture_ == nullptr) return;
    capture_->Put({.at = capture_->TimeOf(clock_, datagram.at),
                   .transport = record::Transport::kUdp,
                   .from = datagram.from,
                   .to = socket_.local(),
                   .bytes = datagram.bytes});
  }

  const HandDevice device_;
  const std::uint32_t robot_;
  Capture* const capture_;
  // An own clock, because another one may be restarted while this thread receives.
  const MonotonicClock clock_;
  UdpSocket socket_;
  std::optional<Endpoint> from_;  ///< source of all states; owned by the reader thread
  std::mutex mutex_;
  std::condition_variable came_;
  std::optional<HandState> newest_;  ///< guarded by mutex_
  bool has_fresh_ = false;           ///< guarded by mutex_
};

HandClient::HandClient(const std::string& host, std::uint16_t port, const ClientTimeout& timeout,
                       Capture* capture, HandDevice device)
    : timeout_(timeout), device_(device), name_(fmt::format("the hand {}:{}", host, port)) {
  const Endpoint hand = Resolve(host, port);
  TcpStream stream = TcpStream::Connect(hand, timeout.connect);
  states_ =
      std::make_unique<Mailbox>(device, hand.address, Endpoint{stream.local().address, 0}, capture);
  channel_ = std::make_unique<RequestChannel>(
      HeadKind::kHand, std::move(stream), name_, kLargestHandAnswer, timeout.answer, capture,
      SideSocket{states_->fd(), [this] { states_->Drain(); }});
  Negotiate(states_->port());
}

HandClient::~HandClient() = default;

void HandClient::Negotiate(std::uint16_t udp_port) {
  constexpr std::string_view kName = "Connect";
  const HandRequest request = Connect{VersionOf(device_), udp_port};
  const std::uint32_t id =
      channel_->Send(kName, [&](std::uint32_t own) { return Encoded(device_, own, request); });
  const auto bytes = channel_->Await(id, kName, timeout_.connect);
  channel_->Forget(id);
  if (!bytes) {
    throw RobotFault(fmt::format("Connect: {} has not answered for {} s; see whether it still runs",
                                 name_, ToSeconds(timeout_.connect)));
  }
  const auto answer = ParseHandAnswer(HandCommandId::kConnect, bytes->frame());
  if (const auto* bad = std::get_if<BadFrame>(&answer)) {
    throw RobotFault(fmt::format("Connect: {} sends an answer that is none: {}", name_, bad->what));
  }
  const HandAnswer& read = std::get<HandAnswer>(answer);
  if (read.result == HandResult::kSuccess) return;
  throw RobotFault(
      fmt::format("Connect: {} speaks version {} of its interface, this program version {}; update "
                  "whichever is older",
                  name_, read.version, VersionOf(device_)));
}

HandTicket HandClient::Start(const HandCommand& command) {
  const std::lock_guard lock(mutex_);
  const HandRequest request = command;
  const HandTicket ticket = channel_->Send(
      twin::Name(command), [&](std::uint32_t id) { return Encoded(device_, id, request); });
  for (Sent& before : sent_) Update(before, kAtOnce);
  sent_.push_back({ticket, {}});
  if (std::holds_alternative<hand::Stop>(command)) Update(sent_.back(), kAtOnce);
  while (sent_.size() > kRemembered) {
    channel_->Forget(sent_.front().ticket);
    sent_.pop_front();
  }
  return ticket;
}

void HandClient::Update(Sent& sent, Duration timeout) {
  if (sent.result) return;
  const auto bytes = channel_->Await(sent.ticket, "the hand's command", timeout);
  if (!bytes) return;
  channel_->Forget(sent.ticket);
  // All hand answers have one layout; the id tells them apart.
  const auto answer = ParseHandAnswer(HandCommandId::kMove, bytes->frame());
  const auto* read = std::get_if<HandAnswer>(&answer);
  sent.result = read == nullptr ? HandResult::kFail : read->result;
  states_->Age();
}

std::optional<HandResult> HandClient::Outcome(HandTicket ticket) {
  const std::lock_guard lock(mutex_);
  for (Sent& sent : sent_) {
    if (sent.ticket != ticket) continue;
    Update(sent, Duration::zero());
    return sent.result;
  }
  return HandResult::kAborted;
}

HandState HandClient::State() {
  if (channel_->lost()) throw RobotFault(channel_->WhyLost());
  const std::optional<HandState> state = states_->Await(timeout_.state);
  if (state) return *state;
  throw RobotFault(fmt::format("no state of {} has come for {} s; does a firewall stop UDP?", name_,
                               ToSeconds(timeout_.state)));
}

}  // namespace twin::fci
