#pragma once

#include <cstdint>
#include <vector>

#include "experiment/recording.h"
#include "experiment/spectrum.h"
#include "experiment/tempos.h"
#include "twin/core/joint_vector.h"
#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// What makes the commands of a motion.
enum class Maker : std::uint8_t {
  kOurs,   ///< the rejoining generator, and the viability filter behind it
  kPaper,  ///< the paper's generator, lambda = 1e-3, and the stall bridge
};

/// What disturbs it.
enum class Disturbance : std::uint8_t {
  kThread,      ///< the asynchronous thread's: 4 us of jitter, 50 ppm of drift, 0.41 % lost
  kBursts,      ///< the same jitter and drift, and runs of 19 lost commands, two a second
  kCalibrated,  ///< the calibrated asynchronous loop, as it is
};

struct ViabilityCase {
  Tempo tempo;
  Disturbance disturbance = Disturbance::kThread;
  Maker maker = Maker::kOurs;
};

/// One motion, on the ideal plant.
struct ViabilityRun {
  bool aborted = false;
  bool succeeded = false;
  double idle_percent = 0;  ///< of the commands: those that the filter let pass; ours only
  double least_margin = 0;  ///< of the state; ours only
  double delay_s = 0;       ///< of q_d behind the plan
  double rms = 0;           ///< error of q_d, less that delay: worst joint, rad
  JointVector band{};       ///< power of dq_d between 20 and 150 Hz, (rad/s)^2
  Spectrum spectrum;        ///< of dq_d, joint 1
  std::vector<TickSample> ticks;
};

/// @param run  which of the case's runs: gives its seed and start phase, the same for every maker.
/// @throws as RunScenario.
[[nodiscard]] ViabilityRun RunViabilityCase(const Setting& setting, const ViabilityCase& what,
                                            int run);

}  // namespace twin::experiment
