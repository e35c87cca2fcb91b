// What every device must keep, whatever it is.

#include <memory>
#include <ostream>

#include <gtest/gtest.h>

#include "devices/device_rig.h"
#include "support/realtime_guard.h"

namespace twin::devices::devices_contract_test {
namespace {

struct Case {
  const char* name;
  std::unique_ptr<DeviceRig> (*make)();
};

void PrintTo(const Case& one, std::ostream* out) {
  *out << one.name;
}

class DeviceContractTest : public testing::TestWithParam<Case> {
 protected:
  std::unique_ptr<DeviceRig> rig_ = GetParam().make();
};

TEST_P(DeviceContractTest, IsNotLostAtFirst) {
  EXPECT_FALSE(rig_->device().lost());
}

TEST_P(DeviceContractTest, TellsWhatTheHandsDo) {
  static_cast<void>(rig_->Await());
  rig_->Act();
  const teleop::OperatorSample sample = rig_->AwaitPresses(1);
  EXPECT_EQ(sample.axes, (Vector6{0.5, 0, 0, 0, 0, 0}));
}

TEST_P(DeviceContractTest, CountsItsSamplesFromOneUp) {
  teleop::OperatorSample before = rig_->Await();
  EXPECT_GE(before.sequence, 1u);
  rig_->Act();
  while (before.gripper_presses == 0) {
    const teleop::OperatorSample next = rig_->Await();
    EXPECT_GT(next.sequence, before.sequence);
    before = next;
  }
}

TEST_P(DeviceContractTest, GivesNoSampleTwice) {
  const teleop::OperatorSample sample = rig_->Await();
  if (const auto next = rig_->Read()) {
    EXPECT_GT(next->sequence, sample.sequence);
  }
}

TEST_P(DeviceContractTest, StaysLost) {
  static_cast<void>(rig_->Await());
  rig_->Act();
  static_cast<void>(rig_->AwaitPresses(1));
  rig_->Go();
  rig_->AwaitLoss();
  for (int i = 0; i < 100; ++i) static_cast<void>(rig_->Read());
  EXPECT_TRUE(rig_->device().lost());
}

TEST_P(DeviceContractTest, GivesNothingOnceItIsLost) {
  static_cast<void>(rig_->Await());
  rig_->Act();
  static_cast<void>(rig_->AwaitPresses(1));
  rig_->Go();
  rig_->AwaitLoss();
  static_cast<void>(rig_->Read());  // one may have been on its way
  EXPECT_FALSE(rig_->Read().has_value());
}

TEST_P(DeviceContractTest, FeelsAndReadsWithoutAllocatingOrLocking) {
  static_cast<void>(rig_->Await());
  rig_->Act();
  teleop::OperatorFeedback feedback;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    static_cast<void>(rig_->Read());
    ++feedback.sequence;
    feedback.wrench[0] = 0.01 * i;
    rig_->device().Feel(feedback);
    static_cast<void>(rig_->device().lost());
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

TEST_P(DeviceContractTest, SaysWhatItIs) {
  EXPECT_FALSE(rig_->device().Describe().empty());
}

INSTANTIATE_TEST_SUITE_P(Devices, DeviceContractTest,
                         testing::Values(Case{"evdev", &MakeEvdevRig},
                                         Case{"network", &MakeNetworkRig},
                                         Case{"script", &MakeScriptRig},
                                         Case{"recorded", &MakeRecordedRig}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace twin::devices::devices_contract_test
