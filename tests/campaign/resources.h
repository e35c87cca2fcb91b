#pragma once

#include <cstdint>

namespace twin::campaign {

/// What the program holds of the machine.
struct Resources {
  std::int64_t heap = 0;   ///< bytes that were allocated and not freed; 0 under a sanitizer
  std::int64_t files = 0;  ///< open ones, sockets and the like among them
};

/// Threads: any; what others hold counts too.
[[nodiscard]] Resources ResourcesInUse();

}  // namespace twin::campaign
