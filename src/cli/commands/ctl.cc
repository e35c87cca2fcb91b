#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/commands/commands.h"
#include "twin/core/error.h"
#include "twin/server/control_channel.h"

namespace twin::cli {
namespace {

struct CtlFlags {
  std::filesystem::path socket;      ///< serve's --control
  std::vector<std::string> request;  ///< its words
  bool json = false;                 ///< the answer as it came
};

int Ctl(const CtlFlags& flags, const Program& /*program*/) {
  const std::string line =
      server::AskControl(flags.socket, server::ControlRequestOf(flags.request));
  const nlohmann::json answer = nlohmann::json::parse(line, nullptr, false);
  if (!answer.is_object() || !answer.contains("ok")) {
    throw EnvironmentError(
        fmt::format("{}: what answers there is no control channel", flags.socket.string()));
  }
  if (!answer["ok"].get<bool>()) throw RobotFault(answer["error"].get<std::string>());
  if (flags.json) {
    Say(stdout, line + "\n");
  } else {
    const std::string errors = answer["errors"].empty() ? "none" : answer["errors"].dump();
    Say(stdout,
        fmt::format("mode {}, time {}, cycle {} ({:.3f} s), errors {}\n",
                    answer["mode"].get<std::string>(),
                    answer["paused"].get<bool>() ? "paused" : "runs",
                    answer["cycle"].get<std::uint64_t>(), answer["time_s"].get<double>(), errors));
  }
  FinishOutput();
  return kOk;
}

}  // namespace

void AddCtl(CLI::App& app, Program& program) {
  const auto [ctl, flags] =
      AddCommand(app, program, "ctl",
                 "Control a served robot beside its clients: pause, step, stop, rewind", &Ctl);
  Add(ctl, "socket FILE", flags.socket, "The socket that serve --control made")->required();
  Add(ctl, "request WORD", flags.request,
      "status, pause, step [N], resume, user-stop press|release, guiding on|off, recover, reset, "
      "reset ready, reset with seven angles in rad, place OBJECT X Y Z [ROLL PITCH YAW] in m and "
      "rad, snapshot [NAME], or restore [NAME]")
      ->required();
  ctl.add_flag("--json", flags.json, "Print the answer as it comes over the channel");
}

}  // namespace twin::cli
