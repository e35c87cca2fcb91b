#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "fuzz/fci_targets.h"
#include "twin/core/random.h"

namespace twin::fci::fuzz {

/// Changes `bytes` in one of the ways in which they break on the way, or are broken.
/// @param round  which of the generator's numbers are used.
inline void Mutate(std::vector<std::byte>& bytes, const Random& random, std::uint64_t round) {
  const auto bits = random.Bits(round);
  if (bytes.empty()) return;
  const std::size_t at = bits[1] % bytes.size();
  const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  switch (bits[0] % 6) {
    case 0: bytes[at] ^= static_cast<std::byte>(1U << bits[2] % 8); break;
    case 1: bytes.resize(at); break;
    case 2: {  // a size, a mode, a flag, or the end of a number that is none
      const std::uint32_t values[] = {0, 1, 2, 12, 0x7FF00000, 0x7FFFFFFF, 0xFFFFFFFF, bits[2]};
      std::memcpy(&bytes[at], &values[bits[3] % 8], std::min<std::size_t>(4, bytes.size() - at));
      break;
    }
    case 3: bytes.erase(place); break;
    case 4: bytes.insert(place, static_cast<std::byte>(bits[2])); break;
    default: {  // a part of it again, as a network repeats one
      const std::vector<std::byte> part(place, bytes.end());
      bytes.insert(bytes.end(), part.begin(), part.end());
    }
  }
}

/// Gives `target` each of `whole` in turn, as it is and changed by one to three mutations.
inline void FeedMutations(Target target, const std::vector<std::vector<std::byte>>& whole,
                          std::uint64_t seed, std::uint64_t rounds) {
  const Random random(seed, RandomStream::kTest);
  for (std::uint64_t round = 0; round < rounds; ++round) {
    std::vector<std::byte> bytes = whole[round % whole.size()];
    target(bytes);
    for (std::uint64_t i = 0; i <= round % 3; ++i) Mutate(bytes, random, 3 * round + i);
    target(bytes);
  }
}

}  // namespace twin::fci::fuzz
