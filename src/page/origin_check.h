#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "twin/fci/sockets.h"

// Who is let in. A browser opens WebSockets to this machine for any page that asks, so three things
// are looked at: that the browser believes it talks to us (Host), that the page which asks is ours
// (Origin), and that whoever opened it was told the token.
namespace twin::page {

/// Letters of a token (core/secret.h): 128 bits.
inline constexpr std::size_t kTokenLetters = 32;

/// Whether a request's header Host names this end of its connection: its address, or "localhost"
/// where that is a loopback's, and its port (which may be left out when it is 80). A name that
/// resolves to us is not ours: some other site's pages may have it.
[[nodiscard]] bool IsOurHost(std::string_view host, const fci::Endpoint& local);

/// Whether the page that asks was loaded from `host`: "http://" and the same.
[[nodiscard]] bool IsOurOrigin(std::string_view origin, std::string_view host);

}  // namespace twin::page
