#include <cstdint>

#include "fuzz/fci_targets.h"

/// Entry of libFuzzer for the target of this program, which TWIN_FUZZ_TARGET names.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  twin::fci::fuzz::TWIN_FUZZ_TARGET(std::as_bytes(std::span(data, size)));
  return 0;
}
