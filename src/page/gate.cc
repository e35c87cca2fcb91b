#include "page/gate.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::page {
namespace {

bool IsSameWord(std::string_view one, std::string_view other) {
  return std::ranges::equal(one, other, [](unsigned char a, unsigned char b) {
    return std::tolower(a) == std::tolower(b);
  });
}

}  // namespace

std::string MakeToken() {
  std::array<unsigned char, kTokenLetters / 2> bytes{};
  // Never cut short: that happens to requests of more than 256 bytes only.
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw EnvironmentError(
        "the page needs a token, and the operating system gives no random numbers (getrandom)");
  }
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool IsSameToken(std::string_view one, std::string_view other) noexcept {
  if (one.size() != other.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    difference |= static_cast<unsigned char>(one[i]) ^ static_cast<unsigned char>(other[i]);
  }
  return difference == 0;
}

bool IsOurHost(std::string_view host, const fci::Endpoint& local) {
  const std::string here = fci::ToString(local);
  const std::string address = here.substr(0, here.find(':'));
  const auto is_at = [&](const std::string& name) {
    return IsSameWord(host, fmt::format("{}:{}", name, local.port)) ||
           (local.port == 80 && IsSameWord(host, name));
  };
  return is_at(address) || (fci::IsLoopback(local.address) && is_at("localhost"));
}

bool IsOurOrigin(std::string_view origin, std::string_view host) {
  constexpr std::string_view kScheme = "http://";
  return origin.starts_with(kScheme) && IsSameWord(origin.substr(kScheme.size()), host);
}

}  // namespace twin::page
