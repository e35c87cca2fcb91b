#pragma once

#include <algorithm>
#include <complex>

#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// @returns of(item) of each item, in order.
template <class Items, class Of>
[[nodiscard]] std::vector<double> ValuesOf(const Items& items, const Of& of) {
  std::vector<double> values;
  values.reserve(std::size(items));
  for (const auto& item : items) values.push_back(static_cast<double>(std::invoke(of, item)));
  return values;
}

/// @returns the name of each item, in order.
template <class Items>
[[nodiscard]] std::vector<std::string> NamesOf(const Items& items) {
  std::vector<std::string> names;
  names.reserve(std::size(items));
  for (const auto& item : items) names.emplace_back(item.name);
  return names;
}

/// A row of a table.
template <class... Values>
[[nodiscard]] std::vector<double> Row(const Values&... values) {
  return {static_cast<double>(values)...};
}

[[nodiscard]] Spread SpreadOf(std::span<const double> values);

/// A column of a figure's table.
struct Column {
  std::string name;  ///< "t [s]"
  std::vector<double> values;
};

/// Columns side by side: a row for every `every`-th value of the first column, from `first` on. A
/// shorter column is filled with zeros.
[[nodiscard]] report::Table TableOf(const std::vector<Column>& columns, std::size_t first = 0,
                                    std::size_t every = 1);
/// The same as a figure.
[[nodiscard]] Figure FigureOf(std::string id, const std::vector<Column>& columns,
                              std::size_t first = 0, std::size_t every = 1);
/// 0, step, 2 step, ... @returns `count` values.
[[nodiscard]] std::vector<double> Steps(std::size_t count, double step = kCycleSeconds);

/// The smallest value with at least `share` of all at or below it. @param sorted  rising, not
/// empty. @param share  in [0, 1].
[[nodiscard]] double Percentile(std::span<const double> sorted, double share);

/// The value in the middle, the upper one of two; 0 without values.
[[nodiscard]] double UpperMedian(std::vector<double> values);

/// Shares of values in bins [edges[i], edges[i + 1]), of all values, inside and outside the bins.
/// @param edges  rising, at least two.
[[nodiscard]] std::vector<double> Histogram(std::span<const double> values,
                                            std::span<const double> edges);

[[nodiscard]] std::vector<double> Percent(std::vector<double> shares);

/// Shares of values above each edge, of all values; 0 without values.
[[nodiscard]] std::vector<double> Exceedance(std::vector<double> values,
                                             std::span<const double> edges);

/// Edges in equal steps of the logarithm, the first `from`, the last not below `to`.
[[nodiscard]] std::vector<double> LogEdges(double from, double to, int per_decade);

/// 0 to 1, at rest at both ends: x^3 (10 - 15 x + 6 x^2), x clamped to [0, 1].
[[nodiscard]] double SmoothStep(double x) noexcept;

/// Slope of the regression of y on x, both with their means: sum (x - mx)(y - my) / sum (x - mx)^2.
/// @pre as many of both, and x is not constant.
[[nodiscard]] double RegressionSlope(const std::vector<double>& x, const std::vector<double>& y);

/// Sums over a signal s and its model m(t - delay): of (m - s) dm/dt and of (dm/dt)^2.
struct DelaySums {
  double product = 0;
  double square = 0;
};

/// The delay of a signal behind its model by least squares, s: Gauss and Newton's steps from 0,
/// within 100 ms. @param sums  of a delay: DelaySums.
template <class Sums>
[[nodiscard]] double LeastSquaresDelay(int steps, const Sums& sums) {
  constexpr double kMost = 0.1;
  double delay_s = 0;
  for (int step = 0; step < steps; ++step) {
    const DelaySums sum = sums(delay_s);
    if (sum.square > 0) delay_s = std::clamp(delay_s + sum.product / sum.square, -kMost, kMost);
  }
  return delay_s;
}

/// One-sided power spectral density of a signal of 1 kHz.
struct Spectrum {
  double step_hz = 0;           ///< between two values; the first is at 0 Hz
  std::vector<double> density;  ///< unit^2/Hz
};

/// Samples of a segment of a spectrum: 0.98 Hz of resolution.
inline constexpr std::size_t kSpectrumSegment = 1024;

/// Welch's estimate: the mean of the periodograms of segments that overlap by half, each less its
/// mean and weighed with Hann's window; the density is scaled so that its integral over all
/// frequencies is the signal's variance. Source: Welch, "The use of fast Fourier transform for the
/// estimation of power spectra", IEEE Trans. Audio Electroacoust. 1967.
/// @returns no density when the signal is shorter than a segment.
[[nodiscard]] Spectrum Welch(std::span<const double> signal);

/// The paper's band, Hz.
inline constexpr double kBandFromHz = 20;
inline constexpr double kBandToHz = 150;

/// Power between two frequencies, both included: the sum of the densities there times their step,
/// unit^2.
[[nodiscard]] double BandPower(const Spectrum& spectrum, double from_hz = kBandFromHz,
                               double to_hz = kBandToHz) noexcept;

/// The median of that power over successive segments, 0 without a whole segment.
[[nodiscard]] double MedianBandPower(std::span<const double> signal, double from_hz = kBandFromHz,
                                     double to_hz = kBandToHz);

/// Amplitude and phase of the sine of `frequency_hz` that fits a signal of 1 kHz best, together
/// with a constant and a straight line: signal(i) ~ Re(A exp(j 2 pi f i T)) + c + d i. The ratio of
/// two signals' A is the frequency response from one to the other.
/// @pre at least 4 samples, and 0 < frequency_hz < 500.
[[nodiscard]] std::complex<double> SineAmplitude(std::span<const double> signal,
                                                 double frequency_hz);

}  // namespace twin::experiment
