#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "twin/core/modes.h"
#include "twin/core/setting.h"
#include "twin/robot/robot_config.h"

namespace twin::test {

/// Something that is done to an otherwise sound stream of commands.
enum class Mischief : std::uint8_t {
  kEdge,          ///< from now on goes to `size` times a limit of joint or axis `axis`
  kStep,          ///< the command of one cycle is off by `size`
  kNotANumber,    ///< one value of one command
  kInfinite,      ///< one value of one command
  kHuge,          ///< one value of one command, 1e300
  kWrongId,       ///< a command answers another state, `size` cycles off
  kBadFrame,      ///< no rigid transform
  kObliqueFrame,  ///< a rotation off by `size`, within what a robot bears
  kElbowSign,     ///< the wrong sign
  kElbowSwitch,   ///< from now on the elbow is commanded, or no longer
  kFinish,        ///< asks for the end while the arm moves
  kLoss,          ///< `count` cycles without a command
  kDouble,        ///< `count` commands in one cycle, of which the last is the sound one
  kTorqueStep,    ///< the torque of one cycle is off by `size`
  kStop,
  kRecover,
  kStartAgain,
  kSet,    ///< a setting, good or bad, drawn by `count`
  kPanel,  ///< action number `count`
};

inline constexpr int kMischiefs = 19;

[[nodiscard]] std::string_view Name(Mischief mischief);

/// Which limit an edge is about.
enum class Edge : std::uint8_t { kJerk, kAcceleration, kVelocity, kPosition };

/// A mischief at a cycle of the stream, counted from the first command.
struct Disturbance {
  int cycle = 0;
  Mischief mischief{};
  std::size_t axis = 0;
  double size = 0;
  int count = 0;
  Edge edge{};
};

/// How a stream ends when nothing else ends it.
enum class StreamEnd : std::uint8_t { kFinish, kStop, kSilence };

/// One stream: a robot, a motion, and what is done to it. A pure function of the seed.
struct StreamPlan {
  std::uint64_t seed = 0;
  robot::RobotConfig robot;
  std::vector<Setting> settings;  ///< made before the motion
  MotionModes modes;
  bool with_elbow = false;
  bool hostile = false;
  double vigour = 0;  ///< share of the limits the motion uses
  int idle_cycles = 0;
  int waiting_cycles = 0;     ///< between the motion's start and the first command
  bool answers_idle = false;  ///< a command for the last state before the motion comes late
  double start_offset = 0;    ///< of the first command, in joint or axis `start_axis`
  std::size_t start_axis = 0;
  int cycles = 0;
  StreamEnd end{};
  bool goes_on = false;  ///< recovers and moves once more
  std::vector<Disturbance> disturbances;
};

[[nodiscard]] StreamPlan DrawPlan(std::uint64_t seed);

/// For people: the stream in some lines.
[[nodiscard]] std::string Describe(const StreamPlan& plan);

/// A setting drawn by number: good ones, bad ones.
[[nodiscard]] Setting DrawSetting(std::uint64_t number);

}  // namespace twin::test
