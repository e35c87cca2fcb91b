#include <cstdint>
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

/// @param answer  of a control channel, to a request that was carried out. @throws json::exception.
std::string SummaryOf(const nlohmann::json& answer) {
  const nlohmann::json& errors = answer.at("errors");
  return fmt::format(
      "mode {}, time {}, cycle {} ({:.3f} s), errors {}\n", answer.at("mode").get<std::string>(),
      answer.at("paused").get<bool>() ? "paused" : "runs", answer.at("cycle").get<std::uint64_t>(),
      answer.at("time_s").get<double>(), errors.empty() ? "none" : errors.dump());
}

int Ctl(const CtlFlags& flags, const Program& /*program*/) {
  const std::string line =
      server::AskControl(flags.socket, server::ControlRequestOf(flags.request));
  bool is_done = false;
  std::string text;
  try {
    const nlohmann::json answer = nlohmann::json::parse(line);
    is_done = answer.at("ok").get<bool>();
    text = is_done ? SummaryOf(answer) : answer.at("error").get<std::string>();
  } catch (const nlohmann::json::exception&) {
    throw EnvironmentError(fmt::format("{}: the program that answers there has no control channel",
                                       flags.socket.string()));
  }
  if (flags.json || is_done) Say(stdout, flags.json ? line + "\n" : text);
  FinishOutput();
  if (!is_done) throw RobotFault(text);
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
