#include "twin/core/proportion.h"

#include <gtest/gtest.h>

namespace twin::core_proportion_test {
namespace {

TEST(WilsonIntervalTest, IsAsPublished) {
  // Newcombe, "Two-sided confidence intervals for the single proportion", 1998, table I: method 3.
  const auto near = [](std::pair<double, double> interval, double least, double most) {
    EXPECT_NEAR(interval.first, least, 5e-5);
    EXPECT_NEAR(interval.second, most, 5e-5);
  };
  near(WilsonInterval(81, 263), 0.2553, 0.3662);
  near(WilsonInterval(15, 148), 0.0624, 0.1605);
  near(WilsonInterval(0, 20), 0, 0.1611);
  near(WilsonInterval(1, 29), 0.0061, 0.1718);
  near(WilsonInterval(20, 20), 0.8389, 1);
}

}  // namespace
}  // namespace twin::core_proportion_test
