#include "twin/core/hash.h"

#include <cmath>

#include <fmt/format.h>

namespace twin {

std::uint64_t LibmFingerprint() {
  constexpr int kPoints = 4096;
  WordHash hash;
  // volatile: keeps the compiler from computing these values.
  volatile double x = 0;
  for (int i = 1; i <= kPoints; ++i) {
    x = i * 0.0037 - 7.3;
    hash.AddNumber(std::sin(x));
    hash.AddNumber(std::cos(x));
    hash.AddNumber(std::exp(x));
    hash.AddNumber(std::log(x * x + 0.1));
    hash.AddNumber(std::pow(x * x + 0.1, 0.37));
    hash.AddNumber(std::atan2(x, 0.7));
  }
  return hash.value();
}

std::string FormatHash(std::uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

}  // namespace twin
