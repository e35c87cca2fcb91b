// main() of every test program: an empty suite is an error.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  const int result = RUN_ALL_TESTS();
  const testing::UnitTest& unit_test = *testing::UnitTest::GetInstance();
  if (!testing::GTEST_FLAG(list_tests) && unit_test.test_to_run_count() == 0) {
    std::fprintf(stderr, "no test ran: the program has none, or --gtest_filter matches none\n");
    return 1;
  }
  return result;
}
