#include "twin/core/require.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin {

void RequireInRange(std::string_view what, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw InputError(fmt::format("{} is {}; it must lie in [{}, {}]", what, value, low, high));
}

}  // namespace twin
