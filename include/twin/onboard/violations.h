#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "twin/core/robot_errors.h"

namespace twin::onboard {

/// The violations of one cycle; of each error the first joint or axis that broke it. A value type.
/// Threads: one. Real-time: noexcept, O(1); beyond its capacity, more than a cycle can raise,
/// violations are not kept.
class Violations {
 public:
  void Add(const Violation& violation) noexcept {
    if (size_ < items_.size()) items_[size_++] = violation;
  }
  void Add(const Violations& more) noexcept {
    for (const Violation& violation : more.items()) Add(violation);
  }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] std::span<const Violation> items() const noexcept { return {items_.data(), size_}; }

 private:
  std::array<Violation, 12> items_{};
  std::size_t size_ = 0;
};

/// INT compares with this relative tolerance, so that a stream that goes to a limit exactly is not
/// refused for rounding.
inline constexpr double kLimitTolerance = 1e-9;

}  // namespace twin::onboard
