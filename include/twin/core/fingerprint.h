#pragma once

#include <cstdint>
#include <string>

namespace twin {

/// Identifies the variant of the C library's mathematics: a hash of sin, cos, exp, log, pow, atan2
/// at fixed points. glibc selects code with different last bits on processors with and without
/// fused multiply-add; runs repeat bit by bit only within one variant.
[[nodiscard]] std::uint64_t LibmFingerprint();

/// @returns 16 hexadecimal digits.
[[nodiscard]] std::string FormatHash(std::uint64_t hash);

}  // namespace twin
