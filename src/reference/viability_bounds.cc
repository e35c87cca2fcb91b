#include "reference/viability_bounds.h"

#include <cmath>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/reference/viable_axis.h"

namespace twin::reference {

void RequireMagnitude(std::string_view name, std::string_view field, double value) {
  if (std::isfinite(value) && value > 0) return;
  throw InputError(
      fmt::format("viability filter: {}: {} is {}; it must be positive", name, field, value));
}

void RequireLost(int lost) {
  if (lost >= 0 && lost <= ViableAxis::kMostLost) return;
  throw InputError(
      fmt::format("viability filter: {} commands lost in a row; the number must be in [0, {}]",
                  lost, ViableAxis::kMostLost));
}

}  // namespace twin::reference
