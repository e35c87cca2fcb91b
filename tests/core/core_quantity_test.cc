#include "twin/core/quantity.h"

#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::core_quantity_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(QuantityTest, ConvertsToTheBaseUnit) {
  EXPECT_EQ(ParseQuantity("180 deg", Dimension::kAngle), std::numbers::pi);
  EXPECT_EQ(ParseQuantity("-0.7 rad", Dimension::kAngle), -0.7);
  EXPECT_EQ(ParseQuantity("1 kHz", Dimension::kFrequency), 1000);
  EXPECT_EQ(ParseQuantity("0.1 %", Dimension::kPercent), 0.1);
  EXPECT_EQ(ParseQuantity("3000 Nm/rad", Dimension::kStiffness), 3000);
  EXPECT_EQ(ParseQuantity("5 mm/s", Dimension::kVelocity), 0.005);
  EXPECT_EQ(ParseQuantity("13 m/s^2", Dimension::kAcceleration), 13);
  EXPECT_EQ(ParseQuantity("6500 m/s^3", Dimension::kJerk), 6500);
  EXPECT_EQ(ParseQuantity("0.2 kg m^2", Dimension::kInertia), 0.2);
  EXPECT_EQ(ParseQuantity("600 mbar", Dimension::kPressure), 60e3);
}

TEST(QuantityTest, NeedsNoBlankBeforeTheUnit) {
  EXPECT_EQ(ParseQuantity("1e3Hz", Dimension::kFrequency), 1000);
  EXPECT_EQ(ParseQuantity("  +5  ms ", Dimension::kTime), 0.005);
}

TEST(QuantityTest, ReadsEveryUnitItNames) {
  for (const Dimension dimension : {Dimension::kTime, Dimension::kAngle, Dimension::kInertia}) {
    EXPECT_THAT(UnitNames(dimension), ::testing::Contains(BaseUnit(dimension)));
    for (const std::string_view unit : UnitNames(dimension)) {
      EXPECT_GT(ParseQuantity("1 " + std::string(unit), dimension), 0) << unit;
    }
  }
  EXPECT_EQ(Name(Dimension::kAngularVelocity), "angular velocity");
}

TEST(QuantityTest, ReadsTimesToTheNanosecond) {
  EXPECT_EQ(ParseDuration("18.32 s"), milliseconds(18320));
  EXPECT_EQ(ParseDuration("13.2 us"), nanoseconds(13200));
  EXPECT_EQ(ParseDuration("1 min"), std::chrono::seconds(60));
}

TEST(QuantityTest, TakesBothMusForMicro) {
  EXPECT_EQ(ParseDuration("80 \xc2\xb5s"), microseconds(80)) << "the micro sign";
  EXPECT_EQ(ParseDuration("80\xce\xbcs"), microseconds(80)) << "the small letter mu";
  EXPECT_EQ(UnitFactor("\xc2\xb5s", Dimension::kTime), 1e-6);
  EXPECT_THROW((void)UnitFactor("\xc2\xb5s", Dimension::kAngle), InputError);
}

TEST(QuantityTest, WritesTimesWithoutLoss) {
  for (const Duration d : {Duration(0), Duration(1), Duration(1500), Duration(80'000),
                           Duration(18'320'000'000), Duration(86'400'000'000'000)}) {
    EXPECT_EQ(ParseDuration(FormatDuration(d)), d) << FormatDuration(d);
  }
  EXPECT_EQ(FormatDuration(milliseconds(18320)), "18320 ms");
  EXPECT_EQ(FormatDuration(microseconds(80)), "80 us");
}

TEST(QuantityTest, NamesTheAcceptedUnitsWhenTheUnitIsMissing) {
  EXPECT_THAT([] { (void)ParseQuantity("80", Dimension::kTime); },
              ThrowsMessage<InputError>(HasSubstr("has no unit; a time is written like \"500 us\" "
                                                  "(units: ns, us, ms, s, min)")));
}

TEST(QuantityTest, RefusesAUnitOfAnotherDimension) {
  EXPECT_THAT([] { (void)ParseQuantity("80 Hz", Dimension::kTime); },
              ThrowsMessage<InputError>(HasSubstr("unit \"Hz\" does not fit a time")));
}

TEST(QuantityTest, RefusesWhatIsNoNumber) {
  for (const char* text : {"", "s", "nan s", "inf s", "-inf s", "0x10 s", "1,5 s", "--1 s", "1 2 s",
                           "1e999 s", "+-1 s", "."}) {
    EXPECT_THROW((void)ParseQuantity(text, Dimension::kTime), InputError) << text;
  }
}

TEST(QuantityTest, RefusesATimeOfMoreThanACentury) {
  EXPECT_THROW((void)ParseDuration("1e300 s"), InputError);
  EXPECT_THROW((void)ParseDuration("4e9 s"), InputError);
}

TEST(QuantityTest, WritesNumbersWithoutLoss) {
  for (const double value : {0.1, 1.0 / 3.0, -1e-300, 14250.0, 0.30000000000000004}) {
    EXPECT_EQ(ParseNumber(FormatNumber(value)), value);
  }
}

}  // namespace
}  // namespace twin::core_quantity_test
