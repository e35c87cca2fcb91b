#include "twin/rt/child_process.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <string>
#include <system_error>

#include <gtest/gtest.h>

namespace twin::rt::rt_child_process_test {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

/// A child's standard output, read to its end: there is one when nobody holds the other end.
class Pipe {
 public:
  Pipe() { EXPECT_EQ(::pipe2(ends_.data(), O_CLOEXEC), 0); }
  ~Pipe() {
    CloseInput();
    ::close(ends_[0]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  [[nodiscard]] int input() const { return ends_[1]; }
  void CloseInput() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }
  [[nodiscard]] std::string ReadLine() const {
    std::string text;
    for (char c = 0; ::read(ends_[0], &c, 1) == 1 && c != '\n';) text += c;
    return text;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

TEST(ChildProcessTest, TellsHowItEnded) {
  ChildProcess good("sh", {"-c", "exit 7"}, {});
  EXPECT_EQ(DescribeEnd(good.Wait(hours(1)).value()), "ended with exit code 7");
  ChildProcess killed("sh", {"-c", "kill -TERM $$"}, {});
  EXPECT_EQ(DescribeEnd(killed.Wait(hours(1)).value()), "was ended by signal 15 (Terminated)");
}

TEST(ChildProcessTest, HasTheFilesItIsGivenAndNoOthers) {
  Pipe out;
  ChildProcess child("sh", {"-c", "ls -l /proc/self/fd/0 | grep -c /dev/null"},
                     {.out = out.input()});
  out.CloseInput();
  EXPECT_EQ(out.ReadLine(), "1");
  EXPECT_EQ(child.Wait(hours(1)), 0);
}

TEST(ChildProcessTest, SaysWhenThereIsNoSuchProgram) {
  EXPECT_THROW(ChildProcess("no-such-program-anywhere", {}, {}), std::system_error);
}

TEST(ChildProcessTest, OneThatTakesTooLongIsKilledWithWhatItStarted) {
  Pipe out;
  ChildProcess child("sh", {"-c", "sleep 1000 & sleep 1000"}, {.out = out.input()});
  out.CloseInput();
  EXPECT_FALSE(child.Wait(milliseconds(20)));
  EXPECT_EQ(out.ReadLine(), "");  // returns once neither holds the pipe
}

TEST(ChildProcessTest, NoneOutlivesItsObject) {
  Pipe out;
  {
    const ChildProcess child("sh", {"-c", "sleep 1000 & sleep 1000"}, {.out = out.input()});
    out.CloseInput();
  }
  EXPECT_EQ(out.ReadLine(), "");
}

TEST(ChildProcessTest, NobodyIsWaitedForOnceTheUserWantsToEnd) {
  volatile bool interrupted = true;
  GiveUpWhen(&interrupted);
  EXPECT_TRUE(GivesUp());
  ChildProcess child("sleep", {"1000"}, {});
  EXPECT_FALSE(child.Wait(hours(1)));
  interrupted = false;
  EXPECT_FALSE(GivesUp());
  GiveUpWhen(nullptr);
  EXPECT_FALSE(GivesUp());
}

}  // namespace
}  // namespace twin::rt::rt_child_process_test
