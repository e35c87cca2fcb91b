#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "scenario/sections.h"
#include "twin/reference/trajectory.h"

// The sections motion and max_deviation.
namespace twin::scenario {

using enum Dimension;

namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr MaxDeviation kOff{kUnlimited, kUnlimited, kUnlimited};

/// What the end effector may do is more than most configurations of the arm can: so that joints
/// stay well inside their own limits, and bear two clocks that drift.
reference::Timing GentlePoses() {
  return {.duration = {}, .velocity_scale = 0.1, .acceleration_scale = 0.03, .jerk_scale = 0.01};
}

Value At(std::optional<Duration>& at) {
  return Optional(at, [](Duration& time) { return TimeSpan(time, Duration::zero(), kDay); });
}

void AddDuration(Map& map, reference::Timing& timing, std::string_view meaning) {
  map.Add("duration",
          Optional(timing.duration, [](Duration& all) { return TimeSpan(all, Duration(1), kDay); }),
          meaning);
}

/// {q: [7 numbers], at: 0 s, stop: true}. @param unit  factor to rad.
Value WaypointOf(reference::Waypoint& point, const std::shared_ptr<double>& unit) {
  return Section([&point, unit](Map& map) {
    map.Where(point.where);
    map.Require("q", JointNumbers(point.q, unit), "The joints' positions.");
    map.Add("at", At(point.at), "Since the motion began; of all points or of none.");
    map.Add("stop", Bool(point.stop), "Whether the arm comes to rest here.").OmitIf(!point.stop);
  });
}

void DescribeTrajectory(Map& map, MotionSection& motion) {
  const auto unit = std::make_shared<double>(1);
  map.Require("unit", Unit(*unit, kAngle), "Unit of all q.");
  AddDuration(map, motion.timing,
              "Total time; absent: as fast as the shares of the limits allow, of the joints' and, "
              "with interface cartesian_pose, of the end effector's.");
  DescribeShares(map, motion.timing, 1e-6);
  map.Require("waypoints",
              List(
                  motion.waypoints, [unit](reference::Waypoint& p) { return WaypointOf(p, unit); },
                  Style::kBlock),
              "Points that the arm passes through by a spline.");
}

/// The name of a file beside the scenario, or the points in place.
Value TrajectoryOf(MotionSection& motion, const std::filesystem::path& folder) {
  const Value in_place =
      Section([&motion](Map& map) { DescribeTrajectory(map, motion); }, Style::kBlock);
  const auto read_file = [&motion, folder, in_place](const YamlNode& node) {
    const std::filesystem::path file = folder / node.Text();
    if (file.extension() == ".csv") {
      motion.waypoints = reference::ReadWaypointsCsv(file);
    } else if (file.extension() == ".yaml") {
      in_place.read(YamlNode::ParseFile(file.string()));
    } else {
      node.Fail(fmt::format("\"{}\" is no trajectory file; its name must end in .yaml or .csv",
                            node.Text()));
    }
  };
  return Either(Word("a .yaml or .csv file beside the scenario", R"(\.(yaml|csv)$)", read_file),
                in_place, [] { return false; });
}

/// Adds an absolute vector and its relative alternative.
void AddEither(Map& map, const char* absolute, std::optional<Vector3>& value, const char* relative,
               Vector3& step, Dimension dimension, double most) {
  map.Add(absolute, Optional(value, [=](Vector3& v) { return Vector(v, dimension, -most, most); }),
          "Absolute, in the base.");
  map.Add(relative, Vector(step, dimension, -most, most),
          "Against the pose before, along or about the base's axes.")
      .OmitIf(value.has_value())
      .Then([&map, absolute](const YamlNode& node) {
        if (!map.Given(absolute)) return;
        node.Fail(fmt::format("beside {}; give one of the two", absolute));
      });
}

}  // namespace

static void Describe(Map& map, PoseStep& step) {
  map.Where(step.where);
  AddEither(map, "position", step.position, "by", step.by, kLength, kFarthest);
  AddEither(map, "rpy", step.rpy, "turn", step.turn, kAngle, kTurn);
  map.Add("at", At(step.at), "Since the motion began; of all poses or of none.");
}

namespace {

void DescribePoses(Map& map, MotionSection& motion) {
  map.Before([&motion](const YamlNode& /*node*/) { motion.timing = GentlePoses(); });
  const JointVector start = motion.waypoints.empty() ? JointVector{} : motion.waypoints.front().q;
  map.Require("start",
              Converted(
                  start, [](JointVector& q) { return Joints(q, kAngle); },
                  [&motion](const JointVector& q) { motion.waypoints = {{.q = q}}; }),
              "Where the arm begins; its pose is the first one.")
      .Then([&motion](const YamlNode& node) { motion.waypoints.front().where = node.Where(); });
  AddDuration(map, motion.timing, "Total time; absent: as fast as the shares of the limits allow.");
  DescribeShares(map, motion.timing, 1e-6);
  map.Require("waypoints", ListOf(motion.poses), "Poses of the end effector, at rest in each.")
      .Then([&map, &motion](const YamlNode& /*node*/) {
        if (!motion.poses.empty()) return;
        map.node().Fail("has no waypoints; give at least one pose to go to");
      });
}

Value PosesOf(MotionSection& motion) {
  Value poses = Section([&motion](Map& map) { DescribePoses(map, motion); }, Style::kBlock);
  poses.schema = [](Json& schema, Json& definitions) {
    MotionSection gentle;
    gentle.timing = GentlePoses();
    Map map;
    DescribePoses(map, gentle);
    map.Schema(schema, definitions);
  };
  return poses;
}

/// A pose with all its keys required.
Value PoseOf(FramePose& pose) {
  return Section([&pose](Map& map) {
    Describe(map, pose);
    map.RequireAll();
  });
}

/// random, {q: {unit, values}} or {pose: {position, rpy}}.
Value GoalOf(PlanSection& plan) {
  const auto describe = [&goal = plan.goal](Map& map) {
    map.Add("q", Alternative<JointVector>(goal, [](JointVector& q) { return Joints(q, kAngle); }),
            "The joints' positions.");
    map.Add("pose", Alternative<FramePose>(goal, PoseOf), "Pose of the end effector in the base.");
    map.ExactlyOne();
  };
  const auto read_random = [&goal = plan.goal](const YamlNode& node) {
    if (node.Text() != "random") {
      node.Fail("a goal is random, {q: {unit: rad, values: [...]}} or {pose: {position, rpy}}");
    }
    goal = RandomGoal{};
  };
  Value random = Word("random", "^random$", read_random);
  random.write = [](int /*indent*/) { return std::string("random"); };
  return Either(random, Section(describe),
                [&goal = plan.goal] { return std::holds_alternative<RandomGoal>(goal); });
}

void DescribePlan(Map& map, PlanSection& plan, reference::Timing& timing) {
  map.Where(plan.where);
  map.Require("goal", GoalOf(plan), "Where to: somewhere free, drawn by the seed, or this.");
  map.Add("seed", Optional(plan.seed, Seed), "Seed of goal and search; absent: the scenario's.");
  map.Add("budget", Integer(plan.budget, 1, 1'000'000'000'000),
          "Collision checks after which the search ends; the same on any machine.");
  map.Add("clearance", Quantity(plan.clearance, kLength, 1e-3, 0.1),
          "Distance kept from everything; what the controller lags behind comes off it.");
  map.Add("stretch", Number(plan.stretch, 1, 1000), "Factor on the planned duration.");
  DescribeShares(map, timing, 1e-3);
}

Value Limit(double& limit, Dimension dimension) {
  return OrWord(
      "off", [&limit] { return limit == kUnlimited; }, [&limit] { limit = kUnlimited; },
      Quantity(limit, dimension, 1e-9, 10));
}

void AddLimit(Map& map, const char* key, std::optional<double>& limit, Dimension dimension,
              std::string_view meaning) {
  map.Add(key, Optional(limit, [dimension](double& of) { return Limit(of, dimension); }), meaning);
}

}  // namespace

void DescribeShares(Map& map, reference::Timing& timing, double least) {
  map.Add("velocity_scale", Number(timing.velocity_scale, least, 1),
          "Share of the velocity limits.");
  map.Add("acceleration_scale", Number(timing.acceleration_scale, least, 1),
          "Share of the acceleration limits.");
  map.Add("jerk_scale", Number(timing.jerk_scale, least, 1), "Share of the jerk limits.");
}

void DescribeMotion(Map& map, Scenario& scenario) {
  MotionSection& motion = scenario.motion;
  const bool is_torque = motion.interface == control::CommandInterface::kTorque;
  map.Before([&map](const YamlNode& /*node*/) {
    const auto poses = map.Given("poses");
    const auto plan = map.Given("plan");
    for (const auto& either : {poses, plan}) {
      if (either && map.Given("trajectory")) {
        either->Fail("beside motion.trajectory; a motion has one of the two");
      }
    }
    if (plan && poses) plan->Fail("beside motion.poses; a motion has one of the two");
    if (!plan && !poses) (void)map.MustBeGiven("trajectory");
  });
  map.DescribeOneOf({"trajectory", "poses", "plan"});
  map.Add("interface", Choice(motion.interface, kInterfaceNames), "What is commanded.");
  map.Add("controller", Choice(motion.controller, kControllerNames),
          "The robot's own controller; none on the torque interface.")
      .OmitIf(is_torque)
      .Then([&motion](const YamlNode& node) {
        if (motion.interface != control::CommandInterface::kTorque) return;
        node.Fail("on the torque interface the commanded torque takes its place; leave it out");
      });
  map.Add("trajectory", TrajectoryOf(motion, scenario.places.folder), "A path through joint space.")
      .OmitIf(motion.plan || !motion.poses.empty());
  map.Add("poses", PosesOf(motion), "Lines and turns of the end effector.")
      .OmitIf(motion.poses.empty());
  const auto plan = [&motion](PlanSection& of) {
    return Section([&motion, &of](Map& inside) { DescribePlan(inside, of, motion.timing); },
                   Style::kBlock);
  };
  map.Add("plan", Optional(motion.plan, plan), "A path from robot.q_start around the scene.");
  map.Add("touches", Text(motion.touches),
          "Why the arm may touch something on its way; empty: validate and hardware refuse that.")
      .OmitIf(motion.touches.empty());
}

Value MaxDeviationOf(Scenario& scenario) {
  MaxDeviation& max = scenario.max_deviation;
  const auto describe = [&max](Map& map) {
    AddLimit(map, "joints", max.joints, kAngle, "Limit for every joint.");
    AddLimit(map, "position", max.position, kLength,
             "Limit for the end effector, where poses are commanded.");
    AddLimit(map, "angle", max.angle, kAngle, "Limit for its orientation.");
  };
  Value value = OrWord(
      "off", [&max] { return max == kOff; }, [&max] { max = kOff; }, Section(describe));
  value.read = [&scenario, &max, read = value.read](const YamlNode& node) {
    if (node.IsScalar() && node.Text() != "off") node.Fail("is neither a map with limits nor off");
    read(node);
    if (node.IsScalar() || scenario.application) return;
    const control::CommandInterface interface = scenario.motion.interface;
    const bool of_poses = interface == control::CommandInterface::kCartesianPose;
    if (of_poses ? !max.joints.has_value() : !max.position && !max.angle) return;
    node.Fail(fmt::format("motion.interface is {}, whose motions are judged by {}",
                          NameOf(kInterfaceNames, interface),
                          of_poses ? "position and angle" : "joints"));
  };
  return value;
}

}  // namespace twin::scenario
