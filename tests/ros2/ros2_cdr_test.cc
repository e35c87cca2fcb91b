#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fuzz/mutations.h"
#include "plugins/ros2/cdr.h"
#include "plugins/ros2/type_description.h"
#include "ros2/filled.h"
#include "twin/core/random.h"

namespace twin::ros2::ros2_cdr_test {
namespace {

std::vector<std::byte> Bytes(const std::vector<int>& values) {
  std::vector<std::byte> bytes;
  bytes.reserve(values.size());
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

/// Of all fields, a message's bytes tell each.
template <Message M>
bool IsReadBack(const M& message) {
  const std::vector<std::byte> bytes = ToBytes(message);
  const std::optional<M> read = FromBytes<M>(bytes);
  return read && ToBytes(*read) == bytes;
}

TEST(Ros2Cdr, AlignsFieldsFromTheEncapsulation) {
  msg::Header header;
  header.stamp = {.sec = -2, .nanosec = 3};
  header.frame_id = "ab";
  EXPECT_EQ(ToBytes(header), Bytes({0, 1, 0, 0, 0xFE, 0xFF, 0xFF, 0xFF, 3, 0, 0, 0,  //
                                    3, 0, 0, 0, 'a', 'b', 0}));
  msg::JointState state;
  state.name = {"panda"};
  state.position = {1.0};
  EXPECT_EQ(ToBytes(state), Bytes({0,   1,   0,   0,   0,   0, 0,    0,    0, 0, 0, 0,  // stamp
                                   1,   0,   0,   0,   0,   0, 0,    0,                 // frame_id
                                   1,   0,   0,   0,   6,   0, 0,    0,                 // name
                                   'p', 'a', 'n', 'd', 'a', 0, 0,    0,                 //
                                   1,   0,   0,   0,   0,   0, 0,    0,     // position, at 40
                                   0,   0,   0,   0,   0,   0, 0xF0, 0x3F,  //
                                   0,   0,   0,   0,   0,   0, 0,    0}));  // velocity, effort
}

TEST(Ros2Cdr, ReadsBackEachMessage) {
  ForEachMessageOfAll([]<typename M>() {
    EXPECT_TRUE(IsReadBack(M())) << NameOf<M>();
    EXPECT_TRUE(IsReadBack(Filled<M>())) << NameOf<M>();
  });
}

TEST(Ros2Cdr, RefusesAMessageThatIsCutAnywhere) {
  ForEachMessageOfAll([]<typename M>() {
    const std::vector<std::byte> bytes = ToBytes(Filled<M>());
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(FromBytes<M>(std::span(bytes).first(size))) << NameOf<M>() << " of " << size;
    }
  });
}

TEST(Ros2Cdr, RefusesOtherEncodings) {
  std::vector<std::byte> bytes = ToBytes(msg::Time());
  ASSERT_TRUE(FromBytes<msg::Time>(bytes));
  bytes[1] = std::byte{0};  // big endian
  EXPECT_FALSE(FromBytes<msg::Time>(bytes));
  bytes[1] = std::byte{7};  // XCDR2
  EXPECT_FALSE(FromBytes<msg::Time>(bytes));
}

TEST(Ros2Cdr, RefusesCountsThatTheBytesCannotHold) {
  for (const int high : {0x01, 0x7F, 0xFF}) {
    EXPECT_FALSE(FromBytes<msg::String>(Bytes({0, 1, 0, 0, 0xFF, 0xFF, 0xFF, high, 'a', 0})));
    EXPECT_FALSE(FromBytes<msg::TFMessage>(Bytes({0, 1, 0, 0, 0xFF, 0xFF, 0xFF, high, 0, 0})));
  }
}

TEST(Ros2Cdr, ReadsBothKindsOfEmptyStringAndNoneWithoutItsEnd) {
  for (const auto& bytes : {Bytes({0, 1, 0, 0, 0, 0, 0, 0}), Bytes({0, 1, 0, 0, 1, 0, 0, 0, 0})}) {
    const std::optional<msg::String> read = FromBytes<msg::String>(bytes);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->data, "");
  }
  EXPECT_FALSE(FromBytes<msg::String>(Bytes({0, 1, 0, 0, 2, 0, 0, 0, 'a', 'b'})));
}

TEST(Ros2Cdr, RefusesAStringBeyondItsBound) {
  msg::NodeEntitiesInfo node;
  node.node_name.text = std::string(256, 'n');
  EXPECT_TRUE(FromBytes<msg::NodeEntitiesInfo>(ToBytes(node)));
  node.node_name.text += 'n';
  EXPECT_FALSE(FromBytes<msg::NodeEntitiesInfo>(ToBytes(node)));
}

TEST(Ros2Cdr, TheGraphOfHumbleHasLongerIdentities) {
  const msg::ParticipantEntitiesInfoOf<24> info;
  EXPECT_EQ(ToBytes(info).size(), ToBytes(msg::ParticipantEntitiesInfo()).size() + 8);
  EXPECT_TRUE(IsReadBack(info));
}

TEST(Ros2Cdr, WhatIsReadOfMutatedBytesIsReadBack) {
  const Random random(7, RandomStream::kTest);
  ForEachMessageOfAll([&]<typename M>() {
    const std::vector<std::byte> whole = ToBytes(Filled<M>());
    int read_count = 0;
    for (std::uint64_t round = 0; round < 2000; ++round) {
      std::vector<std::byte> bytes = whole;
      fci::fuzz::Mutate(bytes, random, round);
      const std::optional<M> read = FromBytes<M>(bytes);
      if (!read) continue;
      ++read_count;
      EXPECT_TRUE(IsReadBack(*read)) << NameOf<M>() << ", round " << round;
    }
    EXPECT_GT(read_count, 0) << NameOf<M>();
    EXPECT_LT(read_count, 2000) << NameOf<M>();
  });
}

TEST(Ros2TypeDescription, HashesAsRosDoes) {
  EXPECT_EQ(Describe<msg::JointState>().Hash(),
            "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e");
  EXPECT_EQ(Describe<msg::JointTolerance>().Hash(),
            "RIHS01_c254f9cece0f3b733017b6990fd46d1326e25242d6b8844398c97d9a88e7d648");
  EXPECT_EQ(Describe<msg::EntityFilters>().Hash(),
            "RIHS01_8e7b12e8ea062f14c55de4877221fe1b7cd9749665a7ad8a4ab855fc4b148303");
  EXPECT_EQ(Describe<msg::EntityState>().Hash(),
            "RIHS01_2e0464a85eb80a939025075d6c20761eca6a4cb9d6baf2c0ba373467c8b598d0");
  EXPECT_EQ(Describe<msg::SimulatorFeatures>().Hash(),
            "RIHS01_8b101c8529bc0ea3dcf056078254768f39832b9ef0adaf93bd5cea96c0de3305");
  EXPECT_EQ(Describe<msg::SimulationState>().Hash(),
            "RIHS01_bb9f87ccdd98fba113052a512d9801e84ce732d0a2b3c2b0cb281828de36e415");
  EXPECT_EQ(Describe<msg::StepSimulation::Response>().Hash(),
            "RIHS01_5b4acf2d0ce7c3fc125d0bef2acb9b5a81377e80db6b696b81beeffb9824fb5c");
  EXPECT_EQ(Describe<msg::StepSimulation::Request>().Hash(),
            "RIHS01_cda33f6887815f3dce0f90e61fd8efd39bda13ae264ddede15c33fbad890630e");
  EXPECT_EQ(Describe<msg::SetForceTorqueCollisionBehavior::Request>().Hash(),
            "RIHS01_9a07d7d351f955c2f9587d398effcdedc93888c8093051a05d8f14d8d1d9021d");
}

TEST(Ros2TypeDescription, NamesTypesAsTheWireDoes) {
  EXPECT_EQ(DdsName(msg::JointState::kName), "sensor_msgs::msg::dds_::JointState_");
}

}  // namespace
}  // namespace twin::ros2::ros2_cdr_test
