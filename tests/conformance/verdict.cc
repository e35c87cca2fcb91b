#include "conformance/verdict.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace twin::test {
namespace {

constexpr double kTolerance = 1e-9;  // INT's own, relative
/// Two ways to compute the same bound may differ by so much, relative.
constexpr double kRounding = 1e-12;

/// Whether a violation is what the quantity makes it; a text when it is not.
std::optional<std::string> Compare(const Quantity& quantity, const Violation& violation) {
  const auto told = [&](const char* what) {
    return fmt::format("{}: {} (axis {}, value {:.17g}, limit {})", Name(violation.error), what,
                       violation.axis, violation.value, violation.limit);
  };
  std::size_t axis = 0;
  if (quantity.size > 1) {
    axis = static_cast<std::uint8_t>(violation.axis);
    if (violation.axis < 0 || axis >= quantity.size) return told("no such axis");
  }
  for (std::size_t i = 0; i < axis; ++i) {
    if (quantity.MustBreak(i)) return told("an axis before it is beyond its limit too");
  }
  if (!quantity.MayBreak(axis)) {
    return told(fmt::format("recomputed {:.17g} is allowed", quantity.value[axis]).c_str());
  }
  const double value = quantity.value[axis];
  const bool both_wild = !std::isfinite(value) && !std::isfinite(violation.value);
  const double apart = std::abs(std::abs(violation.value) - std::abs(value));
  if (!both_wild && !(apart <= quantity.noise + 1e-9 * std::abs(value))) {
    return told(fmt::format("recomputed value {:.17g}", value).c_str());
  }
  const double limit = std::abs(violation.limit);
  if (limit != std::abs(quantity.low[axis]) && limit != std::abs(quantity.high[axis])) {
    return told(fmt::format("its limit is {}", quantity.high[axis]).c_str());
  }
  return {};
}

}  // namespace

bool Quantity::MustBreak(std::size_t i) const {
  const double below = low[i] - (kTolerance + kRounding) * std::abs(low[i]) - noise;
  const double above = high[i] + (kTolerance + kRounding) * std::abs(high[i]) + noise;
  return !(value[i] >= below && value[i] <= above);
}

bool Quantity::MayBreak(std::size_t i) const {
  const double below = low[i] - (kTolerance - kRounding) * std::abs(low[i]) + noise;
  const double above = high[i] + (kTolerance - kRounding) * std::abs(high[i]) - noise;
  return !(value[i] >= below && value[i] <= above);
}

Quantity Magnitudes(RobotError error, const JointVector& value, const JointVector& limit,
                    double noise) {
  Quantity quantity{error, kJoints, value, {}, limit, noise};
  for (std::size_t i = 0; i < kJoints; ++i) quantity.low[i] = -limit[i];
  return quantity;
}

void Verdict::Examine(const Quantity& quantity) {
  bool may = false;
  bool must = false;
  for (std::size_t i = 0; i < quantity.size; ++i) {
    may = may || quantity.MayBreak(i);
    must = must || quantity.MustBreak(i);
  }
  if (!may && !must) return;
  Keep(quantity);
  may_.set(static_cast<std::size_t>(quantity.error));
  must_.set(static_cast<std::size_t>(quantity.error),
            must || must_.test(static_cast<std::size_t>(quantity.error)));
  must_abort_ = must_abort_ || must;
}

void Verdict::Raise(RobotError error) {
  may_.set(static_cast<std::size_t>(error));
  must_.set(static_cast<std::size_t>(error));
  must_abort_ = true;
}

void Verdict::Then(const Verdict& later) {
  if (must_abort_) return;
  if (may_.none()) {
    *this = later;
    return;
  }
  // Which of the two groups is reported hangs on rounding.
  may_ |= later.may_;
  must_abort_ = later.must_abort_;
  for (const Quantity& quantity : later.quantities()) Keep(quantity);
}

void Verdict::Beside(const Verdict& other) {
  may_ |= other.may_;
  must_ |= other.must_;
  must_abort_ = must_abort_ || other.must_abort_;
  for (const Quantity& quantity : other.quantities()) Keep(quantity);
}

std::optional<std::string> Verdict::FindOtherValue(const Violation& violation) const {
  std::optional<std::string> found;
  for (const Quantity& quantity : quantities()) {
    if (quantity.error != violation.error) continue;
    // The same error may be about this cycle's step, or about standing still after it.
    const std::optional<std::string> other = Compare(quantity, violation);
    if (!other) return {};
    if (!found) found = other;
  }
  return found;
}

void Verdict::Keep(const Quantity& quantity) {
  if (size_ < quantities_.size()) quantities_[size_++] = quantity;
}

}  // namespace twin::test
