#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "twin/model/lab_limits.h"
#include "twin/record/log_split.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// A served robot as its user asks for it. Fields are the user's words: messages call them by their
/// names, with `dash` before them.
struct ServeOptions {
  std::filesystem::path scenario;  ///< robot, scene, start; empty: the ready pose
  std::string yaml;  ///< the scenario's text, for scenario::ParseServed; empty: the file has it
  std::optional<std::string> lab;    ///< name or file (scenario::FindLab)
  std::optional<std::string> model;  ///< folder below models/robots, instead of the scenario's
  std::optional<std::filesystem::path> scene;  ///< instead of the scenario's
  std::optional<std::uint64_t> seed;           ///< instead of the scenario's
  std::optional<std::string> drive;            ///< absent: by what this host keeps
  std::optional<double> pace;                ///< lockstep: robot time over wall-clock time, at most
  std::string idle = "run";                  ///< or "freeze"
  std::optional<double> clock_ppm;           ///< of INT's clock; real time
  double session_timeout = 10;               ///< s, for an answer in lockstep
  std::optional<int> viability;              ///< as robot::RobotConfig's
  bool guard = false;                        ///< the robot keeps the limits of scenario and lab
  std::string reset = "never";               ///< or "on-connect", "on-command"
  std::optional<std::filesystem::path> out;  ///< folder of the session's results
  bool no_video = false;                     ///< in it
  std::optional<std::filesystem::path> log;
  std::optional<std::string> log_split;  ///< time or size (record::ParseLogSplit); absent: one file
  std::optional<std::uint64_t> log_keep;  ///< ended files of a split log that stay; absent: all
  std::optional<std::filesystem::path> capture;
  std::string_view dash = "";  ///< what stands before an option's name: "--" on command lines

  /// Whether time stands still between motions. @throws InputError for another word.
  [[nodiscard]] bool FreezesWhenIdle() const;
  /// How the log lies in files: synced, since no session can be repeated.
  /// @throws InputError for a text that is neither time nor size.
  [[nodiscard]] record::LogSplit SplitOfLog() const;
  /// @throws InputError for options out of range and those that do not go together.
  void Validate() const;
};

/// Who advances time, and the reason when the options do not say.
struct ServeDrive {
  scenario::Drive drive = scenario::Drive::kLockstep;
  std::optional<double> pace;
  std::string reason;

  [[nodiscard]] bool is_lockstep() const { return drive == scenario::Drive::kLockstep; }
};

/// Without options that decide: the wall clock where this host keeps 1 kHz, also for threads
/// without real-time priority, which takes a second and a half to measure; else lockstep at its
/// pace.
[[nodiscard]] ServeDrive DriveOf(const ServeOptions& options);

/// The scenario that is served. @param models  DataDirectory::models.
/// @throws InputError as scenario::LoadServed, scenario::FindLab and scenario::ApplyLab.
[[nodiscard]] scenario::Scenario ServedScenarioOf(const ServeOptions& options,
                                                  const ServeDrive& drive,
                                                  const std::filesystem::path& models);

/// When the robot begins anew.
enum class ResetPolicy : std::uint8_t { kNever, kOnCommand, kOnConnect };

/// @throws InputError for another word, and where it is not served in lockstep.
[[nodiscard]] ResetPolicy ResetPolicyOf(const ServeOptions& options, const ServeDrive& drive);

/// The limits that `guard` makes the robot keep; none without. @throws InputError with it where
/// neither scenario nor lab has any.
[[nodiscard]] model::LabLimits GuardOf(const ServeOptions& options,
                                       const scenario::Scenario& scenario);

}  // namespace twin::application
