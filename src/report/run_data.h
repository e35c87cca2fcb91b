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

/// Counts of a run over time, in bounded memory: as in Envelope, neighbouring spans are merged when
/// there are too many.
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
  std::string name;  ///< of the error, with the number of further errors, if any
};

/// Data from a run's log for its plots.
struct RunData {
  /// Bins of an envelope: about the pixels of a panel.
  static constexpr std::size_t kBins = 400;
  /// Later motions are not marked.
  static constexpr std::size_t kMostMotions = 100;

  std::string scenario;
  bool truncated = false;
  bool by_torque = false;  ///< torques were commanded: errors refer to q_ext, not q_d
  double begin = 0;        ///< s
  double end = 0;          ///< s
  FateCounts total;
  std::optional<Abort> abort;      ///< the first
  std::vector<double> motions;     ///< start times, s; at most kMostMotions
  std::uint32_t longest_loss = 0;  ///< most cycles held in a row
  JointVector peak_dq{};           ///< magnitude, rad/s
  JointVector peak_dq_d{};         ///< magnitude, rad/s
  JointVector peak_dddq_d{};       ///< magnitude, rad/s^3
  JointVector peak_error{};        ///< magnitude, mrad
  JointVector peak_deviation{};    ///< magnitude, mrad
  JointVector peak_tau{};          ///< of tau_J and tau_J_d, magnitude, Nm

  Envelope q{kJoints, kBins};
  Envelope q_d{kJoints, kBins};
  Envelope dq{kJoints, kBins};
  Envelope dq_d{kJoints, kBins};
  Envelope dddq_d{kJoints, kBins};
  Envelope tau_J{kJoints, kBins};
  Envelope tau_J_d{kJoints, kBins};
  Envelope q_ext{kJoints, kBins};       ///< of ticks with a target
  Envelope dq_ext{kJoints, kBins};      ///< likewise
  Envelope error{kJoints, kBins};       ///< TrackingError, mrad
  Envelope deviation{kJoints, kBins};   ///< q_ext - q by TargetMatch, mrad; of ticks with a target
  Envelope success_rate{1, 2 * kBins};  ///< while a motion runs
  Envelope d_EXT{1, 2 * kBins};         ///< us, of ticks that wrote a command
  record::FilterCounts filter;          ///< of the viability filter; zero commands without one
  Envelope margin{1, 2 * kBins};        ///< TickRecord::margin
  Envelope kept_back{kJoints, kBins};   ///< i + 1 when the filter changed joint i (from 0)
  FateHistory fates;
};

/// Reads a log in one pass. @throws InputError if it is damaged or has no cycle; EnvironmentError
/// if it cannot be read.
[[nodiscard]] RunData ReadRun(const std::filesystem::path& log);

}  // namespace twin::report
