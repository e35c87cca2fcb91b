#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "record/mcap_format.h"

namespace twin::record::mcap {

/// Reads the fields of records from untrusted bytes: every access is checked; a failure is an
/// InputError with the offset.
class Cursor {
 public:
  /// @param where  origin of the offsets in messages: a file, or a chunk of one. Must outlive the
  /// cursor.
  /// @param offset  of the first byte.
  Cursor(std::span<const std::byte> bytes, const std::string& where, std::uint64_t offset)
      : bytes_(bytes), where_(&where), begin_(offset) {}

  template <typename Integer>
  [[nodiscard]] Integer Take() {
    Integer value{};
    std::memcpy(&value, TakeBytes(sizeof(Integer)).data(), sizeof(Integer));
    return value;
  }
  [[nodiscard]] std::span<const std::byte> TakeBytes(std::uint64_t count);
  /// Reads a text with a 32-bit length prefix.
  [[nodiscard]] std::string_view TakeString();
  /// Reads a map of texts. A repeated key is an error.
  [[nodiscard]] TextMap TakeMap();

  [[nodiscard]] std::uint64_t offset() const { return begin_ + at_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - at_; }

  /// @throws InputError: the file is damaged at `offset`, because of `what`.
  [[noreturn]] void Fail(const std::string& what) const;

 private:
  std::span<const std::byte> bytes_;
  const std::string* where_;
  std::uint64_t begin_;
  std::size_t at_ = 0;
};

/// @throws InputError: `where` is damaged at byte `offset`.
[[noreturn]] void FailDamaged(const std::string& where, std::uint64_t offset,
                              const std::string& what);

}  // namespace twin::record::mcap
