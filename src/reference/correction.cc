#include "reference/correction.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::reference::internal {

double CheckedLambda(std::string_view generator, double lambda) {
  if (lambda > 0 && lambda <= 1) return lambda;
  throw InputError(fmt::format("{}: lambda is {}; it must lie in (0, 1] (the paper's is 1e-3)",
                               generator, lambda));
}

}  // namespace twin::reference::internal
