#include <cstddef>
#include <cstdint>
#include <span>

#include "fuzz/device_targets.h"
#include "fuzz/fci_targets.h"

/// Entry of libFuzzer for the target of this program, which TWIN_FUZZ_TARGET names in full.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  TWIN_FUZZ_TARGET(std::as_bytes(std::span(data, size)));
  return 0;
}
