#pragma once

#include <string>
#include <vector>

struct mjModel_;

namespace twin::render {

/// @returns the names of a model's bodies by their id, as in a SegmentationImage; the first is
/// "world". A body without a name is called "body <id>".
[[nodiscard]] std::vector<std::string> BodyNames(const mjModel_& model);

}  // namespace twin::render
