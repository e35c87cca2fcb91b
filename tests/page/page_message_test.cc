#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <variant>

#include "page/message.h"

namespace twin::page::page_message_test {
namespace {

template <typename Kind>
std::optional<Kind> Parse(std::string_view text) {
  const std::optional<Message> said = ParseMessage(text);
  if (!said || !std::holds_alternative<Kind>(*said)) return {};
  return std::get<Kind>(*said);
}

TEST(MessageTest, HelloBringsTheToken) {
  const auto hello = Parse<message::Hello>(R"({"type":"hello","token":"ab12"})");
  ASSERT_TRUE(hello);
  EXPECT_EQ(hello->token, "ab12");
}

TEST(MessageTest, ClientsSayWhetherTheyShowPicturesOrTheScene) {
  using message::Sight;
  EXPECT_EQ(Parse<message::Hello>(R"({"type":"hello","token":"a"})")->sight, Sight::kPictures);
  EXPECT_EQ(Parse<message::Hello>(R"({"type":"hello","token":"a","of":"scene"})")->sight,
            Sight::kScene);
  EXPECT_EQ(Parse<message::ChooseSight>(R"({"type":"view","of":"pictures"})")->sight,
            Sight::kPictures);
  EXPECT_EQ(Parse<message::ChooseSight>(R"({"type":"view","of":"scene"})")->sight, Sight::kScene);
  EXPECT_FALSE(ParseMessage(R"({"type":"view","of":"all"})"));
  EXPECT_FALSE(ParseMessage(R"({"type":"view","of":1})"));
  EXPECT_FALSE(ParseMessage(R"({"type":"view"})"));
}

TEST(MessageTest, HandsBringAxesClutchAndTime) {
  const auto hands = Parse<message::Hands>(
      R"({"type":"hands","axes":[0.5,-1,0,0,0.25,1],"engaged":false,"sent_ms":12.5})");
  ASSERT_TRUE(hands);
  EXPECT_EQ(hands->axes, (Vector6{0.5, -1, 0, 0, 0.25, 1}));
  EXPECT_FALSE(hands->engaged);
  EXPECT_EQ(hands->sent_ms, 12.5);
}

TEST(MessageTest, HandsBringTheJointThatTurnsAlone) {
  const auto joint_of = [](const char* joint) {
    const auto hands = Parse<message::Hands>(
        std::string(R"({"type":"hands","axes":[1,0,0,0,0,0],"engaged":true,"sent_ms":0)") + joint +
        "}");
    return hands ? std::optional<int>(hands->joint) : std::nullopt;
  };
  EXPECT_EQ(joint_of(R"(,"joint":7)"), 7);
  EXPECT_EQ(joint_of(""), 0);
  for (const char* bad : {R"(,"joint":8)", R"(,"joint":-1)", R"(,"joint":1.5)", R"(,"joint":"1")"})
    EXPECT_EQ(joint_of(bad), std::nullopt) << bad;
}

TEST(MessageTest, PauseIsOnOrOff) {
  EXPECT_TRUE(Parse<message::Pause>(R"({"type":"pause","on":true})")->on);
  EXPECT_FALSE(Parse<message::Pause>(R"({"type":"pause","on":false})")->on);
  EXPECT_FALSE(ParseMessage(R"({"type":"pause"})"));
}

TEST(MessageTest, AxesAreCutToFullScale) {
  const auto hands = Parse<message::Hands>(
      R"({"type":"hands","axes":[7,-7,1e300,0,0,0],"engaged":true,"sent_ms":0})");
  ASSERT_TRUE(hands);
  EXPECT_EQ(hands->axes, (Vector6{1, -1, 1, 0, 0, 0}));
}

TEST(MessageTest, EveryButtonHasItsName) {
  using message::Button;
  const std::pair<const char*, Button> kAll[] = {
      {"mode", Button::kMode},   {"gripper", Button::kGripper}, {"frame", Button::kFrame},
      {"scale", Button::kScale}, {"release", Button::kRelease}, {"end", Button::kEnd}};
  for (const auto& [name, button] : kAll) {
    const auto press =
        Parse<message::Press>(std::string(R"({"type":"press","button":")") + name + R"("})");
    ASSERT_TRUE(press) << name;
    EXPECT_EQ(press->button, button) << name;
  }
}

TEST(MessageTest, PlainOnesAreUnderstood) {
  EXPECT_TRUE(Parse<message::TakeControl>(R"({"type":"take"})"));
  EXPECT_TRUE(Parse<message::GiveControlBack>(R"({"type":"give_back"})"));
  EXPECT_TRUE(Parse<message::Stop>(R"({"type":"stop"})"));
  EXPECT_TRUE(Parse<message::Recover>(R"({"type":"recover"})"));
  EXPECT_TRUE(Parse<message::Home>(R"({"type":"home"})"));
  EXPECT_TRUE(Parse<message::PictureShown>(R"({"type":"shown"})"));
  EXPECT_TRUE(Parse<message::Ping>(R"({"type":"ping","sent_ms":3})"));
  EXPECT_TRUE(Parse<message::Record>(R"({"type":"record","on":true})"));
  EXPECT_TRUE(Parse<message::ChooseCamera>(R"({"type":"camera","number":2})"));
}

TEST(MessageTest, WhatIsNotExactlyAMessageIsNone) {
  for (const char* text :
       {"",
        "{",
        "null",
        "[]",
        "\"stop\"",
        R"({"type":"fly"})",
        R"({"type":7})",
        R"({"stop":1})",
        R"({"type":"hello"})",
        R"({"type":"hello","token":7})",
        R"({"type":"press"})",
        R"({"type":"press","button":"self destruct"})",
        R"({"type":"ping","sent_ms":"now"})",
        R"({"type":"ping","sent_ms":1e999})",
        R"({"type":"camera","number":-1})",
        R"({"type":"camera","number":1.5})",
        R"({"type":"camera","number":65})",
        R"({"type":"record","on":1})",
        R"({"type":"hands","axes":[0,0,0,0,0],"engaged":true,"sent_ms":0})",
        R"({"type":"hands","axes":[0,0,0,0,0,"x"],"engaged":true,"sent_ms":0})",
        R"({"type":"hands","axes":[0,0,0,0,0,1e999],"engaged":true,"sent_ms":0})",
        R"({"type":"hands","axes":[0,0,0,0,0,0],"sent_ms":0})",
        R"({"type":"hands","axes":[0,0,0,0,0,0],"engaged":true})"}) {
    EXPECT_FALSE(ParseMessage(text)) << text;
  }
}

TEST(MessageTest, DeepNestingIsNoMessageAndNoCrash) {
  EXPECT_FALSE(ParseMessage(std::string(4096, '[')));
}

TEST(MessageTest, QuotedTextIsJsonWhateverItHolds) {
  EXPECT_EQ(Quoted("a \"b\"\n"), R"("a \"b\"\n")");
  EXPECT_EQ(Quoted("\xff"), "\"\xEF\xBF\xBD\"");
}

}  // namespace
}  // namespace twin::page::page_message_test
