#include "twin/rt/find_program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::rt::rt_find_program_test {
namespace {

TEST(FindProgramTest, FindsAProgramInTheFirstFolderThatHasIt) {
  EXPECT_EQ(FindProgram("sh", "/proc:/bin:/usr/bin"), "/bin/sh");
}

TEST(FindProgramTest, FindsNoFileThatCannotBeRunAndNoFolder) {
  EXPECT_EQ(FindProgram("passwd", "/etc"), "");
  EXPECT_EQ(FindProgram("bin", "/usr"), "");
  EXPECT_EQ(FindProgram("sh", ""), "");
}

TEST(RequireProgramTest, SaysWhatToDo) {
  try {
    RequireProgram("no_such_program", "/bin", "apt-get install it");
    FAIL();
  } catch (const EnvironmentError& error) {
    EXPECT_STREQ(error.what(), "the program no_such_program is not installed; apt-get install it");
  }
}

}  // namespace
}  // namespace twin::rt::rt_find_program_test
