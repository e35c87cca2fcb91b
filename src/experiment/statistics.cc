#include "experiment/statistics.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include <Eigen/Dense>
#include <unsupported/Eigen/FFT>

#include "twin/core/error.h"

namespace twin::experiment {
namespace {

constexpr double kRateHz = 1 / kCycleSeconds;

std::vector<double> Hann(std::size_t size) {
  std::vector<double> window(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double phase = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(size);
    window[i] = 0.5 * (1 - std::cos(phase));
  }
  return window;
}

double Mean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

Spread SpreadOf(std::span<const double> values) {
  if (values.empty()) return {};
  const auto [low, high] = std::ranges::minmax(values);
  return {Mean(values), low, high};
}

report::Table TableOf(const std::vector<Column>& columns, std::size_t first, std::size_t every) {
  report::Table table;
  for (const Column& column : columns) {
    table.columns.append(table.columns.empty() ? "" : ",").append(column.name);
  }
  for (std::size_t i = first; i < columns.front().values.size(); i += every) {
    table.rows.push_back(ValuesOf(columns, [i](const Column& column) {
      return i < column.values.size() ? column.values[i] : 0;
    }));
  }
  return table;
}

Figure FigureOf(std::string id, const std::vector<Column>& columns, std::size_t first,
                std::size_t every) {
  report::Table table = TableOf(columns, first, every);
  return {.id = std::move(id), .columns = std::move(table.columns), .rows = std::move(table.rows)};
}

std::vector<double> Steps(std::size_t count, double step) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<double>(i) * step;
  return values;
}

double Percentile(std::span<const double> sorted, double share) {
  TWIN_CHECK(!sorted.empty());
  const double rank = std::ceil(share * static_cast<double>(sorted.size()));
  const auto index = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
  return sorted[std::min(index, sorted.size() - 1)];
}

double UpperMedian(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

std::vector<double> Histogram(std::span<const double> values, std::span<const double> edges) {
  std::vector<double> shares(edges.size() - 1);
  for (const double value : values) {
    const auto above = std::ranges::upper_bound(edges, value);
    if (above == edges.begin() || above == edges.end()) continue;
    ++shares[static_cast<std::size_t>(above - edges.begin()) - 1];
  }
  if (!values.empty()) {
    for (double& share : shares) share /= static_cast<double>(values.size());
  }
  return shares;
}

std::vector<double> Percent(std::vector<double> shares) {
  for (double& share : shares) share *= 100;
  return shares;
}

std::vector<double> Exceedance(std::vector<double> values, std::span<const double> edges) {
  std::ranges::sort(values);
  std::vector<double> shares;
  for (const double edge : edges) {
    const auto above = values.end() - std::ranges::upper_bound(values, edge);
    shares.push_back(
        values.empty() ? 0 : static_cast<double>(above) / static_cast<double>(values.size()));
  }
  return shares;
}

std::vector<double> LogEdges(double from, double to, int per_decade) {
  std::vector<double> edges;
  for (int i = 0; edges.empty() || edges.back() < to; ++i) {
    edges.push_back(from * std::pow(10, static_cast<double>(i) / per_decade));
  }
  return edges;
}

double SmoothStep(double x) noexcept {
  const double c = std::clamp(x, 0.0, 1.0);
  return c * c * c * (10 + c * (-15 + 6 * c));
}

double RegressionSlope(const std::vector<double>& x, const std::vector<double>& y) {
  const double mean_x = Mean(x);
  const double mean_y = Mean(y);
  double product = 0;
  double square = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    product += (x[i] - mean_x) * (y[i] - mean_y);
    square += (x[i] - mean_x) * (x[i] - mean_x);
  }
  return product / square;
}

Spectrum Welch(std::span<const double> signal) {
  constexpr std::size_t kSegment = kSpectrumSegment;
  Spectrum spectrum{.step_hz = kRateHz / kSegment, .density = {}};
  if (signal.size() < kSegment) return spectrum;
  const std::vector<double> window = Hann(kSegment);
  const double weight = std::inner_product(window.begin(), window.end(), window.begin(), 0.0);
  spectrum.density.assign(kSegment / 2 + 1, 0);
  Eigen::FFT<double> fft;
  std::vector<double> part(kSegment);
  std::vector<std::complex<double>> transform;
  std::size_t segments = 0;
  for (std::size_t begin = 0; begin + kSegment <= signal.size(); begin += kSegment / 2) {
    const std::span<const double> values = signal.subspan(begin, kSegment);
    const double mean = Mean(values);
    for (std::size_t i = 0; i < kSegment; ++i) part[i] = window[i] * (values[i] - mean);
    fft.fwd(transform, part);
    for (std::size_t i = 0; i <= kSegment / 2; ++i) spectrum.density[i] += std::norm(transform[i]);
    ++segments;
  }
  for (std::size_t i = 0; i <= kSegment / 2; ++i) {
    const double sides = i == 0 || i == kSegment / 2 ? 1 : 2;
    spectrum.density[i] *= sides / (kRateHz * weight * static_cast<double>(segments));
  }
  return spectrum;
}

double BandPower(const Spectrum& spectrum, double from_hz, double to_hz) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < spectrum.density.size(); ++i) {
    const double f = static_cast<double>(i) * spectrum.step_hz;
    if (f >= from_hz && f <= to_hz) sum += spectrum.density[i];
  }
  return sum * spectrum.step_hz;
}

double MedianBandPower(std::span<const double> signal, double from_hz, double to_hz) {
  std::vector<double> powers;
  for (std::size_t i = 0; i + kSpectrumSegment <= signal.size(); i += kSpectrumSegment) {
    powers.push_back(BandPower(Welch(signal.subspan(i, kSpectrumSegment)), from_hz, to_hz));
  }
  return UpperMedian(std::move(powers));
}

std::complex<double> SineAmplitude(std::span<const double> signal, double frequency_hz) {
  const auto size = static_cast<Eigen::Index>(signal.size());
  Eigen::MatrixXd basis(size, 4);
  Eigen::VectorXd values(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const double phase = 2 * std::numbers::pi * frequency_hz * static_cast<double>(i) / kRateHz;
    basis.row(i) << std::cos(phase), std::sin(phase), 1,
        static_cast<double>(i) / static_cast<double>(size);
    values[i] = signal[static_cast<std::size_t>(i)];
  }
  const Eigen::Vector4d fit = (basis.transpose() * basis).ldlt().solve(basis.transpose() * values);
  return {fit[0], -fit[1]};
}

}  // namespace twin::experiment
