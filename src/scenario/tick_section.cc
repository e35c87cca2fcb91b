#include <fmt/format.h>

#include "scenario/sections.h"

// The sections tick and controller. Their defaults depend on loop and motion, so the reader takes
// them last.
namespace twin::scenario {

using enum Dimension;

namespace {

constexpr Duration kLongestPhase = std::chrono::seconds(10);

/// A path relative to the scenario's folder.
Value Library(Scenario& scenario) {
  std::filesystem::path& library = scenario.controller.library;
  Place& place = scenario.places.library;
  return Converted(library.string(), Text, [&](const std::string& text) {
    library = text.empty()
                  ? std::filesystem::path()
                  : std::filesystem::absolute(scenario.places.folder / text).lexically_normal();
    place.name = library.string();
  });
}

}  // namespace

void DescribeTick(Map& map, Scenario& scenario) {
  using loop::Generator;
  TickSection& tick = scenario.tick;
  map.Add("generator", Choice(tick.generator, kGeneratorNames),
          "How deposits become commands, see ../../src/reference/CHAINS.md; none: as they are.")
      .Then([&scenario, &tick](const YamlNode& node) {
        const control::CommandInterface interface = scenario.motion.interface;
        if (tick.generator != Generator::kRejoining) tick.viability.reset();
        const std::string_view misfit = loop::Misfit(tick.generator, interface);
        if (misfit.empty()) return;
        node.Fail(fmt::format("{}, and motion.interface is {}; say none, or leave it out", misfit,
                              NameOf(kInterfaceNames, interface)));
      });
  map.Add("lambda", Number(tick.lambda, 1e-9, 1), "Correction per cycle of joint and cartesian.");
  map.Add("rate_matching", Bool(tick.rate_matching),
          "Moving average over the cycles of one period of the controller.");
  map.Add("finish_tolerance", Quantity(tick.finish_tolerance, kAngle, 1e-9, 1e-2),
          "How near q_d must come to the last target.");
  const bool is_asynchronous = scenario.loop == loop::LoopKind::kAsynchronous;
  map.Add(
         "period_tolerance", TimeSpan(tick.period_tolerance, Duration::zero(), kCycle),
         "A state that comes so much off 1 ms after the last is not answered; 0: all are; of loop: "
         "asynchronous only.")
      .OmitIf(!is_asynchronous)
      .Then([is_asynchronous](const YamlNode& node) {
        if (is_asynchronous) return;
        node.Fail("only the asynchronous loop has one; leave it out, or say loop: asynchronous");
      });
  map.Add("stall_time",
          TimeSpan(tick.stall_time, std::chrono::milliseconds(1), std::chrono::seconds(10)),
          "Without a new target for so long, and three periods, the controller counts as stalled; "
          "the arm stops, and later rejoins its targets, not along the path between.");
  map.Add(
      "low_pass", Cutoff(tick.low_pass_hz),
      "Cut-off of the client library's low-pass on the command; scales a generator's steps; not "
      "with rejoining.");
  map.Add("limiter", Bool(tick.limiter),
          "The client library's rate limiter on the command; true on torques.");
  const auto lost = [](int& count) { return Integer(count, 0, reference::ViableAxis::kMostLost); };
  map.Add("viability",
          OrWord(
              "off", [&tick] { return !tick.viability; }, [&tick] { tick.viability.reset(); },
              Optional(tick.viability, lost)),
          "Commands lost in a row under which the limits hold at all times; off without rejoining.")
      .Then([&scenario, &tick](const YamlNode& node) {
        if (!tick.viability) return;
        if (scenario.motion.interface != control::CommandInterface::kTorque) return;
        node.Fail(
            "keeps the limits of commanded motions, and motion.interface is torque; say off, or "
            "leave it out");
      });
  map.Add("cost", DelayOf(tick.cost),
          "Time from the end of the state's read to the end of the command's write (d_EXT).");
}

void DescribeController(Map& map, Scenario& scenario) {
  ControllerSection& controller = scenario.controller;
  const bool is_free = scenario.application.has_value();  // to choose its controllers
  const auto require_type = [&map](const YamlNode& /*node*/) { (void)map.MustBeGiven("type"); };
  map.Before([&map, is_free](const YamlNode& /*node*/) {
    for (const char* key : {"library", "type", "parameters", "target_noise"}) {
      if (const auto node = map.Given(key); node && is_free) {
        node->Fail("beside an application, which chooses its controllers itself; leave it out");
      }
    }
  });
  map.Add("library", Library(scenario),
          "A shared library of your own that has the type; `run` executes its code.")
      .OmitIf(is_free || controller.library.empty())
      .Then([&map, &scenario](const YamlNode& node) {
        (void)map.MustBeGiven("type");
        if (scenario.controller.library.empty()) {
          node.Fail("names no file; leave it out, or give a library's path");
        }
        scenario.places.library.where = node.Where();
      });
  map.Add("type", Identifier(controller.type),
          "Which controller, see controllers/README.md; of torques joint_trajectory_effort.")
      .OmitIf(is_free)
      .At(scenario.places.controller);
  map.Add("parameters", Parameters(controller.parameters), "Parameters of the controller.")
      .OmitIf(is_free || controller.parameters.empty())
      .Then(require_type);  // whose parameters they are
  const Dimension dimension = DimensionOf(scenario.motion.interface);
  map.Add("target_noise",
          QuantityIn(controller.target_noise, dimension,
                     {kAngle, kAngularVelocity, kLength, kTorque}, 0, 1),
          "Uniform noise of up to so much on every value that the controller deposits, in the unit "
          "of motion.interface (a pose: m).")
      .OmitIf(is_free);
  map.Add("rate", Quantity(controller.rate_hz, kFrequency, 1, 1000), "Rate of the loop.");
  map.Add("clock_drift", Drift(controller.clock_drift_ppm),
          "How much faster the controller's clock runs than the run's.");
  map.Add("phase", TimeSpan(controller.phase, Duration::zero(), kLongestPhase),
          "Time of the first wake-up.");
  map.Add("wake_delay", DelayOf(controller.wake_delay), "Lateness of each wake-up.");
  map.Add("cost", DelayOf(controller.cost), "Time from wake-up to deposit.");
  map.Add("feed_forward", Choice(controller.feed_forward, kFeedForwardNames),
          "Elapsed time that forms the velocity at the deposit.");
}

}  // namespace twin::scenario
