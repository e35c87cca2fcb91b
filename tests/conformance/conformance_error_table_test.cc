// Every error, provoked by a minimal stream through the backend, and the neighbouring stream that
// passes. The rows are documentation too: print_error_table.

#include <algorithm>

#include <gtest/gtest.h>

#include "conformance/error_table.h"

namespace twin::test::conformance_error_table_test {
namespace {

struct Case {
  std::string name;
  ErrorRow row;
  HarnessCase harness;
};

void PrintTo(const Case& test_case, std::ostream* out) {
  *out << test_case.row.cause << " / " << test_case.row.neighbour;
}

std::vector<Case> CasesOf(const std::vector<ErrorRow>& table) {
  std::vector<Case> cases;
  for (const HarnessCase& harness : Harnesses()) {
    for (std::size_t i = 0; i < table.size(); ++i) {
      if (table[i].plant != harness.plant_kind) continue;
      cases.push_back({NameOf(table[i], i), table[i], harness});
    }
  }
  return cases;
}

class ErrorTableTest : public ::testing::TestWithParam<Case> {};

TEST_P(ErrorTableTest, IsRaisedByItsCauseAndByNothingBesideIt) {
  for (const std::string& failure : CheckRow(GetParam().row, GetParam().harness)) {
    ADD_FAILURE() << failure;
  }
}

INSTANTIATE_TEST_SUITE_P(Rows, ErrorTableTest, ::testing::ValuesIn(CasesOf(ErrorTable())),
                         [](const auto& info) { return info.param.name; });
INSTANTIATE_TEST_SUITE_P(Fr3Rows, ErrorTableTest,
                         ::testing::ValuesIn(CasesOf(CommandErrorTable(Fr3Arm()))),
                         [](const auto& info) { return info.param.name; });

TEST(ErrorTableCoverageTest, HasARowForEveryErrorAMotionCanRaise) {
  const std::vector<ErrorRow> table = ErrorTable();
  for (const int index : {0,  2,  3,  4,  6,  7,  11, 12, 13, 14, 15, 16, 17, 18,
                          19, 20, 21, 22, 25, 26, 27, 28, 29, 30, 31, 32, 34}) {
    EXPECT_TRUE(std::any_of(table.begin(), table.end(), [&](const ErrorRow& row) {
      return static_cast<int>(row.error) == index;
    })) << index;
  }
}

}  // namespace
}  // namespace twin::test::conformance_error_table_test
