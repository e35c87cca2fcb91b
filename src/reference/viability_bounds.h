#pragma once

#include <string_view>

namespace twin::reference {

/// What the filters that keep limits for ever ask of limits and of n. Both throw InputError.
///
/// A magnitude: finite and positive. @param name  of the joint or motion. @param field  of its
/// bounds.
void RequireMagnitude(std::string_view name, std::string_view field, double value);
/// In [0, ViableAxis::kMostLost].
void RequireLost(int lost);

}  // namespace twin::reference
