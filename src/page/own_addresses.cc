#include "page/own_addresses.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>

#include <algorithm>

#include "twin/fci/sockets.h"

namespace twin::page {

std::vector<std::uint32_t> AddressesOf(std::uint32_t bound) {
  if (bound != 0) return {bound};
  std::vector<std::uint32_t> addresses;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) == 0) {
    for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next) {
      if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
      const auto* address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
      addresses.push_back(ntohl(address->sin_addr.s_addr));
    }
    freeifaddrs(first);
  }
  std::erase_if(addresses, [](std::uint32_t address) { return fci::IsLoopback(address); });
  addresses.push_back(INADDR_LOOPBACK);
  return addresses;
}

}  // namespace twin::page
