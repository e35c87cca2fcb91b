#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "cli/command.h"
#include "cli/shared_flags.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {

/// What the command `run` is told.
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
  PageFlags page;
  DataFlags data;
};

/// The scenario with what the command line says in its place, validated.
/// @throws InputError as scenario::Load, and for flags that do not go together.
[[nodiscard]] scenario::Scenario LoadWithFlags(const RunFlags& flags, const Host& host);

/// Runs a scenario and writes what came of it. @throws twin::Error; Interrupted.
[[nodiscard]] int Run(const RunFlags& flags, const Program& program);

}  // namespace twin::cli
