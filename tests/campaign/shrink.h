#pragma once

#include <functional>
#include <string>

namespace twin::campaign {

/// The smallest text found that still fails: keys and elements of a scenario's YAML, each a line
/// with the deeper ones below it, are taken away, one after the other, until none more can be. What
/// is left is what differs from a scenario that says nothing. Name and description stay, and so
/// does each line as a whole.
///
/// @param fails  whether a text is a scenario, and fails as the whole one does.
[[nodiscard]] std::string Shrink(const std::string& yaml,
                                 const std::function<bool(const std::string& less)>& fails);

}  // namespace twin::campaign
