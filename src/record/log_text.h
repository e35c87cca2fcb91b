#pragma once

#include <map>
#include <string>
#include <string_view>

#include "twin/record/log_records.h"

namespace twin::record {

/// Entries of a metadata record.
using Metadata = std::map<std::string, std::string>;

/// A run's limits as metadata: "joint.q_max": "2.8973 1.7628 ...", one number per joint;
/// "cartesian.translation.dp_max": "1.7"; all exact.
[[nodiscard]] Metadata LimitsToMetadata(const RunLimits& limits);

/// The inverse. @throws InputError naming an entry that is missing or malformed, or if the limits
/// are invalid.
[[nodiscard]] RunLimits LimitsFromMetadata(const Metadata& entries);

/// @returns `text` with every byte that is not part of well-formed UTF-8 replaced by '?': the texts
/// of an MCAP file and of protobuf strings must be UTF-8. Source: RFC 3629.
[[nodiscard]] std::string ToUtf8(std::string_view text);

/// @returns ToUtf8(text) with every control character but line break and tab replaced by '?': a
/// log's texts go to terminals, which obey escape sequences.
[[nodiscard]] std::string ToPrintable(std::string_view text);

}  // namespace twin::record
