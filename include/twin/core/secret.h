#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "twin/core/realtime.h"

// Words that only those know who were told. No part of any run, nor of what repeats with a seed:
// core/random.h is not for them, and they are not for it.
namespace twin {

/// A new one from the operating system's generator, in [0-9a-f], 4 bits a letter.
/// @param letters  even, at most 512. @throws EnvironmentError when the system has none.
/// Threads: any.
[[nodiscard]] std::string MakeSecret(std::size_t letters);

/// Whether both are the same, in a time that does not tell where they differ. Threads: any.
[[nodiscard]] bool IsSameSecret(std::string_view one,
                                std::string_view other) noexcept TWIN_REALTIME;

}  // namespace twin
