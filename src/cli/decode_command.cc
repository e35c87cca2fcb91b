#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/say.h"
#include "twin/fci/transcript.h"
#include "twin/record/pcapng_reader.h"

namespace twin::cli {

ExitCode DecodeCommand(const DecodeFlags& flags) {
  record::PcapngReader reader(flags.capture);
  fci::Transcript transcript(
      {.fields = !flags.brief, .arm_port = flags.arm_port, .hand_port = flags.hand_port});
  while (const auto packet = reader.Next()) {
    const std::string text = transcript.Take(*packet);
    if (!text.empty()) Say(stdout, text);
  }
  if (transcript.elsewhere() > 0) {
    Say(stderr,
        fmt::format("note: {} packets of TCP are between other ports than {} (arm) and {} (hand); "
                    "if the robot's were others, name them with --port and --hand-port\n",
                    transcript.elsewhere(), flags.arm_port, flags.hand_port));
  }
  if (reader.passed_over() > 0) {
    Say(stderr, fmt::format("note: {} packets are neither UDP nor TCP over IPv4, or damaged\n",
                            reader.passed_over()));
  }
  if (reader.truncated()) {
    Say(stderr, "note: the capture ends within a packet; whoever wrote it was killed\n");
  }
  FinishOutput();
  return kOk;
}

}  // namespace twin::cli
