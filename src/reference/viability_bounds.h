#pragma once

#include <string_view>

namespace twin::reference {

/// Requirements of the viability filters on limits and n. Both functions throw InputError.
///
/// A magnitude must be finite and positive. @param name  of the joint or motion. @param field  of
/// its bounds.
void RequireMagnitude(std::string_view name, std::string_view field, double value);
/// n must be in [0, ViableAxis::kMostLost].
void RequireLost(int lost);

}  // namespace twin::reference
