#include "cli/say.h"

#include "twin/core/error.h"

namespace twin::cli {

void Say(std::FILE* stream, std::string_view text) noexcept {
  (void)std::fwrite(text.data(), 1, text.size(), stream);
}

void FinishOutput() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  throw EnvironmentError(
      "standard output cannot be written, so what it shows is not complete; it is closed, or its "
      "disk is full");
}

}  // namespace twin::cli
