// A test program for skips_test.py, which runs it case by case.

#include <gtest/gtest.h>

TEST(SkippingProgram, Passes) {}
TEST(SkippingProgram, Skips) {
  GTEST_SKIP() << "there is no disk";
}
TEST(SkippingProgram, Fails) {
  FAIL();
}
