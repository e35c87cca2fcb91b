#include <cstdint>
#include <filesystem>
#include <string>

#include "cli/commands/commands.h"
#include "twin/fci/protocol.h"
#include "twin/fci/transcript.h"
#include "twin/record/pcapng_reader.h"

namespace twin::cli {
namespace {

struct DecodeFlags {
  std::filesystem::path capture;
  bool brief = false;
  std::uint16_t arm_port = fci::kArmPort;
  std::uint16_t hand_port = fci::kHandPort;
  std::uint16_t vacuum_port = fci::kVacuumPort;
};

int Decode(const DecodeFlags& flags, const Program& program) {
  record::PcapngReader reader(flags.capture);
  fci::Transcript transcript({.fields = !flags.brief,
                              .arm_port = flags.arm_port,
                              .hand_port = flags.hand_port,
                              .vacuum_port = flags.vacuum_port});
  while (const auto packet = reader.Next()) {
    const std::string text = transcript.Take(*packet);
    if (!text.empty()) Say(stdout, text);
  }
  if (transcript.elsewhere() > 0) {
    program.log->info(
        "{} packets of TCP are between other ports than {} (arm), {} (hand) and {} (vacuum "
        "gripper); if the robot's were others, name them with --port, --hand-port and "
        "--vacuum-port",
        transcript.elsewhere(), flags.arm_port, flags.hand_port, flags.vacuum_port);
  }
  if (reader.passed_over() > 0) {
    program.log->info("{} packets are neither UDP nor TCP over IPv4, or damaged",
                      reader.passed_over());
  }
  if (reader.truncated()) {
    program.log->info("the capture ends within a packet; the program that wrote it was killed");
  }
  FinishOutput();
  return kOk;
}

}  // namespace

void AddDecode(CLI::App& app, Program& program) {
  const auto [decode, flags] =
      AddCommand(app, program, "decode", "Print a capture of the wire, field by field", &Decode);
  Add(decode, "capture FILE", flags.capture,
      "What --capture or Wireshark wrote (pcapng); what tcpdump -w wrote, after "
      "editcap -F pcapng IN OUT")
      ->required();
  decode.add_flag("--brief", flags.brief, "A line for each message, no fields");
  Add(decode, "--port", flags.arm_port, "TCP port of the arm")->capture_default_str();
  Add(decode, "--hand-port", flags.hand_port, "TCP port of the hand")->capture_default_str();
  Add(decode, "--vacuum-port", flags.vacuum_port, "TCP port of the vacuum gripper")
      ->capture_default_str();
}

}  // namespace twin::cli
