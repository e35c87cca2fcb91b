#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "scenario/schema.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

// The keys of a scenario's sections. A Describe() adds them to a map and binds them to a section.
namespace twin::scenario {

/// The latest time that a scenario may name.
inline constexpr Duration kDay = std::chrono::hours(24);
/// Largest angle, rad.
inline constexpr double kTurn = 2 * std::numbers::pi;
/// Largest distance, m: beyond any reach.
inline constexpr double kFarthest = 10;

[[nodiscard]] Value DelayOf(Delay& delay);
[[nodiscard]] Value LossOf(Loss& loss);
/// Adds the four keys of one direction, with its name as prefix: "state_delay".
void DescribeDirection(Map& map, const std::string& name, DirectionSection& direction);
/// The cut-off frequency of a low-pass, or off (kLowPassOff).
[[nodiscard]] Value Cutoff(double& cutoff_hz);
/// The drift of a clock against the run's, ppm.
[[nodiscard]] Value Drift(double& ppm);
[[nodiscard]] Value LoadOf(setting::Load& load);
/// Adds the shares of the limits that set the pace of a motion. @param least  lower bound of each.
void DescribeShares(Map& map, reference::Timing& timing, double least);

/// The time of an event of a list. @param end  of an event; none may come before that of the event
/// above it. @param wrong  the message otherwise.
template <typename Event, typename End>
[[nodiscard]] Value TimeInOrder(std::vector<Event>& events, Event& event, End end,
                                const char* wrong) {
  return Validated(TimeSpan(event.at, Duration::zero(), kDay), [&events, &event, end, wrong] {
    const bool is_first = &event == events.data();
    if (!is_first && event.at < end(*(&event - 1))) throw InputError(wrong);
  });
}

void Describe(Map& map, BaseSection& base, Place& place);
void Describe(Map& map, CameraSection& camera);
void Describe(Map& map, FramePose& pose);
void Describe(Map& map, LinkSection& link);
void Describe(Map& map, ObjectSection& object);
void Describe(Map& map, OnboardSection& onboard);
void Describe(Map& map, OperatorSection& section, Place& place);
void Describe(Map& map, plant::Perturbation& perturbation);
void Describe(Map& map, PlantSection& plant);
void Describe(Map& map, RenderSection& render);
void DescribeRobot(Map& map, Scenario& scenario);
void DescribeTick(Map& map, Scenario& scenario);
void DescribeController(Map& map, Scenario& scenario);
void DescribeMotion(Map& map, Scenario& scenario);
[[nodiscard]] Value LimitsOf(model::LabLimits& limits);
[[nodiscard]] Value MaxDeviationOf(Scenario& scenario);
[[nodiscard]] Value Panel(std::vector<robot::PanelEvent>& panel);
[[nodiscard]] Value Hand(std::vector<HandEvent>& hand);
/// Reads the profile that `robot` names over the defaults of plant, link and load, before the
/// scenario's own keys. @throws InputError naming the profile's file and line, or the scenario's.
void ReadProfile(const YamlNode& robot, Scenario& scenario);
/// All keys of a scenario.
void Describe(Map& map, Scenario& scenario);
/// The scenario of a whole document. @param stands  it needs nothing that moves the arm, as of
/// LoadServed().
[[nodiscard]] Scenario ReadScenario(const YamlNode& root, const std::filesystem::path& folder,
                                    bool stands);
/// The key `robots` for the JSON Schema; a reader of one robot's scenario refuses it.
[[nodiscard]] Value Robots();

}  // namespace twin::scenario
