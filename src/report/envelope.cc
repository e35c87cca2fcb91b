#include "report/envelope.h"

#include <cmath>

#include "twin/core/error.h"

namespace twin::report {

Envelope::Envelope(std::size_t curves, std::size_t max_bins)
    : curves_(curves), max_bins_(max_bins) {
  TWIN_CHECK(max_bins >= 2 && max_bins % 2 == 0);
}

void Envelope::Extremes::Add(const Sample& sample) {
  if (!std::isfinite(sample.value)) return;
  if (empty || sample.value < lowest.value) lowest = sample;
  if (empty || sample.value > highest.value) highest = sample;
  empty = false;
}

void Envelope::Add(double time, std::span<const double> values) {
  TWIN_CHECK(values.size() == curves_);
  if (bins_.empty() || samples_in_last_ == samples_per_bin_) {
    if (bins_.size() == max_bins_ * curves_) MergeNeighbours();
    bins_.resize(bins_.size() + curves_);
    samples_in_last_ = 0;
  }
  Extremes* const last = &bins_[bins_.size() - curves_];
  for (std::size_t c = 0; c < curves_; ++c) last[c].Add({time, values[c]});
  ++samples_in_last_;
}

void Envelope::MergeNeighbours() {
  for (std::size_t bin = 0; bin < max_bins_ / 2; ++bin) {
    for (std::size_t c = 0; c < curves_; ++c) {
      Extremes merged = bins_[2 * bin * curves_ + c];
      const Extremes& next = bins_[(2 * bin + 1) * curves_ + c];
      if (!next.empty) {
        merged.Add(next.lowest);
        merged.Add(next.highest);
      }
      bins_[bin * curves_ + c] = merged;
    }
  }
  bins_.resize(max_bins_ / 2 * curves_);
  samples_per_bin_ *= 2;
}

std::vector<Sample> Envelope::Curve(std::size_t curve) const {
  std::vector<Sample> samples;
  for (std::size_t i = curve; i < bins_.size(); i += curves_) {
    if (bins_[i].empty) continue;
    const Sample& low = bins_[i].lowest;
    const Sample& high = bins_[i].highest;
    samples.push_back(low.time <= high.time ? low : high);
    if (low.time != high.time) samples.push_back(low.time <= high.time ? high : low);
  }
  return samples;
}

}  // namespace twin::report
