#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "twin/fci/sockets.h"

// Access control. A browser opens WebSockets to this machine for any page, so three things are
// checked: the browser addresses this server (Host), the requesting page is ours (Origin), and the
// client knows the token.
namespace twin::page {

/// Characters of a token (core/secret.h): 128 bits.
inline constexpr std::size_t kTokenLetters = 32;

/// True if a request's Host header names this end of its connection: its address, or "localhost"
/// for loopback, and its port (optional if 80). Other names are refused even if they resolve to
/// this machine: another site's pages may use them.
[[nodiscard]] bool IsOurHost(std::string_view host, const fci::Endpoint& local);

/// True if the requesting page was loaded from `host`: "http://" and the same host.
[[nodiscard]] bool IsOurOrigin(std::string_view origin, std::string_view host);

}  // namespace twin::page
