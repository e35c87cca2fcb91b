#pragma once

#include <string_view>

namespace twin {

/// @param what  area and field as the user knows them: "tick: lambda".
/// @throws InputError naming `what`, the value and the range, unless value is in [low, high]; NaN
/// always throws.
void RequireInRange(std::string_view what, double value, double low, double high);

}  // namespace twin
