#include "twin/experiment/findings.h"

#include <algorithm>
#include <utility>

namespace twin::experiment {

std::string_view Name(Verdict verdict) noexcept {
  switch (verdict) {
    case Verdict::kPredicted: return "predicted";
    case Verdict::kNotReproduced: return "not reproduced";
    case Verdict::kCalibrated: return "calibrated";
    case Verdict::kReported: break;
  }
  return "reported";
}

Comparison& Comparison::Paper(double value) {
  paper = value;
  return *this;
}

Comparison& Comparison::Demand(std::string text, bool met) {
  verdict = text.empty() ? Verdict::kReported : Judge(met);
  demand = std::move(text);
  return *this;
}

bool Comparison::is_missed() const noexcept {
  return verdict == Verdict::kNotReproduced && reason.empty();
}

std::optional<double> Comparison::ratio() const noexcept {
  if (!paper || *paper == 0) return std::nullopt;
  return ours / *paper;
}

Comparison& Findings::Add(std::string quantity, std::string unit, double ours) {
  return comparisons.emplace_back(
      Comparison{.quantity = std::move(quantity), .unit = std::move(unit), .ours = ours});
}

Comparison& Findings::Add(std::string quantity, std::string unit, const Spread& spread) {
  Comparison& one = Add(std::move(quantity), std::move(unit), spread.mean);
  one.low = spread.low;
  one.high = spread.high;
  return one;
}

bool Findings::succeeded() const noexcept {
  return failure.empty() && std::ranges::none_of(comparisons, &Comparison::is_missed);
}

}  // namespace twin::experiment
