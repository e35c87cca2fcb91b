#include "twin/faults/delay_model.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::faults {
namespace {

/// A try succeeds with a probability of at least 1/2 (normal) or 0.95 (gamma): all tries fail once
/// in more than 10^19 draws.
constexpr std::uint32_t kNormalTries = 64;
constexpr std::uint32_t kGammaTries = 15;

void RequireDuration(std::string_view field, Duration value) {
  if (value >= Duration::zero() && value <= DelayModel::kLongestParameter) return;
  throw InputError(
      fmt::format("delay: {} is {} ns; it must lie in [0, 1 h]", field, value.count()));
}

void RequirePositive(std::string_view field, Duration value) {
  if (value > Duration::zero() && value <= DelayModel::kLongestParameter) return;
  throw InputError(
      fmt::format("delay: {} is {} ns; it must be above 0 and at most 1 h", field, value.count()));
}

void RequireEdges(const EmpiricalDelay& empirical) {
  const auto& edges = empirical.edges;
  if (empirical.weights.empty() || edges.size() != empirical.weights.size() + 1) {
    throw InputError(
        fmt::format("delay: there are {} edges and {} weights; n weights, n at least 1, need n + 1 "
                    "edges",
                    edges.size(), empirical.weights.size()));
  }
  for (std::size_t i = 0; i < edges.size(); ++i) {
    RequireDuration(fmt::format("edges[{}]", i), edges[i]);
    if (i == 0 || edges[i] > edges[i - 1]) continue;
    throw InputError(
        fmt::format("delay: edges[{}] is {} ns; edges must rise, and the one before it "
                    "is {} ns",
                    i, edges[i].count(), edges[i - 1].count()));
  }
}

/// @returns the cumulative weight at the end of each bin; the last is exactly 1.
std::vector<double> Cumulative(const std::vector<double>& weights) {
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    RequireInRange(fmt::format("delay: weights[{}]", i), weights[i], 0, 1e300);
    sum += weights[i];
  }
  if (!(sum > 0)) throw InputError("delay: all weights are 0; at least one must be above 0");
  std::vector<double> cumulative;
  cumulative.reserve(weights.size());
  double upto = 0;
  for (const double weight : weights) cumulative.push_back((upto += weight) / sum);
  return cumulative;
}

Duration DrawFrom(const LogNormalDelay& log_normal, const Random& random,
                  std::uint64_t tick) noexcept {
  const double factor = std::exp(log_normal.sigma * random.Normal(tick));
  return log_normal.offset + FromSeconds(ToSeconds(log_normal.median) * factor);
}

Duration DrawFrom(const NormalDelay& normal, const Random& random, std::uint64_t tick) noexcept {
  for (std::uint32_t i = 0; i < kNormalTries; ++i) {
    const double seconds =
        ToSeconds(normal.mean) + ToSeconds(normal.sigma) * random.Normal(tick, i);
    if (seconds >= 0) return FromSeconds(seconds);
  }
  return normal.mean;
}

/// Gamma distributed with scale 1. A shape below 1: G(shape) = G(shape + 1) U^(1/shape).
double Gamma(double shape, const Random& random, std::uint64_t tick) noexcept {
  const double d = (shape < 1 ? shape + 1 : shape) - 1.0 / 3.0;
  const double c = 1 / std::sqrt(9 * d);
  double value = d;
  for (std::uint32_t i = 0; i < kGammaTries; ++i) {
    const double z = random.Normal(tick, 2 * i);
    const double root = 1 + c * z;
    if (root <= 0) continue;
    const double v = root * root * root;
    const double u = 1 - random.Uniform(tick, 2 * i + 1);  // in (0, 1]
    if (std::log(u) >= 0.5 * z * z + d - d * v + d * std::log(v)) continue;
    value = d * v;
    break;
  }
  if (shape >= 1) return value;
  return value * std::pow(1 - random.Uniform(tick, 2 * kGammaTries), 1 / shape);
}

Duration DrawFrom(const GammaDelay& gamma, const Random& random, std::uint64_t tick) noexcept {
  return gamma.offset + FromSeconds(ToSeconds(gamma.scale) * Gamma(gamma.shape, random, tick));
}

}  // namespace

DelayModel::DelayModel(const ConstantDelay& constant) : model_(constant) {
  RequireDuration("value", constant.value);
}

DelayModel::DelayModel(const LogNormalDelay& log_normal) : model_(log_normal) {
  RequireDuration("offset", log_normal.offset);
  RequirePositive("median", log_normal.median);
  RequireInRange("delay: sigma", log_normal.sigma, 0, 5);
}

DelayModel::DelayModel(const NormalDelay& normal) : model_(normal) {
  RequireDuration("mean", normal.mean);
  RequireDuration("sigma", normal.sigma);
}

DelayModel::DelayModel(const GammaDelay& gamma) : model_(gamma) {
  RequireInRange("delay: shape", gamma.shape, 0.01, 1e6);
  RequirePositive("scale", gamma.scale);
  RequireDuration("offset", gamma.offset);
}

DelayModel::DelayModel(const EmpiricalDelay& empirical) {
  RequireEdges(empirical);
  model_ = Histogram{empirical.edges, Cumulative(empirical.weights)};
}

Duration DelayModel::Histogram::Draw(const Random& random, std::uint64_t tick) const noexcept {
  const double u = random.Uniform(tick);
  const auto end = std::upper_bound(cumulative.begin(), cumulative.end(), u);
  const auto bin = end - cumulative.begin();
  const double before = bin == 0 ? 0 : cumulative[bin - 1];
  const Duration width = edges[bin + 1] - edges[bin];
  const double part = (u - before) / (*end - before);  // in [0, 1): skips bins without weight
  return edges[bin] + Duration(static_cast<Duration::rep>(part * width.count()));
}

Duration DelayModel::Draw(const Random& random, std::uint64_t tick) const noexcept {
  if (const auto* constant = std::get_if<ConstantDelay>(&model_)) return constant->value;
  if (const auto* log_normal = std::get_if<LogNormalDelay>(&model_)) {
    return DrawFrom(*log_normal, random, tick);
  }
  if (const auto* normal = std::get_if<NormalDelay>(&model_)) {
    return DrawFrom(*normal, random, tick);
  }
  if (const auto* gamma = std::get_if<GammaDelay>(&model_)) return DrawFrom(*gamma, random, tick);
  return std::get_if<Histogram>(&model_)->Draw(random, tick);
}

}  // namespace twin::faults
