#include "twin/core/secret.h"

#include <sys/random.h>

#include <vector>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin {

std::string MakeSecret(std::size_t letters) {
  TWIN_CHECK(letters % 2 == 0 && letters <= 512);
  std::vector<unsigned char> bytes(letters / 2);
  // Requests of up to 256 bytes are always complete.
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw EnvironmentError(
        "a token is needed, and the operating system gives no random numbers (getrandom)");
  }
  std::string secret;
  for (const unsigned char byte : bytes) secret += fmt::format("{:02x}", byte);
  return secret;
}

bool IsSameSecret(std::string_view one, std::string_view other) noexcept {
  if (one.size() != other.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    difference |= static_cast<unsigned char>(one[i]) ^ static_cast<unsigned char>(other[i]);
  }
  return difference == 0;
}

}  // namespace twin
