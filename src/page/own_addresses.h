#pragma once

#include <cstdint>
#include <vector>

namespace twin::page {

/// IPv4 addresses under which a browser finds what listens at `bound`: itself, or, when it is
/// 0.0.0.0, all of this machine's as they are now, loopback last. Threads: any.
[[nodiscard]] std::vector<std::uint32_t> AddressesOf(std::uint32_t bound);

}  // namespace twin::page
