#pragma once

#include <cstddef>
#include <list>

#include <boost/asio/ip/tcp.hpp>

#include "page/connection.h"
#include "page/web_server.h"

namespace twin::page {

/// A connection that can be dropped to make room for others. Threads: the server's.
class Droppable {
 public:
  virtual ~Droppable() = default;
  /// Ends the connection at once.
  virtual void Drop() = 0;
};

/// State shared by all connections of a server. Threads: the server's.
struct ConnectionPool {
  const WebConfig& config;
  ConnectionListener& listener;
  std::list<Droppable*> unauthenticated{};  ///< without a token so far, oldest first
  std::size_t authenticated = 0;            ///< number of connections with the token
};

/// A connection's entry in the pool. An HTTP connection that becomes a WebSocket passes its entry
/// on.
class PoolEntry {
 public:
  PoolEntry(ConnectionPool& pool, Droppable& of)
      : pool_(pool), at_(pool.unauthenticated.insert(pool.unauthenticated.end(), &of)) {}
  ~PoolEntry() { Leave(); }
  PoolEntry(const PoolEntry&) = delete;
  PoolEntry& operator=(const PoolEntry&) = delete;

  /// @pre the connection is unauthenticated.
  void PassTo(Droppable& next) noexcept { *at_ = &next; }
  void Authenticate() {
    if (kind_ != Kind::kUnauthenticated) return;
    Leave();
    ++pool_.authenticated;
    kind_ = Kind::kAuthenticated;
  }
  void Leave() {
    if (kind_ == Kind::kUnauthenticated) pool_.unauthenticated.erase(at_);
    if (kind_ == Kind::kAuthenticated) --pool_.authenticated;
    kind_ = Kind::kGone;
  }

 private:
  enum class Kind : std::uint8_t { kUnauthenticated, kAuthenticated, kGone };

  ConnectionPool& pool_;
  std::list<Droppable*>::iterator at_;
  Kind kind_ = Kind::kUnauthenticated;
};

/// Serves a browser until it disconnects: HTTP requests for files, or a WebSocket. At the limit of
/// authenticated connections it answers HTTP 503; at the limit of unauthenticated ones it drops the
/// oldest.
/// @param pool  must outlive the executor's work.
void ServeConnection(boost::asio::ip::tcp::socket socket, ConnectionPool& pool);

}  // namespace twin::page
