#include "page/origin_check.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace twin::page {
namespace {

bool IsSameWord(std::string_view one, std::string_view other) {
  return std::ranges::equal(one, other, [](unsigned char a, unsigned char b) {
    return std::tolower(a) == std::tolower(b);
  });
}

}  // namespace

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
