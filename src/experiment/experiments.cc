#include <array>

#include "experiment/feed_forward.h"
#include "experiment/jitter.h"
#include "experiment/lambda.h"
#include "experiment/losses.h"
#include "experiment/noise.h"
#include "experiment/rate_matching.h"
#include "experiment/timings.h"
#include "experiment/tracking.h"
#include "experiment/viability.h"
#include "twin/experiment/experiment.h"

namespace twin::experiment {
namespace {

// In the order of the paper.
constexpr std::array kExperiments{
    Experiment{"timings", "Loop timings (Table 1)", &RunTimings, &RunTimingsOnWallClock},
    Experiment{"jitter", "Sampling jitter", &RunJitter, &RunJitterOnWallClock},
    Experiment{"noise", "Noise on the commanded positions", &RunNoise},
    Experiment{"feed_forward", "The feed-forward of the reference generator", &RunFeedForwardStudy},
    Experiment{"tracking", "Position control: velocity and its spectrum", &RunTracking,
               &RunTrackingOnWallClock},
    Experiment{"rate_matching", "Rate matching", &RunRateMatching, &RunRateMatchingOnWallClock},
    Experiment{"lambda", "The correction lambda of the reference generator", &RunLambda},
    Experiment{"losses", "Runs of lost commands", &RunLosses},
    Experiment{"viability", "Legal for ever, whatever is lost", &RunViability},
};

}  // namespace

std::span<const Experiment> Experiments() noexcept {
  return kExperiments;
}

}  // namespace twin::experiment
