#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "report/envelope.h"
#include "twin/core/joint_vector.h"
#include "twin/record/cycle_record.h"
#include "twin/record/log_reader.h"

namespace twin::report {

/// Cycles by their fate, over a span of cycles.
struct FateCounts {
  double begin = 0;  ///< s
  std::uint64_t served = 0;
  std::uint64_t held = 0;
  std::uint64_t none = 0;
  std::uint64_t dropped = 0;  ///< commands

  [[nodiscard]] std::uint64_t cycles() const { return served + held + none; }
  void Add(const FateCounts& other);
};

/// Counts of a run over time, in bounded memory: like Envelope, spans are merged when they are too
/// many.
class FateHistory {
 public:
  void Add(const record::CycleRecord& cycle);

  /// All spans but the last hold the same number of cycles.
  [[nodiscard]] const std::vector<FateCounts>& spans() const { return spans_; }
  [[nodiscard]] std::uint64_t cycles_per_span() const { return cycles_per_span_; }

 private:
  std::uint64_t cycles_per_span_ = 10;
  std::vector<FateCounts> spans_;
};

/// The error that ended a motion.
struct Abort {
  double time = 0;   ///< s
  std::string name;  ///< of the error; with how many others, if there are
};

/// What the plots of a run need of its log.
struct RunData {
  /// Bins of an envelope: about the pixels of a panel.
  static constexpr std::size_t kBins = 400;
  /// Later ones are not told apart.
  static constexpr std::size_t kMostMotions = 100;

  std::string scenario;
  bool truncated = false;
  bool by_torque = false;  ///< torques were commanded: the error is of q_ext, not q_d
  double begin = 0;        ///< s
  double end = 0;          ///< s
  FateCounts total;
  std::optional<Abort> abort;      ///< the first
  std::vector<double> motions;     ///< when they began, s; at most kMostMotions
  std::uint32_t longest_loss = 0;  ///< most cycles held in a row
  JointVector peak_dq{};           ///< magnitude, rad/s
  JointVector peak_dq_d{};         ///< magnitude, rad/s
  JointVector peak_dddq_d{};       ///< magnitude, rad/s^3
  JointVector peak_error{};        ///< magnitude, mrad
  JointVector peak_tau{};          ///< of tau_J and tau_J_d, magnitude, Nm

  Envelope q{kJoints, kBins};
  Envelope q_d{kJoints, kBins};
  Envelope dq{kJoints, kBins};
  Envelope dq_d{kJoints, kBins};
  Envelope dddq_d{kJoints, kBins};
  Envelope tau_J{kJoints, kBins};
  Envelope tau_J_d{kJoints, kBins};
  Envelope q_ext{kJoints, kBins};       ///< of ticks that had a target
  Envelope dq_ext{kJoints, kBins};      ///< of the same
  Envelope error{kJoints, kBins};       ///< TrackingError, mrad
  Envelope success_rate{1, 2 * kBins};  ///< while a motion runs
  Envelope d_EXT{1, 2 * kBins};         ///< us, of ticks that wrote a command
  record::FilterCounts filter;          ///< of a viability filter; no commands without one
  Envelope margin{1, 2 * kBins};        ///< TickRecord::margin
  Envelope kept_back{kJoints, kBins};   ///< joint i, from 0, was kept back: i + 1
  FateHistory fates;
};

/// Reads a log in one pass. @throws InputError when it is damaged or holds no cycle;
/// EnvironmentError when it cannot be read.
[[nodiscard]] RunData ReadRun(const std::filesystem::path& log);

}  // namespace twin::report
