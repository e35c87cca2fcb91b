#pragma once

#include <cstddef>
#include <fstream>
#include <string>

namespace twin::test {

/// Forgets how much memory this process had resident at most.
inline void ResetPeakMemory() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

/// The most memory this process had resident since the last reset, bytes.
inline std::size_t PeakMemory() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    std::size_t kilobytes = 0;
    if (word == "VmHWM:" && status >> kilobytes) return 1024 * kilobytes;
  }
  return 0;
}

}  // namespace twin::test
