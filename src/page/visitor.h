#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace twin::page {

/// What goes to a browser over the WebSocket.
struct Parcel {
  std::string bytes;
  bool is_text = true;  ///< else a picture
};

/// One and the same goes to many browsers, each of which is done with it at another time.
using SharedParcel = std::shared_ptr<const Parcel>;

/// A browser at the other end of a WebSocket. Threads: the web server's.
class Visitor {
 public:
  virtual ~Visitor() = default;
  /// Queues it. A visitor who takes nothing for seconds, or for whom too much waits, is dropped.
  virtual void Send(SharedParcel parcel) = 0;
  /// Parcels that have not gone out.
  [[nodiscard]] virtual std::size_t waiting() const noexcept = 0;
  /// It has shown the token: it is not dropped to make room for others. Once.
  virtual void Trust() = 0;
  /// Ends the connection, in order. Nothing it says is heard any more.
  virtual void Close(std::string_view reason) = 0;
};

/// Who looks after the visitors. Called on the web server's thread, and never within a call of a
/// Visitor's. Each visitor comes once and goes once.
class Visitors {
 public:
  virtual ~Visitors() = default;
  virtual void OnCome(Visitor& visitor) = 0;
  virtual void OnText(Visitor& visitor, std::string_view text) = 0;
  /// The visitor is no more when this returns.
  virtual void OnGone(Visitor& visitor) = 0;
  /// Regularly: WebConfig::tick.
  virtual void OnTick() = 0;
};

}  // namespace twin::page
