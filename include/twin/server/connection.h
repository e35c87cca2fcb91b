#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/fci/capture.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/sockets.h"

namespace twin::server {

/// Destination for a copy of all traffic.
struct Tap {
  fci::Capture* capture = nullptr;  ///< null: no copy
  const Clock* clock = nullptr;     ///< the capture's clock; null without a capture
};

/// A client's TCP connection: frames in, answers out; no call blocks. Memory is bounded: input by
/// the largest request; output, for clients that do not read, by kMostUnsent.
///
/// Threads: one.
class Connection {
 public:
  /// @param since  time of acceptance. @param largest  largest accepted frame, bytes.
  /// @param tap  its pointers must outlive the connection.
  Connection(fci::TcpStream stream, fci::HeadKind kind, std::size_t largest, Time since,
             const Tap& tap);

  [[nodiscard]] int fd() const noexcept { return stream_.fd(); }
  [[nodiscard]] const fci::Endpoint& peer() const noexcept { return peer_; }
  [[nodiscard]] const fci::Endpoint& local() const noexcept { return stream_.local(); }
  [[nodiscard]] Time since() const noexcept { return since_; }

  /// @returns the next whole frame, receiving if none is buffered; its payload is valid until the
  /// next call.
  [[nodiscard]] std::optional<fci::Frame> Next();

  /// Sends what the socket takes and buffers the rest.
  void Send(std::span<const std::byte> bytes);
  void Flush();
  [[nodiscard]] bool has_unsent() const noexcept { return !unsent_.empty(); }
  /// Answers sent or buffered so far.
  [[nodiscard]] std::size_t answers() const noexcept { return answers_; }

  /// Why the connection has ended; nullopt while it is open.
  [[nodiscard]] const std::optional<std::string>& end() const noexcept { return end_; }
  /// True if it ended abnormally (RST, timeout).
  [[nodiscard]] bool is_broken() const noexcept { return is_broken_; }

  /// Close() is graceful: buffered data still arrives. Reset() tells a client that waits for an
  /// answer.
  void Close() noexcept { stream_.Close(); }
  void Reset() noexcept { stream_.ResetConnection(); }

 private:
  static constexpr std::size_t kMostUnsent = std::size_t{1} << 20;

  /// @returns true if bytes were received.
  bool Receive();
  void Break();
  void Keep(const fci::Endpoint& from, const fci::Endpoint& to, std::span<const std::byte> bytes);

  fci::TcpStream stream_;
  fci::Endpoint peer_;
  Time since_;
  fci::FrameReader reader_;
  Tap tap_;
  std::vector<std::byte> unsent_;
  std::size_t answers_ = 0;
  std::optional<std::string> end_;
  bool is_broken_ = false;
};

}  // namespace twin::server
