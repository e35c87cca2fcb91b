#include "twin/core/content_hash.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

#include <fmt/format.h>

namespace twin {
namespace {

constexpr std::uint64_t kC1 = 0x87c37b91114253d5u;
constexpr std::uint64_t kC2 = 0x4cf5ad432745937fu;
constexpr std::size_t kBlock = 16;

std::uint64_t MixK1(std::uint64_t k) noexcept {
  return std::rotl(k * kC1, 31) * kC2;
}

std::uint64_t MixK2(std::uint64_t k) noexcept {
  return std::rotl(k * kC2, 33) * kC1;
}

std::uint64_t Finish(std::uint64_t k) noexcept {
  k ^= k >> 33;
  k *= 0xff51afd7ed558ccdu;
  k ^= k >> 33;
  k *= 0xc4ceb9fe1a85ec53u;
  return k ^ (k >> 33);
}

/// Up to 16 bytes as two little-endian words, zero-filled.
std::array<std::uint64_t, 2> Words(const char* bytes, std::size_t size) noexcept {
  std::array<std::uint64_t, 2> words{};
  std::memcpy(words.data(), bytes, size);
  return words;
}

}  // namespace

void ContentHash::Add(std::string_view bytes) noexcept {
  const std::size_t whole = bytes.size() / kBlock * kBlock;
  for (std::size_t i = 0; i < whole; i += kBlock) {
    const auto k = Words(bytes.data() + i, kBlock);
    h1_ = (std::rotl(h1_ ^ MixK1(k[0]), 27) + h2_) * 5 + 0x52dce729u;
    h2_ = (std::rotl(h2_ ^ MixK2(k[1]), 31) + h1_) * 5 + 0x38495ab5u;
  }
  const auto tail = Words(bytes.data() + whole, bytes.size() - whole);
  h2_ ^= MixK2(tail[1]);
  h1_ ^= MixK1(tail[0]);
  h1_ ^= bytes.size();
  h2_ ^= bytes.size();
  h1_ += h2_;
  h2_ += h1_;
  h1_ = Finish(h1_);
  h2_ = Finish(h2_);
  h1_ += h2_;
  h2_ += h1_;
}

std::string ContentHash::Hex() const {
  return fmt::format("{:016x}{:016x}", h1_, h2_);
}

}  // namespace twin
