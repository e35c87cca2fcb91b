#pragma once

#include <string>
#include <string_view>

namespace twin::scenario {

/// A YAML double-quoted scalar.
[[nodiscard]] std::string Quoted(std::string_view text);

}  // namespace twin::scenario
