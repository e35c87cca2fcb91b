#include <arpa/inet.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "fci/socket_address.h"
#include "twin/core/error.h"
#include "twin/core/integer.h"
#include "twin/fci/sockets.h"

namespace twin::fci {
namespace {

constexpr int kAddressBits = 32;

[[noreturn]] void RefuseNetwork(const std::string& text, std::string_view why) {
  throw InputError(fmt::format(
      "\"{}\" is no network: {}; write ADDRESS/BITS, like 192.168.1.0/24 or 192.168.1.7/32", text,
      why));
}

/// @returns 0 to 32; negative if invalid.
int ReadBits(std::string_view text) noexcept {
  const int bits = ParseInteger<int>(text).value_or(-1);
  return bits <= kAddressBits ? bits : -1;
}

}  // namespace

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  if (this != &other) {
    Reset();
    fd_ = other.Release();
  }
  return *this;
}

int FileDescriptor::Release() noexcept {
  return std::exchange(fd_, -1);
}

void FileDescriptor::Reset() noexcept {
  if (valid()) close(Release());
}

std::string AddressText(std::uint32_t address) {
  return fmt::format("{}.{}.{}.{}", address >> 24, (address >> 16) & 0xFF, (address >> 8) & 0xFF,
                     address & 0xFF);
}

std::string ToString(const Endpoint& endpoint) {
  return fmt::format("{}:{}", AddressText(endpoint.address), endpoint.port);
}

Endpoint Resolve(const std::string& host, std::uint16_t port) {
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), nullptr, &wanted, &found);
  if (error != 0) {
    throw InputError(
        fmt::format("\"{}\" is no host that can be found: {}; give its IPv4 address, "
                    "or a name that this machine can resolve",
                    host, gai_strerror(error)));
  }
  const auto* address = reinterpret_cast<const sockaddr_in*>(found->ai_addr);
  const Endpoint endpoint{EndpointOf(*address).address, port};
  freeaddrinfo(found);
  return endpoint;
}

Network ParseNetwork(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) RefuseNetwork(text, "it has no \"/\"");
  in_addr address{};
  if (inet_pton(AF_INET, text.substr(0, slash).c_str(), &address) != 1) {
    RefuseNetwork(text, "what stands before the \"/\" is no IPv4 address");
  }
  const int bits = ReadBits(std::string_view(text).substr(slash + 1));
  if (bits < 0) RefuseNetwork(text, "what stands behind the \"/\" is no number from 0 to 32");
  // Shifting by all 32 bits is undefined.
  const std::uint32_t mask = bits == 0 ? 0 : ~std::uint32_t{0} << (kAddressBits - bits);
  const std::uint32_t whole = ntohl(address.s_addr);
  if ((whole & mask) != whole) {
    RefuseNetwork(text, fmt::format("its address goes on behind the first {} bits, {}/{} does not",
                                    bits, AddressText(whole & mask), bits));
  }
  return {whole, mask};
}

}  // namespace twin::fci
