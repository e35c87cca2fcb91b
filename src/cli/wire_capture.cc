#include "cli/wire_capture.h"

#include <cstdint>
#include <cstdio>

#include <fmt/format.h>

#include "cli/say.h"

namespace twin::cli {

void FinishCapture(fci::Capture& capture) {
  const std::uint64_t dropped = capture.Finish();
  if (dropped == 0) return;
  Say(stderr, fmt::format("panda-twin: note: the capture lacks {} datagrams: the disk was slower "
                          "than the wire\n",
                          dropped));
}

}  // namespace twin::cli
