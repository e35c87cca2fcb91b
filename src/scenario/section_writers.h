#pragma once

#include <string>
#include <vector>

#include "twin/scenario/base_section.h"
#include "twin/scenario/objects.h"
#include "twin/scenario/render_section.h"

// Writers of a scenario's sections that have a file of their own.
namespace twin::scenario {

/// The section `objects`; empty when there are none.
[[nodiscard]] std::string ObjectsText(const std::vector<ObjectSection>& objects);

/// The section `base`.
[[nodiscard]] std::string BaseText(const BaseSection& base);

/// The section `render`.
[[nodiscard]] std::string RenderText(const RenderSection& render);

}  // namespace twin::scenario
