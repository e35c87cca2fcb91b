#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <variant>

#include "page/message.h"

/// Reads any text as a message of a browser's: it is one, with values in range, or it is none.
/// Entry of libFuzzer; page_fuzz_test calls it too.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace twin::page;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::optional<Message> said = ParseMessage(text);
  if (said && std::holds_alternative<message::Hands>(*said)) {
    for (const double axis : std::get<message::Hands>(*said).axes) {
      if (!(std::abs(axis) <= 1)) std::abort();
    }
  }
  if (Quoted(text).size() < 2) std::abort();
  return 0;
}
