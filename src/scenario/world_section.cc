#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <type_traits>

#include "scenario/sections.h"
#include "twin/core/error.h"

// The sections objects, perturbations, panel and hand.
namespace twin::scenario {

using enum Dimension;

namespace {

constexpr double kHeaviest = 100;  // kg
constexpr double kRoughest = 10;
constexpr double kMostForce = 1e4;     // N or Nm
constexpr double kFarthestPush = 100;  // m
constexpr double kAnyHand = 1e6;       // FindBadValue() has the hand's own ranges
constexpr double kUnit = 1000;         // of a pump's set point, Pa

Value PointOf(Vector3& point) {
  return Vector(point, kLength, -kFarthestPush, kFarthestPush);
}

/// What pushes and springs have in common.
template <typename Kind>
void AddWhereAndWhen(Map& map, Kind& what) {
  map.Require("body", Text(what.body),
              "A body of the compiled model: panda_hand, one of the scene's.");
  map.Require("begin", TimeSpan(what.begin, Duration::zero(), kDay),
              "Time since the run began, or since the motion that `motion` names.");
  map.Add("motion",
          Optional(what.motion, [](std::uint32_t& n) { return Integer(n, 1, 1'000'000); }),
          "Which motion `begin` counts from; absent: from the run's beginning.");
  map.Add("duration", TimeSpan(what.duration, Duration::zero(), kDay),
          "Duration, rise and fall included.");
}

Value Opening(double& opening) {
  return Quantity(opening, kLength, -kAnyHand, kAnyHand);
}

void AddWidthAndSpeed(Map& map, double& width, double& speed, std::string_view width_meaning) {
  map.Require("width", Opening(width), width_meaning);
  map.Require("speed", Quantity(speed, kVelocity, -kAnyHand, kAnyHand),
              "Speed of the opening; the hand does at most 0.1 m/s.");
}

template <typename T>
Value CommandOf(HandCommand& command) {
  // The largest opening is known to a hand that was homed; the one it is built for counts here.
  // That the mounted hand has the command is for Scenario::Validate().
  constexpr bool kSucks = std::is_same_v<T, hand::Vacuum> || std::is_same_v<T, hand::DropOff>;
  const auto validate = [&command] {
    const auto device = kSucks ? HandDevice::kCobotPump : HandDevice::kFrankaHand;
    if (const auto bad = FindBadValue(command, 0, device)) throw InputError(Describe(*bad));
  };
  return Alternative<T>(command, [validate](T& one) {
    if constexpr (std::is_empty_v<T>)
      return Validated(NoValues(), validate);
    else
      return Validated(SectionOf(one), validate);
  });
}

const std::array<Spelling<PanelAction>, kPanelActions>& PanelActionNames() {
  static const auto names = [] {
    std::array<Spelling<PanelAction>, kPanelActions> all;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto action = static_cast<PanelAction>(i);
      all[i] = {Name(action), action};
    }
    return all;
  }();
  return names;
}

}  // namespace

static void Describe(Map& map, ObjectSpread& spread) {
  map.Add("size", Vector(spread.size, kLength, 0, kFarthest),
          "Spread of the size; x spreads a diameter.");
  map.Add("position", Vector(spread.position, kLength, 0, kFarthest), "Spread of the position.");
  map.Add("rpy", Vector(spread.rpy, kAngle, 0, kTurn), "Spread of the turn.");
  map.Add("friction", Number(spread.friction, 0, kRoughest), "Spread of the friction.");
  map.Add("mass", Quantity(spread.mass, kMass, 0, kHeaviest), "Spread of the mass.")
      .OmitIf(spread.mass == 0);
}

void Describe(Map& map, ObjectSection& object) {
  map.Where(object.where);
  map.Require("name", Text(object.name), "Letters, digits and '_'; no other body has it.");
  map.Require("shape", Choice(object.shape, kObjectShapeNames),
              "A cylinder stands along its z axis.");
  map.Require("size", Vector(object.size, kLength, 0, kFarthest),
              "Outer dimensions; x and y of a cylinder and all of a sphere are its diameter.");
  const auto mass = [](double& m) { return Quantity(m, kMass, 0, kHeaviest); };
  map.Add("mass", Optional(object.mass, mass), "Absent: the object is fixed to the world.");
  map.Add("on", Text(object.on),
          "An object listed before, on whose upper face it stands, or ground; absent: nothing.")
      .OmitIf(object.on.empty());
  const auto colour = [](std::array<double, 3>& rgb) {
    const auto number = [](double& one) { return Number(one, 0, 1); };
    return Array(rgb, number, "takes three numbers: red, green, blue");
  };
  map.Add("colour", Optional(object.colour, colour), "Red, green, blue.");
  map.Add("friction", Number(object.friction, 0, kRoughest),
          "Sliding friction; against the fingers their rubber's counts instead.");
  map.Add("position", Vector(object.pose.position, kLength, -kFarthest, kFarthest),
          "With `on`: from the middle of that face, z = 0 stands on it; else the object's centre.");
  map.Add("rpy", Vector(object.pose.rpy, kAngle, -kTurn, kTurn),
          "Roll, pitch, yaw about fixed axes.");
  map.Add("spread", SectionOf(object.spread),
          "Half widths of ranges about these values, from which the seed draws.");
}

static void Describe(Map& map, plant::Push& push) {
  map.Before([&map](const YamlNode& node) {
    if (!map.Given("force") && !map.Given("torque")) node.Fail("give a force, a torque or both");
  });
  AddWhereAndWhen(map, push);
  map.Add("rise", TimeSpan(push.rise, Duration::zero(), kDay),
          "Time to rise, and to fall; at most half of the duration.");
  map.Add("force", Vector(push.force, kForce, -kMostForce, kMostForce), "Force at the point.");
  map.Add("torque", Vector(push.torque, kTorque, -kMostForce, kMostForce),
          "Torque beside the force's own moment.");
  map.Add("point", PointOf(push.point), "Where the force acts, in the body's frame.");
  map.Add("frame", Choice(push.frame, kForceFrameNames), "Axes of force and torque.");
}

static void Describe(Map& map, plant::HandSpring& spring) {
  AddWhereAndWhen(map, spring);
  map.Add("point", PointOf(spring.point), "Point that the hand holds, in the body's frame.");
  map.Add("from", Optional(spring.from, PointOf),
          "Where the hand begins, in the world; absent: where the point is then.");
  map.Add("by", PointOf(spring.by), "How far the hand goes.");
  map.Add("stiffness", Quantity(spring.stiffness, kLinearStiffness, 0, 2e4),
          "Stiffness of the hold.");
  map.Add("damping", Quantity(spring.damping, kLinearDamping, 0, 500), "Damping of the hold.");
  map.Add("largest_force", Quantity(spring.largest_force, kForce, 0, kMostForce),
          "The force saturates here.");
}

void Describe(Map& map, plant::Perturbation& perturbation) {
  const auto add = [&]<typename T>(const char* key, T /*kind*/, std::string_view meaning) {
    const auto validate = [&perturbation] { plant::Validate(perturbation); };
    const auto bind = [validate](T& one) { return Validated(SectionOf(one), validate); };
    map.Add(key, Alternative<T>(perturbation, bind), meaning);
  };
  add("push", plant::Push{}, "A force that rises, holds and falls, by minimum jerk.");
  add("spring", plant::HandSpring{},
      "A hand that holds a point and leads it along a line, by minimum jerk.");
  map.ExactlyOne();
}

Value Panel(std::vector<robot::PanelEvent>& panel) {
  const auto event = [&panel](robot::PanelEvent& one) {
    return Section([&panel, &one](Map& map) {
      map.Require("at",
                  TimeInOrder(panel, one, std::mem_fn(&robot::PanelEvent::at),
                              "comes before the event above it; give them in order of time"),
                  "Time of the robot's clock.");
      map.Require("action", Choice(one.action, PanelActionNames()), "Action at the robot.");
    });
  };
  return List(panel, event, Style::kBlock);
}

static void Describe(Map& map, hand::Move& move) {
  AddWidthAndSpeed(map, move.width, move.speed, "Opening to move to.");
}

static void Describe(Map& map, hand::Grasp& grasp) {
  AddWidthAndSpeed(map, grasp.width, grasp.speed, "Width of the object.");
  map.Require("force", Quantity(grasp.force, kForce, -kAnyHand, kAnyHand),
              "Force of each finger, above 0, at most 140 N; held until the next command.");
  map.Add("epsilon_inner", Opening(grasp.epsilon_inner),
          "A grasp that ends narrower than width by more is unsuccessful.");
  map.Add("epsilon_outer", Opening(grasp.epsilon_outer),
          "A grasp that ends wider than width by more is unsuccessful.");
}

static Value TimeoutOf(std::int64_t& timeout_ms) {
  using std::chrono::milliseconds;
  return Converted(
      Duration(milliseconds(timeout_ms)),
      [](Duration& span) { return TimeSpan(span, Duration::zero(), kDay); },
      [&timeout_ms](Duration span) {
        timeout_ms = std::chrono::round<milliseconds>(span).count();
      });
}

static void Describe(Map& map, hand::Vacuum& vacuum) {
  const auto pressure = [](double& p) { return Quantity(p, kPressure, kUnit, 255 * kUnit); };
  const auto set = [&vacuum](double p) {
    vacuum.vacuum = static_cast<std::uint8_t>(std::lround(p / kUnit));
  };
  map.Require("vacuum", Converted(kUnit * vacuum.vacuum, pressure, set),
              "Set point, to the nearest 10 mbar; the pump reaches 750 mbar.");
  map.Add("profile", Integer(vacuum.profile, 0, 3), "Of the pump's settings; all are the same.");
  map.Require("timeout", TimeoutOf(vacuum.timeout_ms),
              "Time to hold an object; else it is unsuccessful, and sucks no more.");
}

static void Describe(Map& map, hand::DropOff& drop) {
  map.Require("timeout", TimeoutOf(drop.timeout_ms), "Time to be rid of the vacuum.");
}

Value Hand(std::vector<HandEvent>& hand) {
  const auto event = [&hand](HandEvent& one) {
    return Section([&hand, &one](Map& map) {
      map.Require("at",
                  TimeInOrder(hand, one, std::mem_fn(&HandEvent::at),
                              "comes before the command above it; give them in order of time"),
                  "Time since the run began.");
      map.Add("homing", CommandOf<hand::Homing>(one.command),
              "Moves the fingers to both ends; the hand learns its largest opening.");
      map.Add("move", CommandOf<hand::Move>(one.command), "Moves the fingers to an opening.");
      map.Add("grasp", CommandOf<hand::Grasp>(one.command), "Grasps an object and holds it.");
      map.Add("vacuum", CommandOf<hand::Vacuum>(one.command),
              "Of a cobot pump: sucks an object on and holds it.");
      map.Add("drop_off", CommandOf<hand::DropOff>(one.command),
              "Of a cobot pump: lets the object go.");
      map.Add("stop", CommandOf<hand::Stop>(one.command),
              "Ends what runs and releases the force, or the vacuum.");
      map.ExactlyOne("at");
    });
  };
  return List(hand, event, Style::kBlock);
}

}  // namespace twin::scenario
