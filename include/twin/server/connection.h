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

/// Where a copy of what comes and goes is kept.
struct Tap {
  fci::Capture* capture = nullptr;  ///< null: nowhere
  const Clock* clock = nullptr;     ///< of the capture; null with it
};

/// A client's TCP connection: frames in, answers out, nothing waits. What is kept is bounded: in,
/// by the largest request; out, by kMostUnsent, for clients that do not read.
///
/// Threads: one.
class Connection {
 public:
  /// @param since  when it was accepted. @param largest  frame that is taken.
  /// @param tap  what it points to must outlive the connection.
  Connection(fci::TcpStream stream, fci::HeadKind kind, std::size_t largest, Time since,
             const Tap& tap);

  [[nodiscard]] int fd() const noexcept { return stream_.fd(); }
  [[nodiscard]] const fci::Endpoint& peer() const noexcept { return peer_; }
  [[nodiscard]] const fci::Endpoint& local() const noexcept { return stream_.local(); }
  [[nodiscard]] Time since() const noexcept { return since_; }

  /// The next whole frame of what has come; its payload is valid until the next call. Receives when
  /// there is none yet.
  [[nodiscard]] std::optional<fci::Frame> Next();

  /// Sends as much as goes, the rest later.
  void Send(std::span<const std::byte> bytes);
  void Flush();
  [[nodiscard]] bool has_unsent() const noexcept { return !unsent_.empty(); }
  /// Answers that were given so far.
  [[nodiscard]] std::size_t answers() const noexcept { return answers_; }

  /// Why nothing can come or go any more; absent while it can.
  [[nodiscard]] const std::optional<std::string>& end() const noexcept { return end_; }
  /// Whether that is because it broke (RST, timeout).
  [[nodiscard]] bool is_broken() const noexcept { return is_broken_; }

  /// In order (what was sent is on its way), or broken, so that who waits for an answer knows.
  void Close() noexcept { stream_.Close(); }
  void Reset() noexcept { stream_.ResetConnection(); }

 private:
  static constexpr std::size_t kMostUnsent = std::size_t{1} << 20;

  /// @returns whether bytes came.
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
