#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace twin::experiment {

/// When a state left the server and its answer came, as a capture has it.
struct Answer {
  std::uint64_t message_id = 0;
  double sent_s = 0;      ///< on the capture's time line
  double received_s = 0;  ///< of the first command that answers it
};

/// The answered states of a capture, in the order of their ids. Ids rise as long as a robot runs.
/// @param capture  of a server, pcapng. @throws InputError, EnvironmentError as
/// record::PcapngReader.
[[nodiscard]] std::vector<Answer> AnswersOf(const std::filesystem::path& capture);

}  // namespace twin::experiment
