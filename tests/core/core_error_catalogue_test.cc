#include "twin/core/error_catalogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <set>
#include <string>
#include <vector>

namespace twin::core_error_catalogue_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::vector<RobotError> AllErrors() {
  std::vector<RobotError> errors;
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) errors.push_back(static_cast<RobotError>(i));
  return errors;
}

std::string TextOf(const ErrorEntry& entry) {
  std::string text;
  for (const std::string_view part : {entry.meaning, entry.quantity, entry.computed, entry.cause,
                                      entry.cure, entry.in_scenario, entry.in_realtime}) {
    text += std::string(part) + '\n';
  }
  return text;
}

// The errors that belong to Desk's own motions, its force control, and the base's sensor.
const std::set<int> kNotRaised{8, 9, 10, 23, 24, 33, 36, 37, 38, 39, 40};

TEST(ErrorCatalogueTest, RaisesExactlyWhatMotionsOverFciCanRaise) {
  for (const RobotError error : AllErrors()) {
    EXPECT_EQ(EntryOf(error).raised, !kNotRaised.contains(static_cast<int>(error))) << Name(error);
  }
}

TEST(ErrorCatalogueTest, EveryErrorSaysWhatItMeansAndWhyItIsOrIsNotRaised) {
  for (const RobotError error : AllErrors()) {
    const ErrorEntry& entry = EntryOf(error);
    EXPECT_GT(entry.meaning.size(), 20U) << Name(error);
    EXPECT_GT(entry.cause.size(), 30U) << Name(error);
  }
}

TEST(ErrorCatalogueTest, EveryRaisedErrorSaysWhatIsComparedHowAndWhatHelps) {
  for (const RobotError error : AllErrors()) {
    const ErrorEntry& entry = EntryOf(error);
    if (!entry.raised) continue;
    EXPECT_THAT(std::string(entry.quantity), Not(IsEmpty())) << Name(error);
    EXPECT_GT(entry.computed.size(), 15U) << Name(error);
    EXPECT_GT(entry.cure.size(), 15U) << Name(error);
  }
}

TEST(ErrorCatalogueTest, WhatIsNotRaisedPromisesNoCure) {
  for (const int index : kNotRaised) {
    const ErrorEntry& entry = EntryOf(static_cast<RobotError>(index));
    EXPECT_TRUE(entry.quantity.empty() && entry.computed.empty() && entry.cure.empty()) << index;
  }
}

TEST(ErrorCatalogueTest, EveryAxisOfAViolationHasANameAndItsUnit) {
  for (const RobotError error : AllErrors()) {
    const AxisKind kind = EntryOf(error).axis;
    const int axes = kind == AxisKind::kJoint    ? 7
                     : kind == AxisKind::kMotion ? 3
                     : kind == AxisKind::kWrench ? 6
                                                 : 0;
    std::set<std::string> names;
    for (int axis = 0; axis < axes; ++axis) {
      const Violation violation{.error = error, .axis = static_cast<std::int8_t>(axis)};
      names.insert(AxisName(violation));
      EXPECT_FALSE(UnitOf(violation).empty()) << Name(error) << axis;
    }
    EXPECT_EQ(names.size(), static_cast<std::size_t>(axes)) << Name(error);
    EXPECT_FALSE(names.contains("")) << Name(error);
    EXPECT_EQ(AxisName({.error = error, .axis = -1}), "");
  }
}

TEST(ErrorCatalogueTest, AnAxisThatIsNoneHasNoName) {
  EXPECT_EQ(AxisName({.error = RobotError::kCartesianVelocityViolation, .axis = 6}), "");
  EXPECT_EQ(UnitOf({.error = RobotError::kCartesianVelocityViolation, .axis = 6}), "");
  EXPECT_EQ(AxisName({.error = RobotError::kCommunicationConstraintsViolation, .axis = 0}), "");
}

TEST(ErrorCatalogueTest, TextsEndWithoutAFullStopAndAreOneLine) {
  for (const RobotError error : AllErrors()) {
    const ErrorEntry& entry = EntryOf(error);
    for (const std::string_view part : {entry.meaning, entry.quantity, entry.computed, entry.cause,
                                        entry.cure, entry.in_scenario, entry.in_realtime}) {
      EXPECT_FALSE(part.ends_with('.') || part.ends_with(' ')) << part;
      EXPECT_EQ(part.find_first_of("\n\t"), std::string_view::npos) << part;
      EXPECT_EQ(part.find("  "), std::string_view::npos) << part;
    }
  }
}

TEST(ErrorCatalogueTest, MissingFirstCommandIsAnEntryOfItsOwn) {
  const Violation lost{.error = RobotError::kCommunicationConstraintsViolation, .axis = -1};
  const Violation none{.error = RobotError::kCommunicationConstraintsViolation, .axis = 0};
  EXPECT_EQ(&EntryOf(lost), &EntryOf(RobotError::kCommunicationConstraintsViolation));
  EXPECT_NE(EntryOf(none).meaning, EntryOf(lost).meaning);
  EXPECT_EQ(&EntryOf(Violation{.error = RobotError::kJointReflex, .axis = 0}),
            &EntryOf(RobotError::kJointReflex));
}

TEST(ErrorCatalogueTest, AValueThatIsNoNumberIsAnEntryOfItsOwn) {
  const Violation swings{.error = RobotError::kInstabilityDetected, .axis = 3};
  const Violation broken{.error = RobotError::kInstabilityDetected, .axis = -1};
  EXPECT_EQ(&EntryOf(swings), &EntryOf(RobotError::kInstabilityDetected));
  EXPECT_NE(EntryOf(broken).meaning, EntryOf(swings).meaning);
  EXPECT_THAT(ErrorCatalogue(), HasSubstr(std::string(EntryOf(broken).meaning)));
}

TEST(ErrorCatalogueTest, TheCureKnowsWhoKeepsTime) {
  const ErrorEntry& entry = EntryOf(RobotError::kCommunicationConstraintsViolation);
  EXPECT_THAT(CureOf(entry, TimeKeeper::kWallClock),
              AllOf(HasSubstr("panda-twin check"), Not(HasSubstr("d_INT"))));
  EXPECT_THAT(CureOf(entry, TimeKeeper::kVirtualClock),
              AllOf(HasSubstr("d_INT"), Not(HasSubstr("panda-twin check"))));
}

TEST(ErrorCatalogueTest, DocumentationHoldsEveryErrorWithAllItsTexts) {
  const std::string text = ErrorCatalogue();
  for (const RobotError error : AllErrors()) {
    EXPECT_THAT(text, HasSubstr("## " + std::to_string(static_cast<int>(error)) + " " +
                                std::string(Name(error)) + "\n"));
    for (const std::string_view part : {EntryOf(error).meaning, EntryOf(error).cause,
                                        EntryOf(error).computed, EntryOf(error).cure}) {
      EXPECT_THAT(text, HasSubstr(std::string(part)));
    }
  }
  EXPECT_THAT(text, HasSubstr("The motion's first command did not come"));
}

TEST(ErrorCatalogueTest, NoTwoErrorsOfTheSameCauseReadTheSame) {
  std::set<std::string> seen;
  for (const RobotError error : AllErrors()) {
    EXPECT_TRUE(seen.insert(TextOf(EntryOf(error))).second) << Name(error);
  }
}

}  // namespace
}  // namespace twin::core_error_catalogue_test
