#pragma once

#include <cstddef>

#include <boost/asio/ip/tcp.hpp>

#include "page/visitor.h"
#include "page/web_server.h"

namespace twin::page {

/// What all connections of a server share. Threads: the server's.
struct ConnectionHouse {
  const WebConfig& config;
  Visitors& visitors;
  std::size_t connections = 0;  ///< that are open
};

/// Serves a browser that has connected, until it goes: requests for files, one after the other, or
/// a WebSocket. When there are too many already, it is told so.
/// @param house  must outlive the executor's work.
void ServeConnection(boost::asio::ip::tcp::socket socket, ConnectionHouse& house);

}  // namespace twin::page
