#include "twin/server/reception.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::server {
namespace {

/// Connections without a request that are kept at once; for a further one the oldest is reset, so
/// that silent ones keep nobody out.
constexpr std::size_t kMostVisitors = 16;
/// Requests of a client that are handled before others have their turn.
constexpr int kMostRequests = 64;

constexpr Duration kOrdinaryTimeout = std::chrono::milliseconds(100);
constexpr Duration kPollPeriod = std::chrono::milliseconds(5);

}  // namespace

Reception::Reception(const Settings& settings, Desk& desk, const TellPeople& tell)
    : settings_(settings), listener_(settings.local), desk_(desk), tell_(tell) {}

void Reception::Tell(const fci::Endpoint& whom, std::string_view what) const {
  tell_(fmt::format("{}: {} {}", settings_.name, fci::ToString(whom), what));
}

void Reception::AddTo(std::vector<pollfd>& waited) const {
  waited.push_back({listener_.fd(), POLLIN, 0});
  for (const Visitor& visitor : visitors_) {
    if (!visitor.first) waited.push_back({visitor.connection->fd(), POLLIN, 0});
  }
  if (client_ == nullptr) return;
  const int events = client_->has_unsent() ? POLLIN | POLLOUT : POLLIN;
  waited.push_back({client_->fd(), static_cast<short>(events), 0});
}

Duration Reception::poll_timeout() const {
  const bool one_waits = std::ranges::any_of(
      visitors_, [](const Visitor& visitor) { return visitor.first.has_value(); });
  if (one_waits) return kPollPeriod;
  return client_ != nullptr ? std::min(desk_.poll_timeout(), kOrdinaryTimeout) : kOrdinaryTimeout;
}

void Reception::Serve(Time now) {
  ServeClient(now);
  Accept(now);
  std::erase_if(visitors_, [&](Visitor& visitor) { return Receive(visitor, now); });
}

void Reception::Accept(Time now) {
  try {
    while (auto stream = listener_.Accept()) {
      if (!Admits(stream->peer())) {
        Tell(stream->peer(), "refused: its address is not allowed (see --allow)");
        stream->ResetConnection();
        continue;
      }
      if (visitors_.size() >= kMostVisitors) DropSilent();
      visitors_.push_back({std::make_unique<Connection>(std::move(*stream), settings_.kind,
                                                        settings_.largest, now, settings_.tap),
                           {}});
    }
  } catch (const EnvironmentError& error) {
    tell_(fmt::format("{}: {}", settings_.name, error.what()));
  }
}

void Reception::DropSilent() {
  auto dropped = std::ranges::find_if(
      visitors_, [](const Visitor& visitor) { return !visitor.first.has_value(); });
  if (dropped == visitors_.end()) dropped = visitors_.begin();
  Tell(dropped->connection->peer(), "dropped: too many connections wait, and it has for longest");
  dropped->connection->Reset();
  visitors_.erase(dropped);
}

bool Reception::Admits(const fci::Endpoint& peer) const noexcept {
  if (fci::IsLoopback(peer.address)) return true;
  return settings_.allow && settings_.allow->Contains(peer.address);
}

bool Reception::Receive(Visitor& visitor, Time now) {
  Connection& connection = *visitor.connection;
  if (!visitor.first) visitor.first = connection.Next();
  if (visitor.first) {
    ServeClient(now);  // the client may have left just before this one came
    if (client_ != nullptr) {
      Tell(connection.peer(), "refused: another client is connected");
      connection.Reset();
      return true;
    }
    if (!desk_.IsReady()) return false;
    Take(visitor);
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

void Reception::Take(Visitor& visitor) {
  client_ = std::move(visitor.connection);
  desk_.Open(*client_);
  Handle(*visitor.first);
}

void Reception::Handle(const fci::Frame& frame) {
  const std::size_t answers = client_->answers();
  try {
    const auto why = desk_.OnFrame(frame);
    // Who was not answered waits, and must be told.
    if (why) Dismiss(*why, client_->answers() == answers);
  } catch (const RobotFault& fault) {
    Dismiss(fault.what(), true);
  }
}

void Reception::ServeClient(Time now) {
  for (int i = 0; i < kMostRequests && client_ != nullptr; ++i) {
    const auto frame = client_->Next();
    if (!frame) break;
    Handle(*frame);
  }
  if (client_ == nullptr) return;
  if (!client_->end()) {
    try {
      if (const auto why = desk_.OnTurn(now)) return Dismiss(*why, false);
    } catch (const RobotFault& fault) {
      return Dismiss(fault.what(), true);
    }
    client_->Flush();
  }
  if (client_->end()) Dismiss(*client_->end(), true);
}

void Reception::Dismiss(const std::string& why, bool is_waiting) {
  const bool is_owed = is_waiting || desk_.has_pending();
  const std::unique_ptr<Connection> client = std::move(client_);
  try {
    desk_.Leave();
  } catch (const RobotFault& fault) {
    tell_(fmt::format("{}: {}", settings_.name, fault.what()));
  }
  Tell(client->peer(), fmt::format("disconnected: {}", why));
  is_owed ? client->Reset() : client->Close();
}

void Reception::End() {
  for (Visitor& visitor : visitors_) visitor.connection->Reset();
  visitors_.clear();
  if (client_ != nullptr) Dismiss("the service ends", false);
}

}  // namespace twin::server
