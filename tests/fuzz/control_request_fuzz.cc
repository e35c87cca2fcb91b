#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "twin/core/error.h"
#include "twin/server/control_request.h"

/// Reads any bytes as a request to a control channel: what is read is the same request when written
/// and read again; what is refused is refused in one printable line.
/// Entry of libFuzzer; server_control_request_test calls it too.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace twin::server;
  const std::string_view line(reinterpret_cast<const char*>(data), size);
  try {
    const ControlRequest request = ParseControlRequest(line);
    if (ParseControlRequest(ToLine(request)) != request) std::abort();
  } catch (const twin::InputError& error) {
    const std::string_view why = error.what();
    if (why.empty() || std::ranges::any_of(why, [](char c) { return c < ' ' || c > '~'; })) {
      std::abort();
    }
  }
  return 0;
}
