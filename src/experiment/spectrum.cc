#include "experiment/spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>
#include <unsupported/Eigen/FFT>

namespace twin::experiment {
namespace {

std::vector<double> Hann(std::size_t size) {
  std::vector<double> window(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double phase = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(size);
    window[i] = 0.5 * (1 - std::cos(phase));
  }
  return window;
}

double Mean(std::span<const double> values) {
  double sum = 0;
  for (const double x : values) sum += x;
  return sum / static_cast<double>(values.size());
}

}  // namespace

Spectrum Welch(std::span<const double> signal, double rate_hz, std::size_t segment) {
  Spectrum spectrum{.step_hz = rate_hz / static_cast<double>(segment), .density = {}};
  if (signal.size() < segment) return spectrum;
  const std::vector<double> window = Hann(segment);
  double weight = 0;
  for (const double w : window) weight += w * w;
  spectrum.density.assign(segment / 2 + 1, 0);
  Eigen::FFT<double> fft;
  std::vector<double> part(segment);
  std::vector<std::complex<double>> transform;
  std::size_t segments = 0;
  for (std::size_t begin = 0; begin + segment <= signal.size(); begin += segment / 2) {
    const std::span<const double> values = signal.subspan(begin, segment);
    const double mean = Mean(values);
    for (std::size_t i = 0; i < segment; ++i) part[i] = window[i] * (values[i] - mean);
    fft.fwd(transform, part);
    for (std::size_t i = 0; i <= segment / 2; ++i) spectrum.density[i] += std::norm(transform[i]);
    ++segments;
  }
  for (std::size_t i = 0; i <= segment / 2; ++i) {
    const double sides = i == 0 || i == segment / 2 ? 1 : 2;
    spectrum.density[i] *= sides / (rate_hz * weight * static_cast<double>(segments));
  }
  return spectrum;
}

double BandPower(const Spectrum& spectrum, double from_hz, double to_hz) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < spectrum.density.size(); ++i) {
    const double f = spectrum.frequency_hz(i);
    if (f >= from_hz && f <= to_hz) sum += spectrum.density[i];
  }
  return sum * spectrum.step_hz;
}

double MedianBandPower(std::span<const double> signal, double rate_hz, std::size_t segment,
                       double from_hz, double to_hz) {
  std::vector<double> powers;
  for (std::size_t i = 0; i + segment <= signal.size(); i += segment) {
    powers.push_back(
        BandPower(Welch(signal.subspan(i, segment), rate_hz, segment), from_hz, to_hz));
  }
  if (powers.empty()) return 0;
  const auto middle = powers.begin() + static_cast<std::ptrdiff_t>(powers.size() / 2);
  std::ranges::nth_element(powers, middle);
  return *middle;
}

std::complex<double> SineAmplitude(std::span<const double> signal, double rate_hz,
                                   double frequency_hz) {
  const auto size = static_cast<Eigen::Index>(signal.size());
  Eigen::MatrixXd basis(size, 4);
  Eigen::VectorXd values(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const double phase = 2 * std::numbers::pi * frequency_hz * static_cast<double>(i) / rate_hz;
    basis.row(i) << std::cos(phase), std::sin(phase), 1,
        static_cast<double>(i) / static_cast<double>(size);
    values[i] = signal[static_cast<std::size_t>(i)];
  }
  const Eigen::Vector4d fit = (basis.transpose() * basis).ldlt().solve(basis.transpose() * values);
  return {fit[0], -fit[1]};
}

}  // namespace twin::experiment
