#pragma once

#include <cstdint>
#include <vector>

namespace twin::page {

/// IPv4 addresses at which a browser reaches a server bound to `bound`: itself, or for 0.0.0.0 all
/// current addresses of this machine, loopback last. Threads: any.
[[nodiscard]] std::vector<std::uint32_t> AddressesOf(std::uint32_t bound);

}  // namespace twin::page
