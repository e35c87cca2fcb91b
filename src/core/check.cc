#include "twin/core/check.h"

#include <cstdio>
#include <cstdlib>

namespace twin::internal {

void CheckFailed(const char* condition, const char* file, int line) {
  std::fprintf(stderr,
               "panda-twin: internal error: %s does not hold (%s:%d). Please report this.\n",
               condition, file, line);
  std::abort();
}

}  // namespace twin::internal
