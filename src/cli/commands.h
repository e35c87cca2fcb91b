#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/exit_code.h"
#include "twin/fci/protocol.h"
#include "twin/run/run.h"

namespace twin::cli {

/// What the host tells the program. The environment is read in main, and nowhere else.
struct Host {
  std::filesystem::path executable;
  std::filesystem::path cache;  ///< folder of compiled models
  std::string path;             ///< the search path of programs
};

/// Where the user says the data is; empty: sought.
struct DataFlags {
  std::filesystem::path models;
  std::filesystem::path meshes;
};

/// Where a command listens, and who may connect.
struct NetworkFlags {
  std::string bind = "127.0.0.1";
  std::optional<std::string> allow;  ///< network that may connect
  std::uint16_t arm_port = fci::kArmPort;
  std::uint16_t hand_port = fci::kHandPort;
};

/// The operator's page.
struct PageFlags {
  std::string port;  ///< as given; 0: any free one; empty: no page
  std::string bind = "127.0.0.1";
  std::optional<std::string> allow;  ///< network that may connect
  [[nodiscard]] bool wanted() const noexcept { return !port.empty(); }
};

struct RunFlags {
  std::filesystem::path scenario;
  std::optional<std::string> lab;  ///< laid over the scenario: a name in models/labs, or a file
  std::optional<std::uint64_t> seed;
  std::filesystem::path out;  ///< empty: out/<scenario's name>
  std::optional<std::string> backend;
  std::optional<std::string> drive;
  std::optional<std::string> device;      ///< of the operator, in place of the scenario's
  std::optional<std::string> robot;       ///< backend fci: HOST[:PORT]
  std::optional<std::string> robot_time;  ///< backend fci: wall or states
  bool allow_hardware = false;            ///< backend fci: the robot need not be a twin
  std::optional<double> max_speed;        ///< share of the scenario's, in (0, 1]
  std::optional<double> clock_ppm;        ///< of INT's clock
  std::optional<int> ext_cpu;             ///< processor of the communication thread; real time
  std::optional<int> int_cpu;             ///< processor of the robot's thread; real time
  std::optional<std::filesystem::path> capture;  ///< backend fci
  std::optional<int> seeds;  ///< of an application: so many, one run each, from the seed on
  int threads = 2;           ///< with seeds
  double least_share = 100;  ///< with seeds: percent that must succeed
  bool strict = false;       ///< an arm that was too far off its path is a failure
  bool no_video = false;
  bool rebuild_cache = false;
  bool quiet = false;
  PageFlags page;
  DataFlags data;
};

struct ServeFlags {
  std::filesystem::path scenario;              ///< robot, scene, start; empty: the ready pose
  std::optional<std::string> lab;              ///< as run's
  std::optional<std::filesystem::path> scene;  ///< instead of the scenario's
  std::optional<std::uint64_t> seed;
  NetworkFlags network;
  std::string drive = "realtime";
  std::string idle = "run";         ///< or "freeze"
  std::optional<double> clock_ppm;  ///< of INT's clock; real time
  double session_timeout = 10;      ///< s, for an answer in lockstep
  std::optional<int> viability;     ///< as robot::RobotConfig's
  std::optional<double> seconds;    ///< after which it ends; absent: when it is interrupted
  std::optional<std::filesystem::path> log;
  std::optional<std::filesystem::path> capture;
  PageFlags page;
  DataFlags data;
};

struct ProxyFlags {
  std::string robot;  ///< HOST[:PORT]
  NetworkFlags network;
  std::filesystem::path link;                                    ///< file of faults; empty: none
  std::vector<std::pair<std::string_view, std::string>> faults;  ///< keys of a link, and values
  std::uint64_t seed = 1;
  std::optional<int> cpu;         ///< of the threads that relay
  std::optional<double> seconds;  ///< as serve's
};

struct ExperimentFlags {
  std::vector<std::string> ids;  ///< or all
  std::optional<std::uint64_t> seed;
  std::string drive = "lockstep";  ///< or realtime
  std::optional<int> seeds;        ///< runs of what is averaged, in [1, 1000]; 20, in realtime 5
  std::optional<std::filesystem::path> out;  ///< out/experiments, or out/experiments_realtime
  std::optional<std::filesystem::path> calibration;  ///< instead of models/experiments
  std::optional<std::string> client;                 ///< a program to be timed, for /bin/sh
  std::uint16_t port = 1337;                         ///< where the client finds the arm
  std::optional<double> seconds;                     ///< after which the client is ended
  bool list = false;                                 ///< only say which there are
  bool quiet = false;
  DataFlags data;
};

struct ValidateFlags {
  std::filesystem::path scenario;
  bool load = false;  ///< also code of controller.library
  DataFlags data;
};

struct CheckFlags {
  double seconds = 2;  ///< of each measurement, in [0.5, 60]
  DataFlags data;
};

struct ExportFlags {
  std::filesystem::path log;
  std::filesystem::path out;  ///< empty: csv beside the log
};

struct ExplainFlags {
  std::filesystem::path log;  ///< or a run's folder; empty with errors or modes
  std::filesystem::path out;  ///< of the page; empty: beside the log
  bool errors = false;        ///< the catalogue of errors instead
  bool modes = false;         ///< what the robot grants in which mode instead
};

struct DecodeFlags {
  std::filesystem::path capture;
  bool brief = false;
  std::uint16_t arm_port = fci::kArmPort;
  std::uint16_t hand_port = fci::kHandPort;
};

/// Runs a scenario and writes what came of it. @throws twin::Error.
[[nodiscard]] ExitCode RunCommand(const RunFlags& flags, const Host& host,
                                  const run::Catalogue& catalogue);

/// Serves a robot over the Franka Control Interface until it is interrupted. @throws twin::Error.
[[nodiscard]] ExitCode ServeCommand(const ServeFlags& flags, const Host& host,
                                    const run::Catalogue& catalogue);

/// Relays a robot's wire with faults until it is interrupted. @throws twin::Error.
[[nodiscard]] ExitCode ProxyCommand(const ProxyFlags& flags);

/// Reproduces the paper's tables and figures and writes the report. @returns kFailed when one could
/// not be done or missed what is demanded of it. @throws twin::Error; Interrupted.
[[nodiscard]] ExitCode ExperimentCommand(const ExperimentFlags& flags, const Host& host,
                                         const run::Catalogue& catalogue);

/// Checks a scenario without running it. @throws twin::Error.
[[nodiscard]] ExitCode ValidateCommand(const ValidateFlags& flags, const Host& host,
                                       const run::Catalogue& catalogue);

/// Says what this host offers, and measures how well it keeps time. @throws InputError for a
/// duration out of range, RobotFault when something is missing.
[[nodiscard]] ExitCode CheckCommand(const CheckFlags& flags, const Host& host);

/// Writes a log as CSV. @throws twin::Error.
[[nodiscard]] ExitCode ExportCommand(const ExportFlags& flags);

/// Says how the run of a log ended, and why; of an aborted run also as a page. @throws twin::Error.
[[nodiscard]] ExitCode ExplainCommand(const ExplainFlags& flags);

/// Prints what was said over the wire. @throws twin::Error.
[[nodiscard]] ExitCode DecodeCommand(const DecodeFlags& flags);

/// Version, MuJoCo's version and the compiler, for people.
[[nodiscard]] std::string VersionText();

}  // namespace twin::cli
