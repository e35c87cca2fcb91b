#include "twin/rt/delay_model.h"

#include <cmath>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::rt {
namespace {

void RequireNotNegative(const char* field, Duration value) {
  if (value >= Duration::zero()) return;
  throw InputError(
      fmt::format("delay: {} is {} ns; it must not be negative", field, value.count()));
}

}  // namespace

DelayModel::DelayModel(const ConstantDelay& constant) : model_(constant) {
  RequireNotNegative("value", constant.value);
}

DelayModel::DelayModel(const LogNormalDelay& log_normal) : model_(log_normal) {
  RequireNotNegative("offset", log_normal.offset);
  if (log_normal.median <= Duration::zero()) {
    throw InputError(
        fmt::format("delay: median is {} ns; it must be above 0", log_normal.median.count()));
  }
  if (!(log_normal.sigma >= 0 && log_normal.sigma <= 5)) {
    throw InputError(fmt::format("delay: sigma is {}; it must lie in [0, 5]", log_normal.sigma));
  }
}

Duration DelayModel::Draw(const Random& random, std::uint64_t tick) const noexcept {
  if (const auto* constant = std::get_if<ConstantDelay>(&model_)) return constant->value;
  const auto& log_normal = *std::get_if<LogNormalDelay>(&model_);
  const double factor = std::exp(log_normal.sigma * random.Normal(tick));
  return log_normal.offset + FromSeconds(ToSeconds(log_normal.median) * factor);
}

}  // namespace twin::rt
