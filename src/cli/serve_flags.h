#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "cli/shared_flags.h"
#include "twin/scenario/scenario.h"
#include "twin/server/served_robot.h"

// Flags of the command serve: what they mean, and what it prints of them at its start.
namespace twin::cli {

struct ServeFlags {
  std::filesystem::path scenario;              ///< robot, scene, start; empty: the ready pose
  std::optional<std::string> lab;              ///< as run's
  std::optional<std::filesystem::path> scene;  ///< instead of the scenario's
  std::optional<std::uint64_t> seed;
  NetworkFlags network;
  std::optional<std::string> drive;  ///< absent: by what this host keeps
  std::optional<double> pace;        ///< lockstep: robot time over wall-clock time, at most
  std::string idle = "run";          ///< or "freeze"
  std::optional<double> clock_ppm;   ///< of INT's clock; real time
  double session_timeout = 10;       ///< s, for an answer in lockstep
  std::optional<int> viability;      ///< as robot::RobotConfig's
  bool guard = false;                ///< the robot keeps the limits of scenario and lab
  std::string reset = "never";       ///< or "on-connect", "on-command"
  std::optional<double> seconds;     ///< after which it ends; absent: when it is interrupted
  std::optional<std::filesystem::path> out;  ///< folder of the session's results
  bool no_video = false;                     ///< in it
  std::optional<std::filesystem::path> log;
  std::optional<std::filesystem::path> capture;
  std::optional<std::filesystem::path> control;  ///< Unix socket of the control channel
  PageFlags page;
  DataFlags data;
};

/// Who advances time, and the reason when the flags do not say.
struct ServeDrive {
  scenario::Drive drive = scenario::Drive::kLockstep;
  std::optional<double> pace;
  std::string reason;

  [[nodiscard]] bool is_lockstep() const { return drive == scenario::Drive::kLockstep; }
};

/// Without flags that decide: the wall clock where this host keeps 1 kHz, also for threads without
/// real-time priority, which takes a second and a half to measure; else lockstep at its pace.
[[nodiscard]] ServeDrive DriveOf(const ServeFlags& flags);

/// The scenario that is served. @throws InputError as scenario::Load.
[[nodiscard]] scenario::Scenario ServedScenarioOf(const ServeFlags& flags, const ServeDrive& drive,
                                                  const Host& host);

/// --idle. @throws InputError.
[[nodiscard]] bool FreezesWhenIdle(const ServeFlags& flags);

/// When the robot begins anew.
enum class ResetPolicy : std::uint8_t { kNever, kOnCommand, kOnConnect };

/// The limits that --guard makes the robot keep; none without. @throws InputError with --guard
/// where neither scenario nor lab has any.
[[nodiscard]] model::LabLimits GuardOf(const ServeFlags& flags, const scenario::Scenario& scenario);

/// --reset. @throws InputError for another word, and where it is not served in lockstep.
[[nodiscard]] ResetPolicy ResetPolicyOf(const ServeFlags& flags, const ServeDrive& drive);

/// @throws InputError for flags that do not go together.
void RequireServeAgreement(const ServeFlags& flags);

/// What the robot is, how its time passes, where and how programs made for it connect, and what
/// ends it: lines.
[[nodiscard]] std::string IntroductionOf(const ServeFlags& flags, const ServeDrive& drive,
                                         const scenario::Scenario& scenario,
                                         const server::ServedRobot& robot);

}  // namespace twin::cli
