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

/// Whose heads a stream has.
enum class HeadKind : std::uint8_t { kArm, kHand };

/// The bytes of a frame as they came, head and payload.
[[nodiscard]] std::vector<std::byte> BytesOf(HeadKind kind, const Frame& frame);

/// Cuts a TCP stream into frames, however its bytes come: one by one, or several frames at once.
///
/// What it keeps is bounded by the largest frame. A head that announces less than a head, or more
/// than the largest frame, ends the stream: nothing resynchronises it.
///
/// Threads: one. Errors: fault(). Allocates the largest frame when it is made, and fault()'s text.
class FrameReader {
 public:
  /// @param largest  frame that is taken, bytes, head included.
  FrameReader(HeadKind kind, std::size_t largest);

  /// Room for what is received next; never empty unless a frame waits for Next() or the stream has
  /// ended. @post Received(n) tells how much of it was filled.
  [[nodiscard]] std::span<std::byte> Room() noexcept;
  void Received(std::size_t bytes) noexcept;

  /// The next whole frame; nothing: more bytes are needed, or the stream has ended (fault()). The
  /// payload is valid until the next call of Next() or Room().
  [[nodiscard]] std::optional<Frame> Next() noexcept;

  /// Why the stream has ended, for people; null while it has not.
  [[nodiscard]] const std::string* fault() const noexcept;
  /// Whether bytes are kept that Next() has not given away: of an unfinished frame, once Next() has
  /// given nothing.
  [[nodiscard]] bool is_inside_frame() const noexcept;

 private:
  HeadKind kind_;
  std::size_t largest_;
  /// [0, begin_) was given away, [begin_, end_) waits, [end_, largest_) is room.
  std::unique_ptr<std::byte[]> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::string fault_;  ///< empty while there is none
};

}  // namespace twin::fci
