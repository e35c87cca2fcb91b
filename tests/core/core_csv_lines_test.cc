#include "twin/core/csv_lines.h"

#include <array>
#include <sstream>

#include <gmock/gmock.h>

#include "twin/core/error.h"

namespace twin::core_csv_lines_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr std::array<std::string_view, 2> kColumns{"time", "word"};
constexpr CsvFormat kFormat{kColumns, "time in s"};

/// Reads all rows of `text`.
int Rows(const std::string& text) {
  std::istringstream in(text);
  CsvLines lines(in, "a.csv", kFormat);
  int rows = 0;
  while (lines.Next()) ++rows;
  return rows;
}

TEST(CsvLinesTest, GivesFieldsWithoutTheSpacesAroundThem) {
  std::istringstream in("time,word\n 1.5 ,\tgo \n");
  CsvLines lines(in, "a.csv", kFormat);
  ASSERT_TRUE(lines.Next());
  EXPECT_EQ(lines.Number(0, "seconds"), 1.5);
  EXPECT_EQ(lines.field(1), "go");
}

TEST(CsvLinesTest, TakesWhatSpreadsheetsPutAround) {
  EXPECT_EQ(Rows("\xEF\xBB\xBFtime,word\r\n1,a\r\n2,b\r\n\r\n\n"), 2);
}

TEST(CsvLinesTest, HasNoRowsInAnEmptyFile) {
  EXPECT_EQ(Rows(""), 0);
}

TEST(CsvLinesTest, RefusesAnotherHeader) {
  EXPECT_THAT([] { Rows("time;word\n"); },
              ThrowsMessage<InputError>(HasSubstr(
                  "a.csv:1: the header is 'time;word'; it must be 'time,word' (time in s)")));
}

TEST(CsvLinesTest, RefusesRowsOfOtherLengthsByTheirLine) {
  EXPECT_THAT([] { Rows("time,word\n1,a\n1,a,b,c\n"); },
              ThrowsMessage<InputError>(HasSubstr("a.csv:3: 4 fields in '1,a,b,c'; 2 are needed")));
}

TEST(CsvLinesTest, NamesTheColumnOfWhatIsNoNumber) {
  std::istringstream in("time,word\nnan,a\n");
  CsvLines lines(in, "a.csv", kFormat);
  ASSERT_TRUE(lines.Next());
  EXPECT_THAT([&] { static_cast<void>(lines.Number(0, "seconds")); },
              ThrowsMessage<InputError>(HasSubstr("a.csv:2: column time is 'nan'; it must be a "
                                                  "finite number of seconds")));
}

}  // namespace
}  // namespace twin::core_csv_lines_test
