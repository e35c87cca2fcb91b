#include "twin/core/error.h"

#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

namespace twin::internal {

void CheckFailed(const char* condition, const char* file, int line) {
  std::fprintf(stderr,
               "panda-twin: internal error: %s does not hold (%s:%d). Please report this.\n",
               condition, file, line);
  std::abort();
}

}  // namespace twin::internal

namespace twin {

void RequireInRange(std::string_view what, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw InputError(fmt::format("{} is {}; it must lie in [{}, {}]", what, value, low, high));
}

}  // namespace twin
