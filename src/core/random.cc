#include "twin/core/random.h"

#include <cmath>
#include <numbers>

namespace twin {
namespace {

constexpr std::uint32_t kMultiplier0 = 0xD2511F53u;
constexpr std::uint32_t kMultiplier1 = 0xCD9E8D57u;
constexpr std::uint32_t kWeyl0 = 0x9E3779B9u;
constexpr std::uint32_t kWeyl1 = 0xBB67AE85u;
constexpr int kRounds = 10;

/// 53 of 64 bits as a fraction in [0, 1).
double ToFraction(std::uint32_t high, std::uint32_t low) noexcept {
  const std::uint64_t bits = (std::uint64_t{high} << 32) | low;
  return static_cast<double>(bits >> 11) * 0x1.0p-53;
}

}  // namespace

std::array<std::uint32_t, 4> Random::Bits(std::uint64_t tick, std::uint32_t draw) const noexcept {
  std::array<std::uint32_t, 4> x{static_cast<std::uint32_t>(tick),
                                 static_cast<std::uint32_t>(tick >> 32),
                                 static_cast<std::uint32_t>(stream_), draw};
  std::uint32_t key0 = static_cast<std::uint32_t>(seed_);
  std::uint32_t key1 = static_cast<std::uint32_t>(seed_ >> 32);
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t p0 = std::uint64_t{kMultiplier0} * x[0];
    const std::uint64_t p1 = std::uint64_t{kMultiplier1} * x[2];
    x = {static_cast<std::uint32_t>(p1 >> 32) ^ x[1] ^ key0, static_cast<std::uint32_t>(p1),
         static_cast<std::uint32_t>(p0 >> 32) ^ x[3] ^ key1, static_cast<std::uint32_t>(p0)};
    key0 += kWeyl0;
    key1 += kWeyl1;
  }
  return x;
}

double Random::Uniform(std::uint64_t tick, std::uint32_t draw) const noexcept {
  const auto bits = Bits(tick, draw);
  return ToFraction(bits[0], bits[1]);
}

double Random::Normal(std::uint64_t tick, std::uint32_t draw) const noexcept {
  const auto bits = Bits(tick, draw);
  const double u = 1.0 - ToFraction(bits[0], bits[1]);  // in (0, 1], so the logarithm is finite
  const double v = ToFraction(bits[2], bits[3]);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

}  // namespace twin
