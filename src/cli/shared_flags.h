#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/command.h"
#include "twin/core/text.h"
#include "twin/fci/protocol.h"
#include "twin/fci/sockets.h"
#include "twin/page/live_page.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/scenario.h"

// Flags that several commands have, how they are added, and what they mean. What Add... fills must
// outlive the app.
namespace twin::cli {

/// @throws InputError saying `why` when the flags are wrong.
void RefuseIf(bool wrong, const char* why);

/// Folders of data; empty: to be found.
struct DataFlags {
  std::filesystem::path models;
  std::filesystem::path meshes;
};
void AddData(CLI::App& app, DataFlags& flags);
/// @throws as scenario::FindDataDirectory.
[[nodiscard]] scenario::DataDirectory DataOf(const DataFlags& flags, const Host& host);
/// The same, for a run. Prints a note when compiled models cannot be kept.
[[nodiscard]] run::RunFiles FilesOf(const DataFlags& flags, const Program& program);

/// The library that a served robot sends to its clients; empty, with a note, when there is none.
[[nodiscard]] std::vector<std::byte> ModelLibraryOf(const Program& program);

struct Listening {
  std::uint32_t address = 0;
  std::optional<fci::Network> allow;
};
/// @param bind_flag, allow_flag  what the flags are called, for messages.
/// @throws InputError when an address is none, or others could connect without being named.
[[nodiscard]] Listening ListeningAt(const std::string& bind,
                                    const std::optional<std::string>& allow,
                                    std::string_view bind_flag, std::string_view allow_flag);

/// Address of a command's server, and the network that may connect: by default this machine only,
/// since a client can move the robot.
struct NetworkFlags {
  std::string bind = "127.0.0.1";
  std::optional<std::string> allow;  ///< network that may connect
  std::uint16_t arm_port = fci::kArmPort;
  std::optional<std::uint16_t> hand_port;  ///< absent: the hand's own
};
void AddNetwork(CLI::App& app, NetworkFlags& flags);
/// Puts address, ports and network into a configuration that has them.
/// @throws InputError when an address is none, or others could connect without being named.
template <typename Config>
void Listen(const NetworkFlags& flags, Config& config) {
  const Listening at = ListeningAt(flags.bind, flags.allow, "--bind", "--allow");
  config.address = at.address;
  config.allow = at.allow;
  config.arm_port = flags.arm_port;
  config.hand_port = flags.hand_port;
}
/// Text on which machines may connect.
[[nodiscard]] std::string DescribeAccess(const NetworkFlags& flags);

/// The operator's page.
struct PageFlags {
  std::string port;  ///< as given; 0: any free one; empty: no page
  std::string bind = "127.0.0.1";
  std::optional<std::string> allow;  ///< network that may connect
  [[nodiscard]] bool wanted() const noexcept { return !port.empty(); }
};
void AddPage(CLI::App& app, PageFlags& flags);
/// @throws InputError when an address is none, a port is out of range, or others could connect
/// without being named.
[[nodiscard]] page::PageSettings PageAt(const PageFlags& flags);
/// Of several robots, each with a page: the port that was given, and those after it.
[[nodiscard]] PageFlags PageOf(const PageFlags& flags, std::size_t robot);
/// Before anything is done. @throws InputError as PageAt, and for flags of a page without --page.
void RequirePageFlags(const PageFlags& flags);

void AddSeed(CLI::App& app, std::optional<std::uint64_t>& seed,
             const char* what = "Seed of all random numbers, instead of the scenario's");
/// The file of a command's scenario (scenario::FindScenario).
[[nodiscard]] std::filesystem::path ScenarioFile(const std::filesystem::path& named,
                                                 const DataFlags& data, const Host& host);
/// The scenario of a command: a file, or one of the installed models (scenario::FindScenario).
/// @throws InputError as scenario::Load; as DataOf.
[[nodiscard]] scenario::Scenario LoadScenario(const std::filesystem::path& named,
                                              const DataFlags& data, const Host& host);
/// @param reason  instead of the scenario's motion.touches.
void AddMayTouch(CLI::App& app, std::string& reason);
void AddLab(CLI::App& app, std::optional<std::string>& lab);

/// Replaces a scenario's site and seed by those that are given.
/// @throws as DataOf, scenario::FindLab and scenario::ApplyLab.
void ReplaceSite(const std::optional<std::string>& lab, const std::optional<std::uint64_t>& seed,
                 const DataFlags& data, const Host& host, scenario::Scenario& scenario);

/// The folders of data that a command names: " --data DIR".
[[nodiscard]] std::string DataInShell(const DataFlags& data);

/// --for. @throws InputError unless it is above 0.
void RequireDuration(const std::optional<double>& seconds);

}  // namespace twin::cli
