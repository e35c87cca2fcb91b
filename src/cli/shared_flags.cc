#include "cli/shared_flags.h"

#include <limits>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/integer.h"
#include "twin/model/model_library.h"
#include "twin/plant/model_cache.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {
namespace {

/// CLI11 would take -1 as a large number, clamp what is too large, and read 010 as octal.
std::uint64_t ParseSeed(const std::string& text) {
  if (const auto seed = ParseInteger<std::uint64_t>(text)) return *seed;
  throw CLI::ValidationError("--seed",
                             fmt::format("\"{}\" is not a whole number from 0 to {}", text,
                                         std::numeric_limits<std::uint64_t>::max()));
}

/// The folder of compiled models, made fit for use; empty, with a note, when it cannot be used.
std::filesystem::path UsableCache(const Program& program) {
  const std::filesystem::path& cache = program.host.cache;
  const auto note = [&program](std::string_view text) { program.log->info(text); };
  return cache.empty() || !plant::RepairModelCache(cache, note) ? std::filesystem::path() : cache;
}

}  // namespace

void RefuseIf(bool wrong, const char* why) {
  if (wrong) throw InputError(why);
}

void AddData(CLI::App& app, DataFlags& flags) {
  Add(app, "--data DIR", flags.models, "Folder of models, if not beside the program");
  Add(app, "--meshes DIR", flags.meshes, "Folder panda_description with the robot's meshes");
}

scenario::DataDirectory DataOf(const DataFlags& flags, const Host& host) {
  return scenario::FindDataDirectory(
      {host.executable, flags.models, flags.meshes.empty() ? host.meshes : flags.meshes});
}

run::RunFiles FilesOf(const DataFlags& flags, const Program& program) {
  const scenario::DataDirectory data = DataOf(flags, program.host);
  run::RunFiles files{data.models, data.mesh_package, UsableCache(program), false};
  program.log->debug("models {}, meshes {}, cache {}", files.models.string(),
                     files.mesh_package.string(), files.cache.string());
  return files;
}

std::vector<std::byte> ModelLibraryOf(const Program& program) {
  try {
    return model::ReadModelLibrary(model::FindModelLibrary(program.host.executable));
  } catch (const EnvironmentError& error) {
    program.log->info("clients get no model library: {}", error.what());
    return {};
  }
}

void AddNetwork(CLI::App& app, NetworkFlags& flags) {
  Add(app, "--bind", flags.bind, "Address to listen at")->capture_default_str();
  Add(app, "--allow CIDR", flags.allow, "Network that may connect, such as 192.168.1.0/24");
  Add(app, "--port", flags.arm_port, "TCP port of the arm; 0: any")->capture_default_str();
  Add(app, "--hand-port", flags.hand_port,
      "TCP port of the hand; 0: any (default: 1338, a cobot pump's 1339)");
}

Listening ListeningAt(const std::string& bind, const std::optional<std::string>& allow,
                      std::string_view bind_flag, std::string_view allow_flag) {
  Listening listening;
  listening.address = fci::Resolve(bind, 0).address;
  if (allow) listening.allow = fci::ParseNetwork(*allow);
  if (fci::IsLoopback(listening.address) || listening.allow) return listening;
  throw InputError(
      fmt::format("{0} {1} lets other machines move the robot: name the network that may, with {2} "
                  "ADDRESS/BITS, or leave {0} out",
                  bind_flag, bind, allow_flag));
}

std::string DescribeAccess(const NetworkFlags& flags) {
  if (!flags.allow) return "open to this machine only";
  return fmt::format(
      "open to this machine and to {}: who is there can move the robot, without a password",
      *flags.allow);
}

/// Takes its port behind a '=' only: what follows it is the scenario.
void AddPage(CLI::App& app, PageFlags& flags) {
  app.add_flag("--page{8080}", flags.port,
               "Show it in a browser: --page, or --page=PORT (0: any free one); the address is "
               "printed")
      ->type_name("PORT");
  Add(app, "--page-bind ADDRESS", flags.bind, "Address of this machine to serve the page at")
      ->capture_default_str();
  Add(app, "--page-allow ADDRESS/BITS", flags.allow,
      "Network that may open the page, beside this machine");
}

page::PageSettings PageAt(const PageFlags& flags) {
  const auto port = ParseInteger<std::uint16_t>(flags.port);
  if (!port) {
    throw InputError(fmt::format("--page is \"{}\"; it must be a port in [0, 65535]", flags.port));
  }
  const Listening listening = ListeningAt(flags.bind, flags.allow, "--page-bind", "--page-allow");
  page::PageSettings settings;
  settings.at = {.address = listening.address, .port = *port};
  settings.allow = listening.allow;
  return settings;
}

PageFlags PageOf(const PageFlags& flags, std::size_t robot) {
  PageFlags own = flags;
  if (!flags.wanted()) return own;
  const std::uint16_t first = PageAt(flags).at.port;
  if (first != 0) own.port = std::to_string(first + robot);
  return own;
}

void RequirePageFlags(const PageFlags& flags) {
  if (flags.wanted()) {
    static_cast<void>(PageAt(flags));
  } else if (flags.allow || flags.bind != PageFlags().bind) {
    throw InputError("--page-bind and --page-allow go with --page");
  }
}

void AddSeed(CLI::App& app, std::optional<std::uint64_t>& seed, const char* what) {
  app.add_option_function<std::string>(
         "--seed", [&seed](const std::string& text) { seed = ParseSeed(text); }, what)
      ->type_name("UINT");
}

std::filesystem::path ScenarioFile(const std::filesystem::path& named, const DataFlags& data,
                                   const Host& host) {
  return scenario::FindScenario(named, DataOf(data, host).models);
}

scenario::Scenario LoadScenario(const std::filesystem::path& named, const DataFlags& data,
                                const Host& host) {
  return scenario::Load(ScenarioFile(named, data, host));
}

void AddMayTouch(CLI::App& app, std::string& reason) {
  Add(app, "--no-collision-check REASON", reason,
      "The arm may touch something on its way, for this reason (motion.touches)");
}

void AddLab(CLI::App& app, std::optional<std::string>& lab) {
  Add(app, "--lab NAME|FILE", lab, "Site laid over the scenario: a, b (models/labs), or a file");
}

void ReplaceSite(const std::optional<std::string>& lab, const std::optional<std::uint64_t>& seed,
                 const DataFlags& data, const Host& host, scenario::Scenario& scenario) {
  if (lab) scenario::ApplyLab(scenario::FindLab(*lab, DataOf(data, host).models), scenario);
  if (seed) scenario.seed = *seed;
}

void RequireDuration(const std::optional<double>& seconds) {
  if (seconds && !(*seconds > 0)) {
    throw InputError(fmt::format("--for is {} s; it must be above 0", *seconds));
  }
}

std::string DataInShell(const DataFlags& data) {
  std::string text;
  if (!data.models.empty()) text += " --data " + InShell(data.models.string());
  if (!data.meshes.empty()) text += " --meshes " + InShell(data.meshes.string());
  return text;
}

}  // namespace twin::cli
