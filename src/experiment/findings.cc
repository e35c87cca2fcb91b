#include "twin/experiment/findings.h"

#include <algorithm>

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

bool Comparison::is_missed() const noexcept {
  return verdict == Verdict::kNotReproduced && reason.empty();
}

std::optional<double> Comparison::ratio() const noexcept {
  if (!paper || *paper == 0) return std::nullopt;
  return ours / *paper;
}

bool Findings::succeeded() const noexcept {
  return failure.empty() && std::ranges::none_of(comparisons, &Comparison::is_missed);
}

}  // namespace twin::experiment
