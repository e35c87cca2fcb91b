#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "twin/core/joint_vector.h"
#include "twin/core/robot_errors.h"

namespace twin::test {

/// Something INT compares with a limit, recomputed from outside: one value per joint or axis, each
/// allowed in [low, high] up to INT's relative tolerance of 1e-9.
struct Quantity {
  RobotError error{};
  std::size_t size = 0;
  std::array<double, kJoints> value{};
  std::array<double, kJoints> low{};
  std::array<double, kJoints> high{};
  double noise = 0;  ///< what rounding may add to a value

  /// Whether a value is beyond its limit whatever rounding did; NaN is beyond any.
  [[nodiscard]] bool MustBreak(std::size_t i) const;
  /// Whether a value is beyond its limit, or may have been made so by rounding.
  [[nodiscard]] bool MayBreak(std::size_t i) const;
};

/// A quantity of magnitudes against symmetric limits.
[[nodiscard]] Quantity Magnitudes(RobotError error, const JointVector& value,
                                  const JointVector& limit, double noise);

/// What a cycle must and may be aborted for, by a recomputation that rounds differently: what lies
/// within rounding of its limit may be reported or not.
class Verdict {
 public:
  /// Adds a quantity of the group this verdict is about.
  void Examine(const Quantity& quantity);
  /// A broken rule without a value, of the same group.
  void Raise(RobotError error);
  /// Something that may be reported, of the same group.
  void Allow(RobotError error) { may_.set(static_cast<std::size_t>(error)); }
  /// The group that counts only if this one finds nothing.
  void Then(const Verdict& later);
  /// Something that is reported beside, whatever this finds.
  void Beside(const Verdict& other);

  [[nodiscard]] bool must_abort() const { return must_abort_; }
  [[nodiscard]] const RobotErrors& must() const { return must_; }
  [[nodiscard]] const RobotErrors& may() const { return may_; }
  /// Quantities that are or may be beyond their limits.
  [[nodiscard]] std::span<const Quantity> quantities() const { return {quantities_.data(), size_}; }
  /// Compares a reported violation with the quantities recomputed for its error: the first joint or
  /// axis that is beyond its limit, with the magnitudes of value and limit; a quantity of size 1
  /// has no axis to compare, and of several quantities of one error any may match. @returns a text
  /// when it is like none of them.
  [[nodiscard]] std::optional<std::string> FindOtherValue(const Violation& violation) const;

 private:
  void Keep(const Quantity& quantity);

  bool must_abort_ = false;
  RobotErrors must_;
  RobotErrors may_;
  std::array<Quantity, 12> quantities_;
  std::size_t size_ = 0;
};

}  // namespace twin::test
