#include "twin/teleop/device_registry.h"

#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::teleop::teleop_device_registry_test {
namespace {

std::unique_ptr<Device> MakeNone(const DeviceRequest& /*request*/) {
  return nullptr;
}

TEST(DeviceRegistryTest, NamesWhatItKnowsInOrder) {
  DeviceRegistry registry;
  registry.Add("stick", &MakeNone);
  registry.Add("page", &MakeNone);
  EXPECT_EQ(registry.Names(), (std::vector<std::string>{"stick", "page"}));
}

TEST(DeviceRegistryTest, RefusesAnUnknownNameAndListsThoseThereAre) {
  DeviceRegistry registry;
  registry.Add("stick", &MakeNone);
  try {
    static_cast<void>(registry.Find("mouse"));
    FAIL() << "an unknown device was found";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("\"mouse\" is unknown; there are: stick"));
  }
}

}  // namespace
}  // namespace twin::teleop::teleop_device_registry_test
