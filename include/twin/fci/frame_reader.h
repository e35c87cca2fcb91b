#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "twin/fci/requests.h"

namespace twin::fci {

/// Kind of frame head in a stream.
enum class HeadKind : std::uint8_t { kArm, kHand };

/// A frame's bytes as received, head and payload.
[[nodiscard]] std::vector<std::byte> BytesOf(HeadKind kind, const Frame& frame);

/// Splits a TCP stream into frames, in whatever pieces its bytes arrive.
///
/// Its memory is bounded by the largest frame. A head with a size below a head's or above the
/// largest frame's ends the stream, which cannot be resynchronised.
///
/// Threads: one. Errors: fault(). The constructor allocates the largest frame; a fault allocates
/// its text.
class FrameReader {
 public:
  /// @param largest  largest accepted frame, bytes, including its head.
  FrameReader(HeadKind kind, std::size_t largest);

  /// Buffer for the next received bytes; empty only if a frame waits for Next() or the stream has
  /// ended. @post Received(n) gives the number of bytes filled.
  [[nodiscard]] std::span<std::byte> Room() noexcept;
  void Received(std::size_t bytes) noexcept;

  /// @returns the next whole frame; nullopt if it is incomplete or the stream has ended (fault()).
  /// The payload is valid until the next call of Next() or Room().
  [[nodiscard]] std::optional<Frame> Next() noexcept;

  /// Why the stream has ended, for users; null while it has not.
  [[nodiscard]] const std::string* fault() const noexcept;
  /// True if bytes are held that Next() has not returned; after Next() gave nullopt, these belong
  /// to an unfinished frame.
  [[nodiscard]] bool is_inside_frame() const noexcept;

 private:
  HeadKind kind_;
  std::size_t largest_;
  /// [0, begin_) is consumed, [begin_, end_) is pending, [end_, largest_) is free.
  std::unique_ptr<std::byte[]> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::string fault_;  ///< empty without a fault
};

}  // namespace twin::fci
