#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>

#include "twin/core/robot_errors.h"

namespace twin::onboard {

/// Violations of one cycle; each error with the first joint or axis that broke it. A value type.
/// Threads: one. Real-time: noexcept, O(1). Discards violations beyond its capacity, which exceeds
/// what a cycle can raise.
class Violations {
 public:
  Violations() noexcept {}  // NOLINT(modernize-use-equals-default): leaves items_ unset
  void Add(const Violation& violation) noexcept {
    if (size_ < items_.size()) std::construct_at(&items_[size_++], violation);
  }
  void Add(const Violations& more) noexcept {
    for (const Violation& violation : more.items()) Add(violation);
  }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] std::span<const Violation> items() const& noexcept {
    return {items_.data(), size_};
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  void items() const&& = delete;  ///< they would end with a temporary

 private:
  union {
    std::array<Violation, 12>
        items_;  ///< beyond size_ unset: setting them costs INT 4 % of a cycle
  };
  std::size_t size_ = 0;
};

/// Relative tolerance of INT's comparisons, so that a stream that reaches a limit exactly is not
/// refused because of rounding.
inline constexpr double kLimitTolerance = 1e-9;

}  // namespace twin::onboard
