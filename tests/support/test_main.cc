// main() of every test program: `PROGRAM SOURCE` runs the cases that SOURCE.cc defines. An empty
// suite is an error, and a skipped case makes a skipped test.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

namespace {
/// ctest's word for it: TWIN_SKIPPED of scripts/cmake/TwinTest.cmake.
constexpr int kSkipped = 77;

/// Filter of the cases that the source of this name, without its .cc, defines.
std::string CasesOf(std::string_view source) {
  const testing::UnitTest& program = *testing::UnitTest::GetInstance();
  std::string filter;
  for (int s = 0; s < program.total_test_suite_count(); ++s) {
    const testing::TestSuite& suite = *program.GetTestSuite(s);
    for (int t = 0; t < suite.total_test_count(); ++t) {
      const testing::TestInfo& test = *suite.GetTestInfo(t);
      if (std::filesystem::path(test.file()).stem() != source) continue;
      filter += std::string(suite.name()) + '.' + test.name() + ':';
    }
  }
  return filter.empty() ? "-*" : filter;
}
}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  if (argc == 2) testing::GTEST_FLAG(filter) = CasesOf(argv[1]);
  const int result = RUN_ALL_TESTS();
  const testing::UnitTest& unit_test = *testing::UnitTest::GetInstance();
  if (!testing::GTEST_FLAG(list_tests) && unit_test.test_to_run_count() == 0) {
    std::fprintf(
        stderr,
        "no test ran: the program has none, or its source or --gtest_filter matches none\n");
    return 1;
  }
  return result == 0 && unit_test.skipped_test_count() > 0 ? kSkipped : result;
}
