#include "twin/server/single_client_acceptor.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::server {
namespace {

/// Pending connections without a request; at the limit the oldest is reset, so that silent ones do
/// not block new ones.
constexpr std::size_t kMostPending = 16;
/// Requests of one client handled before other connections get a turn.
constexpr int kMostRequests = 64;

constexpr Duration kOrdinaryTimeout = std::chrono::milliseconds(100);
constexpr Duration kPollPeriod = std::chrono::milliseconds(5);

}  // namespace

SingleClientAcceptor::SingleClientAcceptor(const Settings& settings, RequestHandler& handler,
                                           const TellPeople& tell)
    : settings_(settings), listener_(settings.local), handler_(handler), tell_(tell) {}

void SingleClientAcceptor::Tell(const fci::Endpoint& whom, std::string_view what) const {
  tell_(fmt::format("{}: {} {}", settings_.name, fci::ToString(whom), what));
}

void SingleClientAcceptor::AddTo(std::vector<pollfd>& waited) const {
  waited.push_back({listener_.fd(), POLLIN, 0});
  for (const PendingClient& pending : pending_) {
    if (!pending.first) waited.push_back({pending.connection->fd(), POLLIN, 0});
  }
  if (client_ == nullptr) return;
  const int events = client_->has_unsent() ? POLLIN | POLLOUT : POLLIN;
  waited.push_back({client_->fd(), static_cast<short>(events), 0});
}

Duration SingleClientAcceptor::poll_timeout() const {
  const bool one_waits = std::ranges::any_of(
      pending_, [](const PendingClient& pending) { return pending.first.has_value(); });
  if (one_waits) return kPollPeriod;
  return client_ != nullptr ? std::min(handler_.poll_timeout(), kOrdinaryTimeout)
                            : kOrdinaryTimeout;
}

void SingleClientAcceptor::Serve(Time now) {
  ServeClient(now);
  Accept(now);
  std::erase_if(pending_, [&](PendingClient& pending) { return Receive(pending, now); });
}

void SingleClientAcceptor::Accept(Time now) {
  try {
    while (auto stream = listener_.Accept()) {
      if (!Admits(stream->peer())) {
        Tell(stream->peer(), "refused: its address is not allowed (see --allow)");
        stream->ResetConnection();
        continue;
      }
      if (pending_.size() >= kMostPending) DropSilent();
      pending_.push_back({std::make_unique<Connection>(std::move(*stream), settings_.kind,
                                                       settings_.largest, now, settings_.tap),
                          {}});
    }
  } catch (const EnvironmentError& error) {
    tell_(fmt::format("{}: {}", settings_.name, error.what()));
  }
}

void SingleClientAcceptor::DropSilent() {
  auto dropped = std::ranges::find_if(
      pending_, [](const PendingClient& pending) { return !pending.first.has_value(); });
  if (dropped == pending_.end()) dropped = pending_.begin();
  Tell(dropped->connection->peer(), "dropped: too many connections wait, and it has for longest");
  dropped->connection->Reset();
  pending_.erase(dropped);
}

bool SingleClientAcceptor::Admits(const fci::Endpoint& peer) const noexcept {
  if (fci::IsLoopback(peer.address)) return true;
  return settings_.allow && settings_.allow->Contains(peer.address);
}

bool SingleClientAcceptor::Receive(PendingClient& pending, Time now) {
  Connection& connection = *pending.connection;
  if (!pending.first) pending.first = connection.Next();
  if (pending.first) {
    ServeClient(now);  // the client may just have disconnected
    if (client_ != nullptr) {
      Tell(connection.peer(), "refused: another client is connected");
      connection.Reset();
      return true;
    }
    if (!handler_.IsReady()) return false;
    Take(pending);
    return true;
  }
  if (connection.end()) {
    Tell(connection.peer(), fmt::format("left before it connected: {}", *connection.end()));
    connection.Reset();
    return true;
  }
  if (now < connection.since() + settings_.connect_timeout) return false;
  Tell(connection.peer(),
       fmt::format("dropped: no Connect within {} s", ToSeconds(settings_.connect_timeout)));
  connection.Reset();
  return true;
}

void SingleClientAcceptor::Take(PendingClient& pending) {
  client_ = std::move(pending.connection);
  handler_.OnConnect(*client_);
  Handle(*pending.first);
}

void SingleClientAcceptor::Handle(const fci::Frame& frame) {
  const std::size_t answers = client_->answers();
  try {
    const auto why = handler_.OnFrame(frame);
    // A client without an answer is still waiting and must be notified.
    if (why) Disconnect(*why, client_->answers() == answers);
  } catch (const RobotFault& fault) {
    Disconnect(fault.what(), true);
  }
}

void SingleClientAcceptor::ServeClient(Time now) {
  for (int i = 0; i < kMostRequests && client_ != nullptr; ++i) {
    const auto frame = client_->Next();
    if (!frame) break;
    Handle(*frame);
  }
  if (client_ == nullptr) return;
  if (!client_->end()) {
    try {
      if (const auto why = handler_.Poll(now)) return Disconnect(*why, false);
    } catch (const RobotFault& fault) {
      return Disconnect(fault.what(), true);
    }
    client_->Flush();
  }
  if (client_->end()) Disconnect(*client_->end(), true);
}

void SingleClientAcceptor::Disconnect(const std::string& why, bool is_waiting) {
  const bool is_owed = is_waiting || handler_.has_pending();
  const std::unique_ptr<Connection> client = std::move(client_);
  try {
    handler_.OnDisconnect();
  } catch (const RobotFault& fault) {
    tell_(fmt::format("{}: {}", settings_.name, fault.what()));
  }
  Tell(client->peer(), fmt::format("disconnected: {}", why));
  is_owed ? client->Reset() : client->Close();
}

void SingleClientAcceptor::End() {
  for (PendingClient& pending : pending_) pending.connection->Reset();
  pending_.clear();
  if (client_ != nullptr) Disconnect("the service ends", false);
}

}  // namespace twin::server
