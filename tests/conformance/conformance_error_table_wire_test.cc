// The error table over the wire: this project's client against this project's server, in lockstep.
// Each row is run in process and over the wire; what states show from the first command on must be
// the same, and the error must come in the same cycle.
//
// Three things are otherwise over the wire, and these rows are run otherwise:
//   - A server in lockstep waits for a command that does not come: silence loses none. Rows that
//     need commands to be lost (kLostByTheLink) have the served robot's link lose them, by script.
//   - Time before a motion's first command runs by the wall's clock, or stands still: a row about
//     it (kSilent) is run without standing still, and without its neighbour, which would have to
//     hit one cycle of a thousand by the wall's clock.
//   - Between the state that shows a motion and its first command a served robot stands still, and
//     one in process runs a cycle: what comes at a time of the plant's (pushes) comes one cycle
//     of the motion later, and a body of MuJoCo's, which settles meanwhile, measures otherwise in
//     the last digits. On the ideal plant every bit of every state is compared, on MuJoCo's the
//     cycle.
// Which joint, value and limit an error is about is not told over the wire at all.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "conformance/error_table.h"
#include "conformance/motion_course.h"
#include "contract/backend_harness.h"
#include "contract/served_harness.h"
#include "support/undisturbed.h"
#include "twin/faults/loss_model.h"

namespace twin::test::conformance_error_table_wire_test {
namespace {

/// How a row gets over the wire.
enum class Way { kAsItIs, kLostByTheLink, kSilent };

Way WayOf(const ErrorRow& row) {
  if (row.error != RobotError::kCommunicationConstraintsViolation) return Way::kAsItIs;
  return row.axis == 0 ? Way::kSilent : Way::kLostByTheLink;
}

/// What a stream showed of its motion, and what came after.
struct Course : MotionCourse {
  std::string refusal;
  std::optional<backend::MotionEnd> end;
  RobotErrors errors;     ///< as the backend tells them
  bool recovers = false;  ///< tried of a motion that is over, unless the row's cause persists
  bool is_clear = false;  ///< recovery has left no error
};

using MakeHarness = std::function<std::unique_ptr<BackendHarness>(const robot::RobotConfig& robot)>;

Course Run(const ErrorRow& row, const MakeHarness& make, double x) {
  robot::RobotConfig robot = HarnessRobot(row.plant);
  if (row.prepare) row.prepare(robot, x);
  std::vector<RobotState> all;
  Rig rig(std::make_unique<NotingHarness>(make(robot), all), robot, false);
  Trial trial(rig, row.modes);
  row.stream(trial, x);
  Course course;
  static_cast<MotionCourse&>(course) = CourseOf(all);
  course.refusal = rig.refusal();
  if (!course.is_over) return course;
  const backend::Description told = rig.Describe();
  course.end = told.last_end;
  course.errors = told.last_errors;
  course.recovers = !row.persists && rig.RecoverToIdle();
  course.is_clear = rig.state().errors.none();
  return course;
}

Course RunInProcess(const ErrorRow& row, double x) {
  const std::vector<HarnessCase> harnesses = Harnesses();
  const auto mine = std::ranges::find(harnesses, row.plant, &HarnessCase::plant_kind);
  return Run(row, mine->make, x);
}

Course RunOverTheWire(const ErrorRow& row, double x, bool freeze) {
  const auto make = [freeze](const robot::RobotConfig& robot) {
    return MakeServedHarness(robot, backend::RobotTime::kStates, freeze);
  };
  return Run(row, make, x);
}

/// The row where the link loses what a client over the wire cannot leave out.
ErrorRow LostByTheLink(ErrorRow row) {
  // INT's cycles: one when it is switched on, one when the motion is granted. The command that
  // answers the second's state is the motion's first.
  constexpr std::uint64_t kFirst = 2;
  row.prepare = [](robot::RobotConfig& robot, double x) {
    const faults::ScriptedLoss::Run lost{kFirst + 1, static_cast<std::uint64_t>(x)};
    robot.link.command.loss = faults::LossModel(faults::ScriptedLoss{{lost}});
  };
  row.stream = [](Trial& trial, double x) {
    const auto path = [](const RobotState& start) { return JointPath(start, 1); };
    if (trial.Start(path, false)) trial.Stay(static_cast<int>(x) + 1);
  };
  return row;
}

/// @param later  cycles.
void ExpectSame(const Course& here, const Course& there, robot::PlantKind plant,
                std::size_t later) {
  ASSERT_EQ(there.states.size(), here.states.size() + later) << there.refusal;
  if (plant != robot::PlantKind::kIdeal) return;
  EXPECT_EQ(FindDifference(here, there), std::nullopt);
}

struct Case {
  std::string name;
  ErrorRow row;
};

void PrintTo(const Case& test_case, std::ostream* out) {
  *out << test_case.row.cause << " / " << test_case.row.neighbour;
}

std::vector<Case> CasesOf(bool silent) {
  std::vector<Case> cases;
  const std::vector<ErrorRow> table = ErrorTable();
  for (std::size_t i = 0; i < table.size(); ++i) {
    if ((WayOf(table[i]) == Way::kSilent) == silent) {
      cases.push_back({NameOf(table[i], i), table[i]});
    }
  }
  return cases;
}

void ExpectAborted(const ErrorRow& row, const Course& there) {
  RobotErrors expected = row.beside;
  expected.set(static_cast<std::size_t>(row.error));
  ASSERT_TRUE(there.is_over) << there.refusal;
  const RobotState& last = there.states.back();
  EXPECT_EQ(last.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(last.reflex_reason, expected) << FormatErrors(last.reflex_reason);
  EXPECT_EQ(there.errors, expected) << FormatErrors(there.errors);
  EXPECT_EQ(there.end, backend::MotionEnd::kAborted);
  EXPECT_EQ(there.recovers, !row.persists) << there.refusal;
  EXPECT_EQ(there.is_clear, !row.persists);
}

class WireErrorTableTest : public ::testing::TestWithParam<Case> {};

TEST_P(WireErrorTableTest, TheSameErrorComesInTheSameCycle) {
  const ErrorRow& row = GetParam().row;
  const ErrorRow sent = WayOf(row) == Way::kLostByTheLink ? LostByTheLink(row) : row;
  robot::RobotConfig robot = HarnessRobot(row.plant);
  if (row.prepare) row.prepare(robot, row.outside);
  const bool is_pushed = !robot.plant.perturbations.empty();

  const Course outside = RunOverTheWire(sent, row.outside, true);
  ExpectAborted(row, outside);
  ExpectSame(RunInProcess(row, row.outside), outside, row.plant, is_pushed ? 1 : 0);

  const Course inside = RunOverTheWire(sent, row.inside, true);
  EXPECT_FALSE(inside.is_over) << FormatErrors(inside.states.back().reflex_reason);
  ExpectSame(RunInProcess(row, row.inside), inside, row.plant, 0);
}

INSTANTIATE_TEST_SUITE_P(Rows, WireErrorTableTest, ::testing::ValuesIn(CasesOf(false)),
                         [](const auto& info) { return info.param.name; });

class WireSilenceTest : public ::testing::TestWithParam<Case> {};

TEST_P(WireSilenceTest, TheErrorComesInTheSameCycle) {
  const ErrorRow& row = GetParam().row;
  const Course here = RunInProcess(row, row.outside);
  Course there;
  Undisturbed(
      [&] {
        there = RunOverTheWire(row, row.outside, false);
        EXPECT_FALSE(there.missed_begin || there.missed_end);
        ExpectAborted(row, there);
        const auto cycles = [](const Course& course) {
          return course.states.back().message_id - course.states.front().message_id;
        };
        EXPECT_EQ(cycles(there), cycles(here));
      },
      // This machine may hold the client up where it matters.
      [&] { return there.missed_begin || there.missed_end ? kAnyLoss : kNothingExcuses; },
      ByWitness(0));
}

INSTANTIATE_TEST_SUITE_P(Rows, WireSilenceTest, ::testing::ValuesIn(CasesOf(true)),
                         [](const auto& info) { return info.param.name; });

TEST(WireErrorTableCoverageTest, LeavesOutNoRow) {
  EXPECT_EQ(CasesOf(false).size() + CasesOf(true).size(), ErrorTable().size());
  EXPECT_EQ(CasesOf(true).size(), 4u);
  const auto ways = CasesOf(false);
  EXPECT_EQ(std::ranges::count_if(
                ways, [](const Case& one) { return WayOf(one.row) == Way::kLostByTheLink; }),
            4);
}

}  // namespace
}  // namespace twin::test::conformance_error_table_wire_test
