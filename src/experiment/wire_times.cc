#include "experiment/wire_times.h"

#include <map>

#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/protocol.h"
#include "twin/record/pcapng_reader.h"

namespace twin::experiment {

std::vector<Answer> AnswersOf(const std::filesystem::path& capture) {
  record::PcapngReader reader(capture);
  std::map<std::uint64_t, double> unanswered;  // id of a state -> when it left
  std::vector<Answer> answers;
  RobotState state;
  RobotCommand command;
  while (const auto packet = reader.Next()) {
    if (packet->transport != record::Transport::kUdp) continue;
    const double at_s = ToSeconds(packet->at.time_since_epoch());
    if (packet->bytes.size() == fci::kStateBytes) {
      if (fci::Decode(packet->bytes, state) != fci::DatagramFault::kNone) continue;
      unanswered.emplace(state.message_id, at_s);
    } else if (packet->bytes.size() == fci::kCommandBytes) {
      if (fci::Decode(packet->bytes, command) != fci::DatagramFault::kNone) continue;
      const auto sent = unanswered.find(command.message_id);
      if (sent == unanswered.end()) continue;  // answered before, or never sent
      answers.push_back(
          {.message_id = command.message_id, .sent_s = sent->second, .received_s = at_s});
      unanswered.erase(unanswered.begin(), std::next(sent));
    }
  }
  return answers;
}

}  // namespace twin::experiment
