#pragma once

#include <map>
#include <string>

#include "twin/record/log_records.h"

namespace twin::record {

/// Entries of a metadata record.
using Metadata = std::map<std::string, std::string>;

/// The limits that a run carries, as metadata: "joint.q_max": "2.8973 1.7628 ...", one number per
/// joint; "cartesian.translation.dp_max": "1.7"; all exact.
[[nodiscard]] Metadata LimitsToMetadata(const RunLimits& limits);

/// The way back. @throws InputError naming the entry that is missing or no such numbers, or when
/// the limits are not valid.
[[nodiscard]] RunLimits LimitsFromMetadata(const Metadata& entries);

}  // namespace twin::record
