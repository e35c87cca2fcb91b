#pragma once

#include <string_view>

namespace twin::reference::internal {

/// @param generator  name for messages. @returns lambda.
/// @throws InputError naming both when lambda is not in (0, 1].
double CheckedLambda(std::string_view generator, double lambda);

}  // namespace twin::reference::internal
