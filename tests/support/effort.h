#pragma once

#include <cstdint>

namespace twin::test {

/// How often a test repeats something: a tenth as often under ThreadSanitizer, which is that much
/// slower, and needs to meet two accesses only once to see that nothing orders them.
[[nodiscard]] constexpr std::uint64_t Repetitions(std::uint64_t full) {
#ifdef __SANITIZE_THREAD__
  return full / 10;
#else
  return full;
#endif
}

}  // namespace twin::test
