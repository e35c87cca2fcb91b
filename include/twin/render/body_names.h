#pragma once

#include <string>
#include <vector>

struct mjModel_;

namespace twin::render {

/// @returns the names of a model's bodies by id, as in a SegmentationImage; the first is "world".
/// An unnamed body is called "body <id>".
[[nodiscard]] std::vector<std::string> BodyNames(const mjModel_& model);

}  // namespace twin::render
