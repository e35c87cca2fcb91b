#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "twin/core/realtime.h"

// Secrets for access control. They are independent of runs and seeds: core/random.h never makes
// them.
namespace twin {

/// Creates one from the operating system's generator, in [0-9a-f], 4 bits per letter.
/// @param letters  even, at most 512. @throws EnvironmentError when the system has none.
/// Threads: any.
[[nodiscard]] std::string MakeSecret(std::size_t letters);

/// Whether both are equal, in a time that does not reveal where they differ. Threads: any.
[[nodiscard]] bool IsSameSecret(std::string_view one,
                                std::string_view other) noexcept TWIN_REALTIME;

}  // namespace twin
