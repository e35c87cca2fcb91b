#include "experiment/wave_source.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "experiment/statistics.h"

namespace twin::experiment {
namespace {

constexpr double kOmega = std::numbers::pi / 2;  // rad/s

}  // namespace

WaveValue WaveAt(control::CommandInterface interface, double acceleration, double t) noexcept {
  const double length_s = ToSeconds(WaveSource::kLength);
  if (t <= 0 || t >= length_s) return {};
  // sin^4(x) = (3 - 4 cos 2x + cos 4x) / 8
  const double x = kOmega * t;
  const double amplitude = acceleration / (4 * kOmega * kOmega);
  const double q = amplitude * (3 - 4 * std::cos(2 * x) + std::cos(4 * x)) / 8;
  const double dq = amplitude * kOmega * (std::sin(2 * x) - std::sin(4 * x) / 2);
  const double ddq = acceleration * (std::cos(2 * x) - std::cos(4 * x)) / 2;
  if (interface == control::CommandInterface::kJointVelocity) return {dq, ddq};
  return {q, dq};
}

void WaveSource::Update(const RobotState& /*state*/, Time now,
                        control::ControllerOutput& output) noexcept {
  if (!is_running_) {
    is_running_ = true;
    begin_ = now;
  }
  const double t = ToSeconds(now - begin_);
  output.target.joint = {.q = start_};
  output.target.tau_J_d = {};
  const double value = WaveAt(interface_, acceleration_, t).value;
  switch (interface_) {
    case control::CommandInterface::kJointVelocity: output.target.joint.dq[0] = value; break;
    case control::CommandInterface::kTorque: output.target.tau_J_d[0] = value; break;
    default: output.target.joint.q[0] += value; break;
  }
  output.has_velocity = interface_ == control::CommandInterface::kJointVelocity;
  output.finished = now - begin_ >= kLength;
}

double WaveDelay(control::CommandInterface interface, double acceleration,
                 const std::vector<double>& signal) {
  const auto count = static_cast<double>(signal.size());
  return LeastSquaresDelay(5, [&](double delay_s) {
    double error = 0;
    double rate = 0;
    DelaySums sums;
    for (std::size_t k = 0; k < signal.size(); ++k) {
      const WaveValue wave =
          WaveAt(interface, acceleration, static_cast<double>(k) * kCycleSeconds - delay_s);
      error += wave.value - signal[k];
      rate += wave.rate;
      sums.product += (wave.value - signal[k]) * wave.rate;
      sums.square += wave.rate * wave.rate;
    }
    sums.product -= error * rate / count;
    sums.square -= rate * rate / count;
    return sums;
  });
}

}  // namespace twin::experiment
