#include "twin/reference/trajectory.h"

#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include "support/panda_limits.h"
#include "twin/core/error.h"
#include "twin/core/random.h"

namespace twin::reference::trajectory_file_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using namespace std::chrono_literals;

constexpr const char* kHeader = "time,q1,q2,q3,q4,q5,q6,q7\n";
constexpr const char* kGood =
    "time,q1,q2,q3,q4,q5,q6,q7\n"
    "0,0,-0.5,0,-2,0,1.5,0.7\n"
    "1.5,0.25,-0.5,1e-2,-2,0,1.5,0.7\n";

class ReadWaypointsCsvTest : public testing::Test {
 protected:
  ReadWaypointsCsvTest() { std::filesystem::create_directories(folder_); }
  ~ReadWaypointsCsvTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Write(const std::string& content) const {
    auto path = folder_ / "motion.csv";
    std::filesystem::remove(path);  // writing over a file can make the system flush it
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }

  void ExpectRefused(const std::string& content,
                     const testing::Matcher<const std::string&>& text) const {
    const auto path = Write(content);
    EXPECT_THAT([&] { (void)ReadWaypointsCsv(path); }, ThrowsMessage<InputError>(text));
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / fmt::format("twin_csv_{}", getpid());
};

TEST_F(ReadWaypointsCsvTest, ReadsTimesAndPositions) {
  const auto waypoints = ReadWaypointsCsv(Write(kGood));
  ASSERT_EQ(waypoints.size(), 2u);
  EXPECT_EQ(waypoints[0].at, 0s);
  EXPECT_EQ(waypoints[1].at, 1500ms);
  EXPECT_EQ(waypoints[1].q, (JointVector{0.25, -0.5, 1e-2, -2, 0, 1.5, 0.7}));
  EXPECT_EQ(waypoints[1].where, "motion.csv:3");
  EXPECT_FALSE(waypoints[1].stop);
}

TEST_F(ReadWaypointsCsvTest, AcceptsWhatEditorsAndSpreadsheetsAdd) {
  const auto plain = ReadWaypointsCsv(Write(kGood));
  std::string windows = std::string("\xEF\xBB\xBF") + kGood + "\n \n";
  for (std::size_t i = 0; (i = windows.find('\n', i)) != std::string::npos; i += 2) {
    windows.insert(i, "\r");
  }
  std::string no_last_newline = kGood;
  no_last_newline.pop_back();
  const std::string blanks =
      " time , q1,q2,q3,q4,q5,q6,q7\n0, 0,-0.5 ,0,\t-2,0,1.5,0.7\n"
      "1.5,0.25,-0.5,1e-2,-2,0,1.5,0.7\n";
  for (const std::string& content : {windows, no_last_newline, blanks}) {
    const auto waypoints = ReadWaypointsCsv(Write(content));
    ASSERT_EQ(waypoints.size(), plain.size());
    for (std::size_t i = 0; i < plain.size(); ++i) {
      EXPECT_EQ(waypoints[i].q, plain[i].q);
      EXPECT_EQ(waypoints[i].at, plain[i].at);
    }
  }
}

TEST_F(ReadWaypointsCsvTest, RefusesAnotherHeader) {
  ExpectRefused("0,0,-0.5,0,-2,0,1.5,0.7\n",
                AllOf(HasSubstr("motion.csv:1: the header is '0,0,-0.5"),
                      HasSubstr("it must be 'time,q1,q2,q3,q4,q5,q6,q7' (time in s, q in rad)")));
  ExpectRefused("time;q1;q2;q3;q4;q5;q6;q7\n", HasSubstr("the header is 'time;q1"));
  ExpectRefused("time,q1,q2,q3,q4,q5,q6,q7,q8\n", HasSubstr("the header is"));
}

TEST_F(ReadWaypointsCsvTest, RefusesWhatIsNotANumber) {
  const auto with = [](const char* field) {
    return std::string(kHeader) + "0,0,0," + field + ",0,0,0,0\n";
  };
  for (const char* field : {"nan", "NaN", "inf", "-inf", "1e999", "abc", "", "1.5x", "0x10", "+1",
                            "1 2", "--1", "1.2.3"}) {
    ExpectRefused(with(field), HasSubstr(fmt::format("motion.csv:2: column q3 is '{}'; it must be "
                                                     "a finite number of rad, with a decimal point",
                                                     field)));
  }
  ExpectRefused(std::string(kHeader) + "x,0,0,0,0,0,0,0\n",
                HasSubstr("column time is 'x'; it must be a finite number of seconds"));
}

TEST_F(ReadWaypointsCsvTest, RefusesAnotherNumberOfFields) {
  ExpectRefused(std::string(kHeader) + "0,0,0,0,0,0,0\n",
                HasSubstr("motion.csv:2: 7 fields in '0,0,0,0,0,0,0'; 8 are needed"));
  ExpectRefused(std::string(kHeader) + "0,0,0,0,0,0,0,0,0\n", HasSubstr("9 fields"));
  ExpectRefused(std::string(kHeader) + "0,0,0,0,0,0,0,0,\n", HasSubstr("9 fields"));
  ExpectRefused(std::string(kHeader) + "0\n", HasSubstr("1 field in '0'"));
}

TEST_F(ReadWaypointsCsvTest, RefusesTimesThatDoNotRiseFromZero) {
  const std::string first = std::string(kHeader) + "0,0,0,0,0,0,0,0\n";
  ExpectRefused(
      first + "0,1,0,0,0,0,0,0\n",
      HasSubstr("motion.csv:3: column time is 0 s, not after the 0 s of the line before"));
  ExpectRefused(first + "1e-10,1,0,0,0,0,0,0\n", HasSubstr("not after"));
  ExpectRefused(first + "2,1,0,0,0,0,0,0\n1,1,0,0,0,0,0,0\n", HasSubstr("motion.csv:4"));
  ExpectRefused(first + "-1,1,0,0,0,0,0,0\n", HasSubstr("it must lie in [0, 86400] s"));
  ExpectRefused(first + "1e300,1,0,0,0,0,0,0\n", HasSubstr("it must lie in [0, 86400] s"));
  ExpectRefused(std::string(kHeader) + "3.5,0,0,0,0,0,0,0\n",
                HasSubstr("column time is 3.5 s; the first point's time must be 0 s (subtract 3.5 "
                          "s from the column)"));
}

TEST_F(ReadWaypointsCsvTest, RefusesFilesWithoutPointsOrWithHoles) {
  ExpectRefused("", HasSubstr("no points"));
  ExpectRefused(kHeader, HasSubstr("no points"));
  ExpectRefused(std::string(kHeader) + "0,0,0,0,0,0,0,0\n\n1,0,0,0,0,0,0,0\n",
                HasSubstr("motion.csv:3: an empty line between points"));
}

TEST_F(ReadWaypointsCsvTest, RefusesWhatIsNoReadableFile) {
  EXPECT_THAT([&] { (void)ReadWaypointsCsv(folder_ / "missing.csv"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("missing.csv: not a file"),
                                              HasSubstr("No such file or directory"))));
  EXPECT_THAT([&] { (void)ReadWaypointsCsv(folder_); },
              ThrowsMessage<InputError>(HasSubstr("not a file that can be read")));
}

TEST_F(ReadWaypointsCsvTest, RefusesAFileThatIsTooLarge) {
  const auto path = Write(kGood);
  std::filesystem::resize_file(path, kMaxTrajectoryFileBytes + 1);  // sparse
  EXPECT_THAT([&] { (void)ReadWaypointsCsv(path); },
              ThrowsMessage<InputError>(HasSubstr("may have at most 67108864")));
}

TEST_F(ReadWaypointsCsvTest, ShowsBinaryRubbishAsPrintableText) {
  const std::string rubbish("time,\x01\x00\xff\n\x7f", 10);
  ExpectRefused(rubbish, HasSubstr("the header is 'time,\\x01\\x00\\xff'"));
  ExpectRefused(std::string(kHeader) + std::string(5000, 'a') + "\n",
                HasSubstr("1 field in '" + std::string(40, 'a') + "...'"));
}

TEST_F(ReadWaypointsCsvTest, SurvivesSeededMutationsOfAGoodFile) {
  const Random random(1, RandomStream::kTest);
  constexpr std::string_view kBytes = "0123456789.,-+eEnai \t\r\n\"';\0\xff\x80";
  int accepted = 0;
  int refused = 0;
  for (std::uint64_t round = 0; round < 1500; ++round) {
    std::string content = kGood;
    const auto draws = random.Bits(round);
    for (std::uint32_t i = 0; i <= draws[0] % 4; ++i) {
      const auto bits = random.Bits(round, i + 1);
      const std::size_t at = content.empty() ? 0 : bits[0] % content.size();
      const char byte = kBytes[bits[1] % kBytes.size()];
      switch (bits[2] % 4) {
        case 0: content.insert(at, 1, byte); break;
        case 1: content.erase(at, 1 + bits[3] % 5); break;
        case 2: content.resize(at); break;
        default:
          if (!content.empty()) content[at] = byte;
          break;
      }
    }
    try {
      const auto waypoints = ReadWaypointsCsv(Write(content));
      ++accepted;
      // What is accepted keeps the promises.
      ASSERT_FALSE(waypoints.empty());
      ASSERT_EQ(waypoints.front().at, Duration::zero());
      for (std::size_t i = 0; i < waypoints.size(); ++i) {
        for (const double q : waypoints[i].q) ASSERT_TRUE(std::isfinite(q));
        if (i > 0) {
          ASSERT_GT(*waypoints[i].at, *waypoints[i - 1].at);
        }
      }
    } catch (const InputError& error) {
      ++refused;
      ASSERT_THAT(error.what(), HasSubstr("motion.csv"));
    }
  }
  EXPECT_GT(accepted, 50);
  EXPECT_GT(refused, 500);
}

TEST_F(ReadWaypointsCsvTest, TwentyThousandRowsBecomeATrajectoryThroughThemAll) {
  constexpr int kRows = 20'001;
  std::string content = kHeader;
  const auto position = [](int row) {
    const double s = row / (kRows - 1.0);
    return 1.5 * s * s * s * (10 + s * (-15 + 6 * s));
  };
  for (int row = 0; row < kRows; ++row) {
    const double q = position(row);
    content += fmt::format("{},{},-0.7,{},-2,{},1.5,0.7\n", row * 1e-3, q, -q, q / 2);
  }
  const auto waypoints = ReadWaypointsCsv(Write(content));
  ASSERT_EQ(waypoints.size(), static_cast<std::size_t>(kRows));
  const Trajectory trajectory(waypoints, {}, test::PandaLimits());
  EXPECT_EQ(trajectory.duration(), 20s);
  for (int row = 0; row < kRows; row += 111) {
    EXPECT_NEAR(trajectory.Sample(row * kCycle).q[0], position(row), 1e-14);
  }
  // The original's peak velocity, 15/8 d/T.
  EXPECT_NEAR(trajectory.peaks().velocity[0], 1.875 * 1.5 / 20 / 2.175, 1e-8);
  EXPECT_LT(trajectory.peaks().jerk[0], 1e-4);
}

}  // namespace
}  // namespace twin::reference::trajectory_file_test
