#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace twin {

/// Hash of a sequence of byte strings, for keys of caches and results and the integrity of cached
/// files; not secure against adversaries. MurmurHash3 x64 128 (Appleby, public domain), chained:
/// each string's digest and length seed the next one.
class ContentHash {
 public:
  /// Adds one string; its boundaries count: ("ab", "c") differs from ("a", "bc").
  void Add(std::string_view bytes) noexcept;

  /// @returns 32 hexadecimal digits.
  [[nodiscard]] std::string Hex() const;

 private:
  std::uint64_t h1_ = 0;
  std::uint64_t h2_ = 0;
};

}  // namespace twin
