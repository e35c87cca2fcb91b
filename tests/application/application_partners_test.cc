#include "twin/application/partners.h"

#include <chrono>
#include <vector>

#include <gtest/gtest.h>

namespace twin::application::application_partners_test {
namespace {

using std::chrono::milliseconds;

class MessageBoardTest : public testing::Test {
 protected:
  std::vector<scenario::CellRobot> robots_{{.name = "left", .scenario = {}, .where = ""},
                                           {.name = "right", .scenario = {}, .where = ""}};
  MessageBoard board_{robots_};
  const Partners left_{board_, 0};
  const Partners right_{board_, 1};
};

TEST_F(MessageBoardTest, TellsAMessageAfterItsInstant) {
  const Time at{milliseconds(5)};
  left_.Say({.word = "offered", .at = at});
  EXPECT_FALSE(board_.Heard(0, "offered", at)) << "the order of the robots must not count";
  ASSERT_TRUE(board_.Heard(0, "offered", at + milliseconds(1)));
  EXPECT_FALSE(board_.Heard(0, "taken", at + milliseconds(1)));
  EXPECT_FALSE(board_.Heard(1, "offered", at + milliseconds(1)));
}

TEST_F(MessageBoardTest, TellsTheLastMessageOfAWord) {
  left_.Say({.word = "offered", .at = Time(milliseconds(1)), .width = 1});
  left_.Say({.word = "offered", .at = Time(milliseconds(2)), .width = 2});
  left_.Say({.word = "clear", .at = Time(milliseconds(3)), .width = 3});
  EXPECT_EQ(board_.Heard(0, "offered", Time(milliseconds(9)))->width, 2);
  EXPECT_EQ(board_.Heard(0, "offered", Time(milliseconds(2)))->width, 1);
}

TEST_F(MessageBoardTest, TellsOfAnEndAfterTheLastMessage) {
  EXPECT_FALSE(board_.EndOf(1, Time()));
  right_.Say({.word = "taken", .at = Time(milliseconds(4))});
  board_.End(1, "it fell");
  EXPECT_FALSE(board_.EndOf(1, Time(milliseconds(4)))) << "its last word is not heard yet";
  ASSERT_TRUE(board_.EndOf(1, Time(milliseconds(5))));
  EXPECT_EQ(*board_.EndOf(1, Time(milliseconds(5))), "it fell");
}

TEST_F(MessageBoardTest, FindsOnlyOtherRobots) {
  EXPECT_EQ(left_.Find("right"), 1U);
  EXPECT_FALSE(left_.Find("left"));
  EXPECT_EQ(left_.Names(), "right");
}

}  // namespace
}  // namespace twin::application::application_partners_test
