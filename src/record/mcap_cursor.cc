#include "record/mcap_cursor.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::record::mcap {

std::span<const std::byte> Cursor::TakeBytes(std::uint64_t count) {
  if (count > remaining()) {
    Fail(fmt::format("a field of {} bytes in a record with {} left", count, remaining()));
  }
  const auto taken = bytes_.subspan(at_, static_cast<std::size_t>(count));
  at_ += taken.size();
  return taken;
}

std::string_view Cursor::TakeString() {
  const auto bytes = TakeBytes(Take<std::uint32_t>());
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TextMap Cursor::TakeMap() {
  const std::uint64_t start = offset();
  Cursor entries(TakeBytes(Take<std::uint32_t>()), *where_, start + sizeof(std::uint32_t));
  TextMap map;
  while (entries.remaining() > 0) {
    const std::string_view key = entries.TakeString();
    const std::string_view value = entries.TakeString();
    if (!map.emplace(key, value).second) entries.Fail(fmt::format("key '{}' comes twice", key));
  }
  return map;
}

void Cursor::Fail(const std::string& what) const {
  FailDamaged(*where_, offset(), what);
}

void FailDamaged(const std::string& where, std::uint64_t offset, const std::string& what) {
  throw InputError(
      fmt::format("{} is damaged at byte {}: {}; record the run again", where, offset, what));
}

}  // namespace twin::record::mcap
