#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace twin::report {

/// A point of a curve.
struct Sample {
  double time = 0;  ///< s
  double value = 0;
};

/// Curves of any length in bounded memory, for drawing: consecutive samples share a bin, which
/// keeps the lowest and the highest with their times. When no bin is free, neighbours are merged,
/// so the number of samples need not be known in advance.
///
/// Samples that are not finite are ignored. Threads: one thread. Not real-time.
class Envelope {
 public:
  /// @param curves  number of curves sampled together. @param max_bins  even, >= 2.
  Envelope(std::size_t curves, std::size_t max_bins);

  /// Adds one sample of each curve. @param time  s, not before the previous sample.
  void Add(double time, std::span<const double> values);

  /// The points of a curve to draw, in order of time: at most two per bin.
  [[nodiscard]] std::vector<Sample> Curve(std::size_t curve) const;

 private:
  struct Extremes {
    Sample lowest;
    Sample highest;
    bool empty = true;

    void Add(const Sample& sample);
  };

  void MergeNeighbours();

  const std::size_t curves_;
  const std::size_t max_bins_;
  std::size_t samples_per_bin_ = 1;
  std::size_t samples_in_last_ = 0;
  std::vector<Extremes> bins_;  ///< of bin b and curve c: b * curves_ + c
};

}  // namespace twin::report
