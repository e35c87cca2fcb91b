#include "twin/experiment/findings.h"

#include <algorithm>

namespace twin::experiment {

std::string_view Name(Verdict verdict) noexcept {
  switch (verdict) {
    case Verdict::kMet: return "met";
    case Verdict::kMissed: return "missed";
    case Verdict::kReported: break;
  }
  return "reported";
}

std::optional<double> Comparison::ratio() const noexcept {
  if (!paper || *paper == 0) return std::nullopt;
  return ours / *paper;
}

bool Findings::succeeded() const noexcept {
  return failure.empty() && std::ranges::none_of(comparisons, [](const Comparison& comparison) {
           return comparison.verdict == Verdict::kMissed;
         });
}

}  // namespace twin::experiment
