#pragma once

#include <cstdint>

#include "twin/core/random.h"

namespace twin::test {

/// Draws one after the other: a sequence that its seed alone determines.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed, RandomStream::kTest) {}

  /// In [0, 1).
  double Uniform() { return random_.Uniform(next_++); }
  /// In [low, high).
  double Between(double low, double high) { return low + (high - low) * Uniform(); }
  /// In [low, high], whole.
  int Whole(int low, int high) { return low + static_cast<int>(Uniform() * (high - low + 1)); }
  bool Chance(double share) { return Uniform() < share; }
  /// 1 with a relative change whose magnitude is log-uniform in [1e-8, 1e-2], either way.
  double NearlyOne();
  /// Log-uniform in [low, high), either sign.
  double Magnitude(double low, double high);

 private:
  Random random_;
  std::uint64_t next_ = 0;
};

}  // namespace twin::test
