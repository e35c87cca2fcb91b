#pragma once

#include <string>
#include <string_view>

namespace twin::record {

/// @returns `text` with every byte that is not part of well-formed UTF-8 replaced by '?': the texts
/// of an MCAP file and of protobuf strings must be UTF-8. Source: RFC 3629.
[[nodiscard]] std::string ToUtf8(std::string_view text);

}  // namespace twin::record
