#include "twin/reference/low_pass.h"

#include <numbers>

#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/model/transform.h"

namespace twin::reference {
namespace {

constexpr double kOffHz = 1000;

double GainOf(double cutoff_hz) {
  RequireInRange("low-pass: cut-off in Hz", cutoff_hz, 1, kOffHz);
  if (cutoff_hz == kOffHz) return 1;
  return kCycleSeconds / (kCycleSeconds + 1 / (2 * std::numbers::pi * cutoff_hz));
}

}  // namespace

LowPass::LowPass(double cutoff_hz) : gain_(GainOf(cutoff_hz)) {}

Transform LowPass::FilterPose(const Transform& O_T_EE_c, const Transform& last) const noexcept {
  if (!is_on()) return O_T_EE_c;
  const Eigen::Vector3d p_last = model::Position(last);
  return model::Turned(last, gain_ * model::TurnBetween(last, O_T_EE_c),
                       p_last + gain_ * (model::Position(O_T_EE_c) - p_last));
}

}  // namespace twin::reference
