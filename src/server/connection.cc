#include "twin/server/connection.h"

#include <utility>

#include <fmt/format.h>

namespace twin::server {

Connection::Connection(fci::TcpStream stream, fci::HeadKind kind, std::size_t largest, Time since,
                       const Tap& tap)
    : stream_(std::move(stream)),
      peer_(stream_.peer()),
      since_(since),
      reader_(kind, largest),
      tap_(tap) {}

std::optional<fci::Frame> Connection::Next() {
  if (end_) return {};
  auto frame = reader_.Next();
  if (!frame && reader_.fault() == nullptr && Receive()) frame = reader_.Next();
  if (!frame && reader_.fault() != nullptr) end_ = *reader_.fault();
  return frame;
}

bool Connection::Receive() {
  std::size_t received = 0;
  const std::span<std::byte> room = reader_.Room();
  switch (stream_.Receive(room, received)) {
    case fci::StreamResult::kDone:
      Keep(peer_, stream_.local(), room.first(received));
      reader_.Received(received);
      return true;
    case fci::StreamResult::kPending: break;
    case fci::StreamResult::kClosed: end_ = "the client has closed the connection"; break;
    case fci::StreamResult::kReset: Break(); break;
  }
  return false;
}

void Connection::Send(std::span<const std::byte> bytes) {
  ++answers_;
  if (unsent_.size() + bytes.size() > kMostUnsent) {
    end_ =
        fmt::format("the client does not read its answers; {} bytes of them wait", unsent_.size());
    return;
  }
  Keep(stream_.local(), peer_, bytes);
  unsent_.insert(unsent_.end(), bytes.begin(), bytes.end());
  Flush();
}

void Connection::Flush() {
  if (unsent_.empty()) return;
  std::size_t sent = 0;
  switch (stream_.Send(unsent_, sent)) {
    case fci::StreamResult::kDone:
    case fci::StreamResult::kPending: break;
    case fci::StreamResult::kClosed:
    case fci::StreamResult::kReset: return Break();
  }
  unsent_.erase(unsent_.begin(), unsent_.begin() + static_cast<std::ptrdiff_t>(sent));
}

void Connection::Break() {
  end_ = "the connection broke";
  is_broken_ = true;
}

void Connection::Keep(const fci::Endpoint& from, const fci::Endpoint& to,
                      std::span<const std::byte> bytes) {
  if (tap_.capture == nullptr) return;
  tap_.capture->Put({.at = tap_.clock->Now(),
                     .transport = record::Transport::kTcp,
                     .from = from,
                     .to = to,
                     .bytes = bytes});
}

}  // namespace twin::server
