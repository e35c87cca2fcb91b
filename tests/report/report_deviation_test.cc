#include "twin/report/deviation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "record/temporary_folder.h"
#include "report/end_samples.h"
#include "twin/core/error.h"

namespace twin::report {
namespace {

using record::TemporaryFolder;

/// A motion whose arm follows a share of its target.
void Follow(SampleMotion& motion, double share, int cycles) {
  for (int i = 0; i < cycles; ++i) {
    rt::TickRecord tick;
    tick.q_ext = motion.state().q;
    tick.q_ext[SampleMotion::kJoint] = SampleMotion::Planned(motion.k() + 1);
    motion.AnswerWith(tick);
    motion.state().q[SampleMotion::kJoint] = share * tick.q_ext[SampleMotion::kJoint];
    motion.Lose(1, false);
  }
}

TEST(MeasureDeviationTest, FindsHowFarTheArmIsOffItsTarget) {
  const TemporaryFolder folder;
  SampleMotion motion(folder / "a.mcap");
  constexpr int kCycles = 1047;  // the whole half-wave: 0.4 rad at t = pi / 3
  Follow(motion, 0.7, kCycles);
  const auto deviation = MeasureDeviation(motion.Finish());
  ASSERT_TRUE(deviation);
  double squares = 0;
  for (std::uint64_t k = 1; k <= kCycles; ++k) {
    squares += std::pow(0.3 * SampleMotion::Planned(k), 2);
  }
  EXPECT_NEAR(deviation->largest, 0.3 * 0.4, 1e-6);
  EXPECT_EQ(deviation->joint, SampleMotion::kJoint);
  EXPECT_NEAR(deviation->at, 1.047, 1e-9);
  EXPECT_NEAR(deviation->rms, std::sqrt(squares / kCycles), 1e-9);
}

TEST(MeasureDeviationTest, AnArmOnItsTargetHasNone) {
  const TemporaryFolder folder;
  SampleMotion motion(folder / "a.mcap");
  motion.Serve(200);
  EXPECT_EQ(MeasureDeviation(motion.Finish())->largest, 0);
}

TEST(MeasureDeviationTest, WithoutTargetsThereIsNothingToMeasure) {
  const TemporaryFolder folder;
  SampleMotion motion(folder / "a.mcap");
  motion.Lose(10, false);
  EXPECT_FALSE(MeasureDeviation(motion.Finish()));
  EXPECT_THROW(static_cast<void>(MeasureDeviation(folder / "none.mcap")), InputError);
}

}  // namespace
}  // namespace twin::report
