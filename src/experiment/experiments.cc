#include "twin/experiment/experiment.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "experiment/studies.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/scenario/scenario.h"

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

std::string_view Name(Verdict verdict) noexcept {
  switch (verdict) {
    case Verdict::kPredicted: return "predicted";
    case Verdict::kNotReproduced: return "not reproduced";
    case Verdict::kCalibrated: return "calibrated";
    case Verdict::kReported: break;
  }
  return "reported";
}

Comparison& Comparison::Paper(double value) {
  paper = value;
  return *this;
}

Comparison& Comparison::Demand(std::string text, bool met) {
  verdict = text.empty() ? Verdict::kReported : met ? Verdict::kPredicted : Verdict::kNotReproduced;
  demand = std::move(text);
  return *this;
}

bool Comparison::is_missed() const noexcept {
  return verdict == Verdict::kNotReproduced && reason.empty();
}

std::optional<double> Comparison::ratio() const noexcept {
  if (!paper || *paper == 0) return std::nullopt;
  return ours / *paper;
}

Comparison& Findings::Add(std::string quantity, std::string unit, double ours) {
  return comparisons.emplace_back(
      Comparison{.quantity = std::move(quantity), .unit = std::move(unit), .ours = ours});
}

Comparison& Findings::Add(std::string quantity, std::string unit, const Spread& spread) {
  Comparison& one = Add(std::move(quantity), std::move(unit), spread.mean);
  one.low = spread.low;
  one.high = spread.high;
  return one;
}

bool Findings::succeeded() const noexcept {
  return failure.empty() && std::ranges::none_of(comparisons, &Comparison::is_missed);
}

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

Calibration ReadCalibration(const std::filesystem::path& scenarios) {
  Calibration calibration;
  std::uint64_t hash = 0xcbf29ce484222325;
  for (std::size_t i = 0; i < kCalibratedLoops.size(); ++i) {
    const CalibratedLoop& calibrated = kCalibratedLoops[i];
    const std::filesystem::path file = scenarios / fmt::format("{}.yaml", calibrated.file);
    const scenario::Scenario loop = scenario::Load(file);
    if (loop.loop != calibrated.kind) {
      throw InputError(fmt::format("{}: its loop must be {}; the file stands for {}", file.string(),
                                   calibrated.file, calibrated.name));
    }
    calibration.yaml[i] = scenario::ToYaml(loop);
    for (const unsigned char c : calibration.yaml[i]) hash = (hash ^ c) * 0x100000001b3;
  }
  calibration.hash = FormatHash(hash);
  return calibration;
}

}  // namespace twin::experiment
