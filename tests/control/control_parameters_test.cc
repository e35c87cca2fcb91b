#include "twin/control/parameters.h"

#include <chrono>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::control::control_parameters_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kDegree = std::numbers::pi / 180;

Parameter One(std::string key, std::string value) {
  return {.key = std::move(key), .values = {std::move(value)}, .where = "s.yaml:7"};
}

Parameter List(std::string key, std::vector<std::string> values) {
  return {.key = std::move(key), .values = std::move(values), .is_list = true, .where = "s.yaml:8"};
}

/// What `read` complains of.
template <typename Read>
std::string Complaint(const Parameters& parameters, Read read) {
  ParameterReader reader(parameters);
  try {
    read(reader);
    reader.RefuseUnread();
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

TEST(ParameterReaderTest, GivesTheDefaultOfWhatIsNotGiven) {
  const Parameters none;
  ParameterReader p(none);
  EXPECT_EQ(p.Number("a", 1.5, 0, 1), 1.5) << "a default is not checked";
  EXPECT_EQ(p.Quantity("b", Dimension::kStiffness, 600, 0, 1000), 600);
  EXPECT_EQ(p.Time("c", seconds(1), seconds(0), seconds(2)), seconds(1));
  EXPECT_TRUE(p.Bool("d", true));
  EXPECT_EQ(p.Choice("e", "hold", {"hold", "path"}), "hold");
  EXPECT_EQ(p.Vector("f", Dimension::kLength, {1, 2, 3}, 0, 5), (Vector3{1, 2, 3}));
  EXPECT_EQ(p.Joints("g", Dimension::kAngle, {1, 2, 3, 4, 5, 6, 7}, 0, 9)[6], 7);
  EXPECT_FALSE(p.Has("a"));
  EXPECT_NO_THROW(p.RefuseUnread());
}

TEST(ParameterReaderTest, GivesWhatIsGivenInBaseUnits) {
  const Parameters given{One("share", "0.25"),
                         One("spring.along", "900 N/m"),
                         One("fade", "250 ms"),
                         One("on", "true"),
                         One("reference", "path"),
                         One("one", "10 mm"),
                         List("three", {"1 m", "20 mm", "-3 m"}),
                         One("q0.unit", "deg"),
                         List("q0.values", {"0", "10", "0", "-90", "0", "107", "0"}),
                         One("all", "180 deg")};
  ParameterReader p(given);
  EXPECT_EQ(p.Number("share", 1, 0, 1), 0.25);
  EXPECT_EQ(p.Quantity("spring.along", Dimension::kLinearStiffness, 0, 0, 1000), 900);
  EXPECT_EQ(p.Time("fade", seconds(1), seconds(0), seconds(2)), milliseconds(250));
  EXPECT_TRUE(p.Bool("on", false));
  EXPECT_EQ(p.Choice("reference", "hold", {"hold", "path"}), "path");
  EXPECT_EQ(p.Vector("one", Dimension::kLength, {}, -5, 5), (Vector3{0.01, 0.01, 0.01}));
  EXPECT_EQ(p.Vector("three", Dimension::kLength, {}, -5, 5), (Vector3{1, 0.02, -3}));
  const JointVector q0 = p.Joints("q0", Dimension::kAngle, {}, -3, 3);
  EXPECT_DOUBLE_EQ(q0[1], 10 * kDegree);
  EXPECT_DOUBLE_EQ(q0[5], 107 * kDegree);
  EXPECT_DOUBLE_EQ(p.Joints("all", Dimension::kAngle, {}, -4, 4)[6], std::numbers::pi);
  EXPECT_TRUE(p.Has("spring"));
  EXPECT_TRUE(p.Has("q0"));
  EXPECT_FALSE(p.Has("spr"));
  EXPECT_NO_THROW(p.RefuseUnread());
}

TEST(ParameterReaderTest, RefusesWhatDoesNotFitWithItsPlace) {
  const auto stiffness = [](ParameterReader& p) {
    (void)p.Quantity("k", Dimension::kStiffness, 0, 0, 100);
  };
  const auto complaint = [&](const std::string& value) {
    return Complaint({One("k", value)}, stiffness);
  };
  EXPECT_EQ(complaint("100 Nm/rad"), "(accepted)");
  EXPECT_THAT(complaint("101 Nm/rad"), AllOf(StartsWith("s.yaml:7: controller.parameters.k: "),
                                             HasSubstr("[0, 100] Nm/rad")));
  EXPECT_THAT(complaint("5"), HasSubstr("has no unit"));
  EXPECT_THAT(complaint("5 N/m"), HasSubstr("N/m"));
  EXPECT_THAT(complaint("stiff"), HasSubstr("stiff"));
  EXPECT_THAT(Complaint({List("k", {"1 Nm/rad"})}, stiffness), HasSubstr("is a list"));
}

TEST(ParameterReaderTest, RefusesWrongNumbersTimesChoicesAndSwitches) {
  const auto with = [](const std::string& value, auto read) {
    return Complaint({One("k", value)}, read);
  };
  const auto number = [](ParameterReader& p) { (void)p.Number("k", 0, 0, 1); };
  EXPECT_THAT(with("2", number), HasSubstr("[0, 1]"));
  EXPECT_THAT(with("nan", number), HasSubstr("not a plain finite number"));
  const auto time = [](ParameterReader& p) { (void)p.Time("k", {}, seconds(0), seconds(1)); };
  EXPECT_THAT(with("2 s", time), HasSubstr("[0 s, 1 s]"));
  EXPECT_THAT(with("2 m", time), HasSubstr("does not fit a time"));
  const auto choice = [](ParameterReader& p) { (void)p.Choice("k", "hold", {"hold", "path"}); };
  EXPECT_THAT(with("hld", choice), AllOf(HasSubstr("did you mean"), HasSubstr("hold, path")));
  const auto onoff = [](ParameterReader& p) { (void)p.Bool("k", true); };
  EXPECT_THAT(with("yes", onoff), HasSubstr("neither true nor false"));
}

TEST(ParameterReaderTest, RefusesVectorsOfTheWrongForm) {
  const auto vector = [](ParameterReader& p) {
    (void)p.Vector("k", Dimension::kLength, {}, -1, 1);
  };
  EXPECT_THAT(Complaint({List("k", {"1 m", "1 m"})}, vector), HasSubstr("has 2 values"));
  EXPECT_THAT(Complaint({List("k", {"0 m", "2 m", "0 m"})}, vector), HasSubstr("\"2 m\""));
  const auto joints = [](ParameterReader& p) { (void)p.Joints("k", Dimension::kAngle, {}, -1, 1); };
  const Parameter unit = One("k.unit", "deg");
  const std::vector<std::string> values(7, "45");
  EXPECT_EQ(Complaint({unit, List("k.values", values)}, joints), "(accepted)");
  EXPECT_THAT(Complaint({unit}, joints), HasSubstr("k.values"));
  EXPECT_THAT(Complaint({List("k.values", values)}, joints), HasSubstr("k.unit"));
  EXPECT_THAT(Complaint({unit, List("k.values", {"1", "2"})}, joints), HasSubstr("needs 7"));
  EXPECT_THAT(Complaint({unit, One("k.values", "1")}, joints), HasSubstr("needs 7"));
  const std::vector<std::string> far(7, "60");
  EXPECT_THAT(Complaint({unit, List("k.values", far)}, joints), HasSubstr("60 is out of range"));
}

TEST(ParameterReaderTest, GivesTextsAndTheirPlaces) {
  const Parameters given{One("object", "parcel"), One("place.on", "high")};
  ParameterReader p(given, "application.parameters");
  EXPECT_EQ(p.Text("object", ""), "parcel");
  EXPECT_EQ(p.Text("hand", "left"), "left");
  EXPECT_EQ(p.PlaceOf("object"), "s.yaml:7: application.parameters.object: ");
  EXPECT_EQ(p.PlaceOf("place"), "s.yaml:7: application.parameters.place: ") << "of what is below";
  EXPECT_EQ(p.PlaceOf("hand"), "application.parameters.hand: ");
  EXPECT_THAT(Complaint({List("object", {"a", "b"})},
                        [](ParameterReader& reader) { (void)reader.Text("object", ""); }),
              HasSubstr("is a list"));
}

TEST(ParameterReaderTest, RefusesWhatNobodyAskedFor) {
  const auto reads = [](ParameterReader& p) {
    (void)p.Number("stiffness", 0, 0, 1);
    (void)p.Number("damping", 0, 0, 1);
  };
  EXPECT_THAT(Complaint({One("stifness", "1")}, reads),
              AllOf(StartsWith("s.yaml:7: controller.parameters.stifness: unknown"),
                    HasSubstr("did you mean \"stiffness\""), HasSubstr("stiffness, damping")));
  EXPECT_THAT(Complaint({One("k", "1")}, [](ParameterReader&) {}), HasSubstr("no parameters"));
}

}  // namespace
}  // namespace twin::control::control_parameters_test
