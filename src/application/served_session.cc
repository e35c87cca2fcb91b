#include "twin/application/served_session.h"

#include <chrono>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "twin/application/session_results.h"
#include "twin/core/error.h"
#include "twin/fci/protocol.h"
#include "twin/rt/find_program.h"
#include "twin/run/remote.h"
#include "twin/run/robot_config.h"

namespace twin::application {
namespace {

constexpr std::uint32_t kFirstAddress = 0x7f000001;  // 127.0.0.1
constexpr std::uint32_t kLastAddress = 0x7f0000fe;   // 127.0.0.254

bool AreFree(std::uint32_t address, const server::ServerConfig& config) {
  try {
    const fci::TcpListener arm({address, config.arm_port});
    const fci::TcpListener hand({address, config.hand_port.value_or(fci::kHandPort)});
    return true;
  } catch (const EnvironmentError&) {
    return false;
  }
}

/// The URDF that clients get, whose names have no prefix.
std::string ServedModel(const std::filesystem::path& urdf) {
  std::ifstream file(urdf, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file || text.empty()) {
    throw EnvironmentError(fmt::format("{} cannot be read", urdf.string()));
  }
  constexpr std::string_view kPrefix = "panda_";
  for (std::size_t at = text.find(kPrefix); at != std::string::npos; at = text.find(kPrefix, at)) {
    text.erase(at, kPrefix.size());
  }
  return text;
}

/// @param first  the first that is considered. @throws EnvironmentError when there is none.
std::uint32_t FreeAddress(std::uint32_t first, const server::ServerConfig& config) {
  for (std::uint32_t address = first; address <= kLastAddress; ++address) {
    if (AreFree(address, config)) return address;
  }
  throw EnvironmentError(
      fmt::format("ports {} and {} are in use at all addresses from {} to {}; end a served robot",
                  config.arm_port, config.hand_port.value_or(fci::kHandPort),
                  fci::AddressText(kFirstAddress), fci::AddressText(kLastAddress)));
}

}  // namespace

ServedSession::ServedSession(const ServeOptions& options, ServeHost host)
    : options_((options.Validate(), options)),
      host_(std::move(host)),
      drive_(DriveOf(options_)),
      reset_(ResetPolicyOf(options_, drive_)),
      scenario_(ServedScenarioOf(options_, drive_, host_.files.models)),
      robot_data_(scenario::LoadRobotData(host_.files.models, scenario_.robot.model,
                                          scenario_.robot.hand)) {
  if (options_.out) PrepareResults();
  Open();
}

ServedSession::~ServedSession() = default;

void ServedSession::PrepareResults() {
  out_.emplace(*options_.out);
  if (!options_.scenario.empty()) out_->RequireOther(options_.scenario);
  if (options_.capture && out_->Holds(*options_.capture)) {
    throw InputError(
        fmt::format("{}capture: {} is one of the session's own results; name another file",
                    options_.dash, options_.capture->string()));
  }
  rt::RequireProgram(
      "gnuplot", host_.programs,
      fmt::format("apt-get install gnuplot-nox, or serve with {}log", options_.dash));
  if (scenario_.render.enabled && !options_.no_video) {
    rt::RequireProgram("ffmpeg", host_.programs,
                       fmt::format("apt-get install ffmpeg, or add {}no-video", options_.dash));
  }
  out_->Prepare();
}

void ServedSession::Open() {
  robot::RobotConfig config = run::MakeServedConfig(scenario_, host_.files);
  config.viability = options_.viability;
  config.onboard.guard = GuardOf(options_, scenario_);
  if (host_.place) host_.place(config.plant);
  server::ServedRobotSettings settings = MakeSettings();
  if (config.protocol == fci::VersionOf(fci::Protocol::k10)) {
    settings.server.robot_model = ServedModel(robot_data_.urdf);
  }
  if (!host_.takes_free_address) return OpenThere(config, std::move(settings));
  for (std::uint32_t first = kFirstAddress;; ++first) {
    first = FreeAddress(first, settings.server);
    settings.server.address = first;
    try {
      return OpenThere(config, settings);
    } catch (const EnvironmentError&) {
      if (AreFree(first, settings.server)) throw;  // else another program was faster
    }
  }
}

void ServedSession::OpenThere(const robot::RobotConfig& config,
                              server::ServedRobotSettings settings) {
  robot_.emplace(config, robot::MakePlant(config), std::move(settings));
}

server::ServedRobotSettings ServedSession::MakeSettings() {
  server::ServedRobotSettings settings;
  settings.server = host_.server;
  if (drive_.is_lockstep()) {
    settings.lockstep = {.answer_timeout = FromSeconds(options_.session_timeout),
                         .freeze_when_idle = options_.FreezesWhenIdle(),
                         .pace = drive_.pace};
  }
  if (host_.thread != nullptr) settings.thread = rt::ThreadSettings{.shared = host_.thread};
  if (reset_ == ResetPolicy::kOnConnect) {
    settings.server.on_arm_client = [this] {
      if (!robot_->lockstep()->Reset({})) Tell("arm: not reset: the hand executes a command");
    };
  }
  settings.tell = [this](std::string_view line) { Tell(line); };
  record::RecordSink* const records = has_log() ? &told_ : nullptr;
  settings.sink = host_.sink ? host_.sink(records) : records;
  if (options_.capture) settings.server.capture = &capture_.emplace(*options_.capture);
  return settings;
}

scenario::Scenario ServedSession::LoggedScenario() const {
  scenario::Scenario logged = scenario_;
  if (!options_.scenario.empty() || !options_.yaml.empty()) return logged;
  const reference::Waypoint stand{.q = logged.robot.q_start.value()};
  logged.motion.waypoints = {stand, stand};
  return logged;
}

void ServedSession::StartLog() {
  if (out_) out_->Clear();
  if (!has_log()) return;
  records_.Log(out_ ? out_->log() : *options_.log, run::InfoOf(LoggedScenario(), robot_data_),
               drive_.is_lockstep() ? record::FullRing::kWait : record::FullRing::kDrop,
               options_.SplitOfLog());
  // With scenes, so that pictures of it show hand and objects as they were, and with what the arm
  // touched when errors were raised.
  constexpr Duration kForever = std::chrono::hours(24 * 365);
  const plant::TruthProbe* truth = robot_->truth();
  if (truth == nullptr) return;
  records_.WatchContacts(*truth);
  if (!run::RunRecords::CanFilm(*truth)) return;
  records_.Film(*truth, kForever, scenario_.render.fps, render::SnapshotRecorder::Keep::kLast);
}

void ServedSession::Tell(std::string_view line) {
  const std::scoped_lock lock(telling_);
  if (has_log()) told_.Tell(line);
  if (host_.tell) host_.tell(line);
}

std::vector<std::string> ServedSession::NewLosses() {
  std::vector<std::string> losses;
  const auto look = [&](bool& told, const std::string& failure) {
    if (told || failure.empty()) return;
    told = true;
    losses.push_back(failure + ". It goes on without");
  };
  look(told_of_log_, records_.LogFailure());
  if (capture_) look(told_of_capture_, capture_->Failure());
  return losses;
}

void ServedSession::End(const std::function<void(std::string_view)>& note) {
  robot_->End();
  told_.Finish();
  static_cast<void>(records_.Finish());
  if (capture_) run::FinishCapture(*capture_, note);
}

void ServedSession::WriteResults(run::Console& console) const {
  const plant::TruthProbe* truth = robot_->truth();
  const bool has_scenes = truth != nullptr && run::RunRecords::CanFilm(*truth);
  const scenario::Scenario logged = LoggedScenario();
  WriteSessionResults({.out = *out_,
                       .scenario = logged,
                       .robot = robot_data_,
                       .files = host_.files,
                       .makes_video = has_scenes && scenario_.render.enabled && !options_.no_video,
                       .facts = {{"robot", scenario_.robot.model},
                                 {"seed", fmt::format("{}", scenario_.seed)},
                                 {"drive", std::string(scenario_.drive_name())},
                                 {"panda-twin", TWIN_VERSION}},
                       .console = console});
}

}  // namespace twin::application
