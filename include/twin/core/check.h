#pragma once

namespace twin::internal {
[[noreturn]] void CheckFailed(const char* condition, const char* file, int line);
}  // namespace twin::internal

/// Aborts the program when `condition` is false: a bug of ours. Always on. Never used in a tick.
#define TWIN_CHECK(condition)         \
  ((condition) ? static_cast<void>(0) \
               : ::twin::internal::CheckFailed(#condition, __FILE__, __LINE__))
