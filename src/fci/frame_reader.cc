#include "twin/fci/frame_reader.h"

#include <cstring>

#include <fmt/format.h>

#include "fci/frame_bytes.h"
#include "twin/core/error.h"

namespace twin::fci {

FrameReader::FrameReader(HeadKind kind, std::size_t largest)
    : kind_(kind),
      largest_(largest),
      // Not initialised, so that the system commits no pages for the unused part of up to 16 MiB.
      buffer_(std::make_unique_for_overwrite<std::byte[]>(largest)) {
  TWIN_CHECK(largest >= HeadBytes(kind));
}

std::span<std::byte> FrameReader::Room() noexcept {
  if (!fault_.empty()) return {};
  if (begin_ > 0) {
    std::memmove(buffer_.get(), buffer_.get() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  return {buffer_.get() + end_, largest_ - end_};
}

void FrameReader::Received(std::size_t bytes) noexcept {
  TWIN_CHECK(bytes <= largest_ - end_);
  end_ += bytes;
}

std::optional<Frame> FrameReader::Next() noexcept {
  const std::size_t head_bytes = HeadBytes(kind_);
  const std::span<const std::byte> waiting(buffer_.get() + begin_, end_ - begin_);
  if (!fault_.empty() || waiting.size() < head_bytes) return {};
  const FrameHead head = ReadHead(kind_, waiting);
  if (head.size < head_bytes || head.size > largest_) {
    fault_ =
        fmt::format("a frame (command {}, id {}) says that it has {} bytes; it may have {} to {}",
                    head.command, head.command_id, head.size, head_bytes, largest_);
    return {};
  }
  if (waiting.size() < head.size) return {};
  begin_ += head.size;
  return Frame{head, waiting.subspan(head_bytes, head.size - head_bytes)};
}

const std::string* FrameReader::fault() const noexcept {
  return fault_.empty() ? nullptr : &fault_;
}

bool FrameReader::is_inside_frame() const noexcept {
  return end_ > begin_;
}

}  // namespace twin::fci
