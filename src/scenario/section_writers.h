#pragma once

#include <string>
#include <vector>

#include "twin/scenario/objects.h"

// Writers of a scenario's sections that have a file of their own.
namespace twin::scenario {

/// The section `objects`; empty when there are none.
[[nodiscard]] std::string ObjectsText(const std::vector<ObjectSection>& objects);

}  // namespace twin::scenario
