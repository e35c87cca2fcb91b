// What `panda-twin check` says about this host's time keeping.

#include "twin/loop/host_timing.h"

#include <chrono>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace twin::loop::loop_host_timing_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

JitterFigures Figures(std::uint64_t cycles, std::uint64_t unserved, std::uint64_t longest_loss) {
  JitterFigures figures;
  figures.cycles = cycles;
  figures.unserved = unserved;
  figures.longest_loss = longest_loss;
  return figures;
}

TEST(EvaluateTest, IsContentWhenNothingWasMissed) {
  const JitterVerdict verdict = Evaluate(Figures(2000, 0, 0));
  EXPECT_TRUE(verdict.good);
  EXPECT_EQ(verdict.text, "good for real time: none of 2000 cycles was missed");
}

TEST(EvaluateOrdinaryTest, RefusesThreadsThatAreOftenOrVeryLate) {
  const auto verdict = [](int late, Duration by) {
    rt::DurationHistogram wake_ups;
    for (int i = 0; i < 500; ++i) wake_ups.Add(i < late ? by : std::chrono::microseconds(80));
    return EvaluateOrdinary(wake_ups);
  };
  EXPECT_TRUE(verdict(2, std::chrono::milliseconds(3)).good);
  EXPECT_FALSE(verdict(20, std::chrono::milliseconds(3)).good);
  EXPECT_FALSE(verdict(1, std::chrono::milliseconds(20)).good);
  EXPECT_THAT(verdict(1, std::chrono::milliseconds(20)).text, HasSubstr("20 ms late"));
}

TEST(EvaluateTest, IsContentWithTheShareOfAWellSetUpWorkstation) {
  const JitterVerdict verdict = Evaluate(Figures(20000, 82, 2));  // 0.41 %
  EXPECT_TRUE(verdict.good);
  EXPECT_THAT(verdict.text, HasSubstr("about 41 of 10 000 cycles"));
}

TEST(EvaluateTest, CallsWhatTheReferenceGeneratorBridgesUsable) {
  const JitterVerdict verdict = Evaluate(Figures(2000, 44, 3));  // 2.2 %
  EXPECT_FALSE(verdict.good);
  EXPECT_THAT(verdict.text,
              HasSubstr("usable: about 220 of 10 000 cycles would be missed (44 of 2000 "
                        "were, at most 3 in a row)"));
}

TEST(EvaluateTest, CallsWhatEndsMotionsNotFit) {
  EXPECT_THAT(Evaluate(Figures(2000, 120, 2)).text, HasSubstr("not fit"));  // 6 %
  EXPECT_THAT(Evaluate(Figures(60000, 20, 20)).text,
              HasSubstr("not fit"));  // once, but 20 in a row
  EXPECT_THAT(Evaluate(Figures(60000, 20, 20)).text, HasSubstr("lockstep"));
  EXPECT_FALSE(Evaluate(Figures(60000, 20, 20)).good);
  EXPECT_TRUE(Evaluate(Figures(60000, 20, 19)).good);
}

TEST(EvaluateTest, NeverCallsALossNone) {
  EXPECT_THAT(Evaluate(Figures(60000, 1, 1)).text, HasSubstr("about 1 of 10 000"));
}

TEST(JitterCuresTest, NameOnlyWhatThisHostLacks) {
  HostFacts facts;
  facts.processors = 8;
  facts.may_use_fifo = true;
  facts.realtime_kernel = true;
  facts.governor = "performance";
  for (const std::string& cure : JitterCures(facts)) {
    EXPECT_THAT(cure, Not(HasSubstr("SCHED_FIFO")));
    EXPECT_THAT(cure, Not(HasSubstr("PREEMPT_RT")));
    EXPECT_THAT(cure, Not(HasSubstr("governor")));
    EXPECT_THAT(cure, Not(HasSubstr("virtual")));
    EXPECT_THAT(cure, Not(HasSubstr("stop other programs")));
  }
  facts.may_use_fifo = false;
  facts.realtime_kernel = false;
  facts.governor = "powersave";
  facts.virtual_machine = true;
  facts.load = 5.25;
  const auto cures = JitterCures(facts);
  EXPECT_THAT(cures.front(), HasSubstr("SCHED_FIFO"));
  EXPECT_THAT(cures, Contains(HasSubstr("5.2 threads wanted the 8 processors")));
  EXPECT_THAT(cures, Contains(HasSubstr("\"powersave\"")));
  EXPECT_THAT(cures, Contains(HasSubstr("linux-image-rt-amd64")));
  EXPECT_THAT(cures, Contains(HasSubstr("virtual machine")));
}

TEST(MeasureJitterTest, CountsEveryMillisecondOnceWhateverTheMachineDoes) {
  const JitterFigures figures = MeasureJitter(std::chrono::milliseconds(200));
  EXPECT_GE(figures.cycles, 198u);
  EXPECT_LE(figures.unserved, figures.cycles);
  EXPECT_LE(figures.longest_loss, figures.unserved);
  EXPECT_LE(figures.answer.count(), figures.cycles);
  EXPECT_LE(figures.wake_up.count(), 201u);
  EXPECT_GE(figures.wake_up.count(), 1u);
}

}  // namespace
}  // namespace twin::loop::loop_host_timing_test
