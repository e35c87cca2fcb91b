#include "twin/control/controller_library.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "support/temporary_folder.h"
#include "twin/control/parameters.h"
#include "twin/core/error.h"

namespace twin::control::control_controller_library_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 1s

const JointVector kReady{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};

reference::Trajectory Standing() {
  return reference::Trajectory({{.q = kReady, .at = 0s}, {.q = kReady, .at = 1s}}, {},
                               test::PandaLimits());
}

std::filesystem::path Library(const std::string& name) {
  return std::filesystem::path(TEST_LIBRARIES) / ("test_controllers_" + name + ".so");
}

class ControllerLibraryTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<Controller> Load(const std::filesystem::path& library,
                                                 std::string_view type = "follower") const {
    return LoadController(library, type, {.trajectory = trajectory_});
  }
  /// What is said when it cannot be loaded.
  [[nodiscard]] std::string Complaint(const std::filesystem::path& library,
                                      std::string_view type = "follower") const {
    try {
      (void)Load(library, type);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("controller library " + library.string()));
      return error.what();
    }
    return "(loaded)";
  }

  const reference::Trajectory trajectory_ = Standing();
};

TEST_F(ControllerLibraryTest, MakesAControllerThatRunsWithoutAllocating) {
  const auto controller = Load(Library("good"));
  EXPECT_EQ(controller->command_interface(), CommandInterface::kJointPosition);
  const RobotState state;
  ControllerOutput output;
  controller->Activate(state, Time());
  const test::RealtimeGuard guard;
  for (int i = 0; i <= 1000; ++i) controller->Update(state, Time(kCycle * i), output);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_EQ(output.target.joint.q, kReady);
  EXPECT_TRUE(output.finished);
  controller->Deactivate();
}

TEST_F(ControllerLibraryTest, GivesParametersAcrossTheBorder) {
  const auto controller = Load(Library("good"));
  const Parameters good{{.key = "patience", .values = {"10 ms"}}};
  ParameterReader reader(good);
  controller->Configure(reader);
  EXPECT_NO_THROW(reader.RefuseUnread());
  ControllerOutput output;
  controller->Activate(RobotState(), Time());
  controller->Update(RobotState(), Time(0s), output);
  EXPECT_FALSE(output.failed);
  controller->Update(RobotState(), Time(10ms), output);
  EXPECT_TRUE(output.failed);
  EXPECT_EQ(controller->Explain(), "the follower lost its patience");

  const Parameters bad{{.key = "patience", .values = {"10 m"}, .where = "s.yaml:7"}};
  ParameterReader bad_reader(bad);
  try {
    controller->Configure(bad_reader);
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("s.yaml:7: controller.parameters.patience: "));
  }
}

TEST_F(ControllerLibraryTest, NamesWhatIsWrongWithTheFile) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(Complaint(folder / "none.so"), HasSubstr("there is no such file"));
  EXPECT_THAT(Complaint(folder.path()), HasSubstr("there is no such file"));
  std::ofstream(folder / "text.so") << "not a library\n";
  EXPECT_THAT(Complaint(folder / "text.so"), HasSubstr("cannot be loaded"));
  std::ofstream(folder / "empty.so") << "";
  EXPECT_THAT(Complaint(folder / "empty.so"), HasSubstr("cannot be loaded"));
}

TEST_F(ControllerLibraryTest, NamesTheSymbolThatIsMissing) {
  EXPECT_THAT(Complaint(Library("unresolved")),
              AllOf(HasSubstr("cannot be loaded"), HasSubstr("this_function_is_nowhere")));
}

TEST_F(ControllerLibraryTest, NamesWhatIsWrongWithTheEntry) {
  EXPECT_THAT(Complaint(Library("no_entry")),
              AllOf(HasSubstr("panda_twin_controllers"), HasSubstr("TWIN_CONTROLLERS")));
  EXPECT_THAT(Complaint(Library("null_entry")), HasSubstr("returns null"));
  EXPECT_THAT(Complaint(Library("throwing_entry")), HasSubstr("the entry is closed"));
}

TEST_F(ControllerLibraryTest, RefusesOtherVersionsAndHeaders) {
  EXPECT_THAT(Complaint(Library("other_version")),
              AllOf(HasSubstr("version 999"), HasSubstr("build it anew")));
  EXPECT_THAT(Complaint(Library("other_headers")), HasSubstr("other headers"));
}

TEST_F(ControllerLibraryTest, NamesTheControllersThereAre) {
  EXPECT_THAT(Complaint(Library("good"), "folower"),
              AllOf(HasSubstr("has no controller \"folower\""), HasSubstr("follower, throws")));
}

TEST_F(ControllerLibraryTest, SurvivesFactoriesThatFail) {
  EXPECT_THAT(Complaint(Library("good"), "throws"), HasSubstr("no such luck"));
  EXPECT_THAT(Complaint(Library("good"), "throws_number"), HasSubstr("no std::exception"));
  EXPECT_THAT(Complaint(Library("good"), "null"), HasSubstr("returned null"));
  EXPECT_THAT(Complaint(Library("good"), "throws_past_the_border"),
              HasSubstr("thrown past the border"));
}

TEST_F(ControllerLibraryTest, SaysWhichCallThrew) {
  const Parameters none;
  ParameterReader reader(none);
  EXPECT_THAT(
      [&] { Load(Library("good"), "throws_in_configure")->Configure(reader); },
      ::testing::ThrowsMessage<InputError>(AllOf(HasSubstr("Configure()"), HasSubstr("index 8"))));
  const auto activate = [&](std::string_view type) {
    Load(Library("good"), type)->Activate(RobotState(), Time());
  };
  EXPECT_THAT([&] { activate("throws_in_activate"); },
              ::testing::ThrowsMessage<InputError>(HasSubstr("Activate() threw")));
  EXPECT_THAT([&] { activate("refuses"); },
              ::testing::ThrowsMessage<InputError>("not from here; go home first"));
}

}  // namespace
}  // namespace twin::control::control_controller_library_test
