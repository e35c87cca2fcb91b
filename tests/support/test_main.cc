// main() of every test program: an empty suite is an error, and a skipped case makes a skipped
// test.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

namespace {
/// ctest's word for it: TWIN_SKIPPED of scripts/cmake/TwinTest.cmake.
constexpr int kSkipped = 77;
}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  const int result = RUN_ALL_TESTS();
  const testing::UnitTest& unit_test = *testing::UnitTest::GetInstance();
  if (!testing::GTEST_FLAG(list_tests) && unit_test.test_to_run_count() == 0) {
    std::fprintf(stderr, "no test ran: the program has none, or --gtest_filter matches none\n");
    return 1;
  }
  return result == 0 && unit_test.skipped_test_count() > 0 ? kSkipped : result;
}
