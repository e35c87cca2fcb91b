#include <array>

#include "experiment/studies.h"

namespace twin::experiment {
namespace {

// In the order of the paper.
constexpr std::array kExperiments{
    Experiment{"timings", "Loop timings (Table 1)",
               "Section 2, Table 1 and the figure of read-to-read intervals", &RunTimings,
               &RunTimingsOnWallClock},
    Experiment{"jitter", "Sampling jitter", "Section 3, figure on jitter", &RunJitter,
               &RunJitterOnWallClock},
    Experiment{"noise", "Noise on the commanded positions", "Section 2, on what INT differentiates",
               &RunNoise},
    Experiment{"feed_forward", "The feed-forward of the reference generator",
               "Section 4, reference generation", &RunFeedForwardStudy},
    Experiment{"tracking", "Position control: velocity and its spectrum",
               "Section 5, figure of position control", &RunTracking, &RunTrackingOnWallClock},
    Experiment{"rate_matching", "Rate matching", "Sections 4 and 5, figure of rate matching",
               &RunRateMatching, &RunRateMatchingOnWallClock},
    Experiment{"lambda", "The correction lambda of the reference generator",
               "Section 4, reference generation", &RunLambda},
    Experiment{"losses", "Bursts of lost commands", "left open by the paper (its outlook)",
               &RunLosses},
    Experiment{"viability", "Guaranteed limits under loss", "left open by the paper (its outlook)",
               &RunViability},
};

}  // namespace

Findings Run(const Experiment& experiment, const Config& config) {
  Findings findings =
      config.on_wall_clock ? experiment.run_on_wall_clock(config) : experiment.run(config);
  findings.id = experiment.id;
  findings.title = experiment.title;
  findings.source = experiment.source;
  findings.page = config.on_wall_clock ? findings.id + "_wall_clock" : findings.id;
  return findings;
}

std::span<const Experiment> Experiments() noexcept {
  return kExperiments;
}

}  // namespace twin::experiment
