#pragma once

#include <cstddef>
#include <list>

#include <boost/asio/ip/tcp.hpp>

#include "page/visitor.h"
#include "page/web_server.h"

namespace twin::page {

/// What can be dropped to make room for others. Threads: the server's.
class Droppable {
 public:
  virtual ~Droppable() = default;
  /// Ends the connection at once.
  virtual void Drop() = 0;
};

/// What all connections of a server share. Threads: the server's.
struct ConnectionHouse {
  const WebConfig& config;
  Visitors& visitors;
  std::list<Droppable*> strangers{};  ///< that have not shown the token, the oldest first
  std::size_t trusted = 0;            ///< connections that have
};

/// A connection's place in the house, which goes from a request for files to the WebSocket that it
/// becomes. A stranger's is taken from it when it is dropped.
class Place {
 public:
  Place(ConnectionHouse& house, Droppable& of)
      : house_(house), at_(house.strangers.insert(house.strangers.end(), &of)) {}
  ~Place() { Leave(); }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

  /// @pre a stranger's.
  void PassTo(Droppable& next) noexcept { *at_ = &next; }
  void Trust() {
    if (kind_ != Kind::kStranger) return;
    Leave();
    ++house_.trusted;
    kind_ = Kind::kTrusted;
  }
  void Leave() {
    if (kind_ == Kind::kStranger) house_.strangers.erase(at_);
    if (kind_ == Kind::kTrusted) --house_.trusted;
    kind_ = Kind::kGone;
  }

 private:
  enum class Kind : std::uint8_t { kStranger, kTrusted, kGone };

  ConnectionHouse& house_;
  std::list<Droppable*>::iterator at_;
  Kind kind_ = Kind::kStranger;
};

/// Serves a browser that has connected, until it goes: requests for files, one after the other, or
/// a WebSocket. When so many have shown the token that no further one is served, it is told so;
/// when there are too many that have not, the oldest of them is dropped.
/// @param house  must outlive the executor's work.
void ServeConnection(boost::asio::ip::tcp::socket socket, ConnectionHouse& house);

}  // namespace twin::page
