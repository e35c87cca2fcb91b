#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "fci/byte_packer.h"
#include "fci/random_messages.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/requests.h"

namespace twin::fci::fci_requests_test {
namespace {

using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The frame that `bytes` are. @post `bytes` holds its payload.
Frame FrameOf(HeadKind kind, const Bytes& bytes) {
  const std::size_t head = kind == HeadKind::kArm ? 12 : 10;
  const auto number = [&bytes](std::size_t at, std::size_t count) {
    std::uint32_t value = 0;
    while (count-- > 0) value = 256 * value + static_cast<std::uint32_t>(bytes.at(at + count));
    return value;
  };
  Frame frame;
  frame.head.command = number(0, kind == HeadKind::kArm ? 4 : 2);
  frame.head.command_id = number(kind == HeadKind::kArm ? 4 : 2, 4);
  frame.head.size = number(kind == HeadKind::kArm ? 8 : 6, 4);
  frame.payload = std::span(bytes).subspan(head);
  EXPECT_EQ(frame.head.size, bytes.size());
  return frame;
}

Frame BareFrame(std::uint32_t command, const Bytes& payload) {
  return {{command, 1, static_cast<std::uint32_t>(payload.size())}, payload};
}

BytePacker ArmHead(std::uint32_t command, std::uint32_t id, std::uint32_t payload) {
  return BytePacker().Put(command).Put(id).Put(12 + payload);
}
BytePacker HandHead(std::uint16_t command, std::uint32_t id, std::uint32_t payload) {
  return BytePacker().Put(command).Put(id).Put(10 + payload);
}

template <typename Wanted, typename Answer>
Wanted Take(const std::variant<Answer, BadFrame>& parsed) {
  if (const auto* bad = std::get_if<BadFrame>(&parsed)) {
    ADD_FAILURE() << bad->what;
    return {};
  }
  const Answer& whole = std::get<Answer>(parsed);
  if constexpr (std::is_same_v<Wanted, Answer>) {
    return whole;
  } else {
    EXPECT_TRUE(std::holds_alternative<Wanted>(whole));
    return std::holds_alternative<Wanted>(whole) ? std::get<Wanted>(whole) : Wanted();
  }
}

template <typename Answer>
std::string WhatIsBad(const std::variant<Answer, BadFrame>& parsed) {
  const auto* bad = std::get_if<BadFrame>(&parsed);
  return bad == nullptr ? "nothing" : bad->what;
}

struct ArmExample {
  const char* name;
  ArmRequest request;
  Bytes frame;
};

/// Every request of the arm with random values, and its frame put together from the published
/// layout.
std::vector<ArmExample> ArmExamples(std::uint64_t seed) {
  RandomMessages random(seed);
  std::uint32_t id = 0;
  random.Fill(id);
  std::vector<ArmExample> all;
  const auto add = [&all](const char* name, const ArmRequest& request, const BytePacker& packer) {
    all.push_back({name, request, packer.bytes()});
  };
  Connect connect;
  random.Fill(connect.version, connect.udp_port);
  add("Connect", connect, ArmHead(0, id, 4).Put(connect.version).Put(connect.udp_port));

  Move move;
  const std::uint32_t controller = random.Below(3);
  const std::uint32_t generator = random.Below(4);
  move.modes = {static_cast<ControllerMode>(controller),
                static_cast<MotionGeneratorMode>(generator + 1)};
  Deviation& path = move.maximum_path_deviation;
  Deviation& goal = move.maximum_goal_pose_deviation;
  random.Fill(path.translation, path.rotation, path.elbow);
  random.Fill(goal.translation, goal.rotation, goal.elbow);
  BytePacker packer = ArmHead(1, id, 56).Put(controller).Put(generator);
  packer.Put(path.translation).Put(path.rotation).Put(path.elbow);
  add("Move", move, packer.Put(goal.translation).Put(goal.rotation).Put(goal.elbow));
  add("Stop Move", StopMove(), ArmHead(2, id, 0));

  GetCartesianLimit limit;
  random.Fill(limit.id);
  add("Get Cartesian Limit", limit, ArmHead(3, id, 4).Put(limit.id));

  setting::CollisionBehavior b;
  random.Fill(b.lower_torque_acc, b.upper_torque_acc, b.lower_torque_nominal);
  random.Fill(b.upper_torque_nominal, b.lower_force_acc, b.upper_force_acc);
  random.Fill(b.lower_force_nominal, b.upper_force_nominal);
  packer = ArmHead(4, id, 416).Put(b.lower_torque_acc).Put(b.upper_torque_acc);
  packer.Put(b.lower_torque_nominal).Put(b.upper_torque_nominal);
  packer.Put(b.lower_force_acc).Put(b.upper_force_acc);
  packer.Put(b.lower_force_nominal).Put(b.upper_force_nominal);
  add("Set Collision Behavior", Setting(b), packer);

  setting::JointImpedance joint;
  random.Fill(joint.K_theta);
  add("Set Joint Impedance", Setting(joint), ArmHead(5, id, 56).Put(joint.K_theta));
  setting::CartesianImpedance cartesian;
  random.Fill(cartesian.K_x);
  add("Set Cartesian Impedance", Setting(cartesian), ArmHead(6, id, 48).Put(cartesian.K_x));
  setting::GuidingMode guiding;
  random.Fill(guiding.axes, guiding.elbow);
  add("Set Guiding Mode", Setting(guiding), ArmHead(7, id, 7).Put(guiding.axes).Put(guiding.elbow));
  setting::StiffnessFrame K;
  random.Fill(K.EE_T_K);
  add("Set EE to K", Setting(K), ArmHead(8, id, 128).Put(K.EE_T_K));
  setting::EndEffectorFrame EE;
  random.Fill(EE.NE_T_EE);
  add("Set NE to EE", Setting(EE), ArmHead(9, id, 128).Put(EE.NE_T_EE));
  setting::Load load;
  random.Fill(load.m_load, load.F_x_Cload, load.I_load);
  add("Set Load", Setting(load),
      ArmHead(10, id, 104).Put(load.m_load).Put(load.F_x_Cload).Put(load.I_load));
  setting::Filters f;
  random.Fill(f.joint_position_hz, f.joint_velocity_hz, f.cartesian_position_hz,
              f.cartesian_velocity_hz, f.controller_hz);
  packer = ArmHead(11, id, 40).Put(f.joint_position_hz).Put(f.joint_velocity_hz);
  packer.Put(f.cartesian_position_hz).Put(f.cartesian_velocity_hz).Put(f.controller_hz);
  add("Set Filters", Setting(f), packer);
  add("Automatic Error Recovery", AutomaticErrorRecovery(), ArmHead(12, id, 0));
  LoadModelLibrary machine{static_cast<Architecture>(random.Below(4)),
                           static_cast<OperatingSystem>(random.Below(2))};
  add("Load Model Library", machine,
      ArmHead(13, id, 2).Put(machine.architecture).Put(machine.system));
  return all;
}

struct HandExample {
  const char* name;
  HandRequest request;
  Bytes frame;
};

std::vector<HandExample> HandExamples(std::uint64_t seed) {
  RandomMessages random(seed);
  std::uint32_t id = 0;
  Connect connect;
  hand::Grasp g;
  hand::Move move;
  random.Fill(id, connect.version, connect.udp_port, g.width, g.speed, g.force, g.epsilon_inner,
              g.epsilon_outer, move.width, move.speed);
  BytePacker grasp = HandHead(2, id, 40).Put(g.width).Put(g.epsilon_inner).Put(g.epsilon_outer);
  grasp.Put(g.speed).Put(g.force);
  return {
      {"Connect", connect, HandHead(0, id, 4).Put(connect.version).Put(connect.udp_port).bytes()},
      {"Homing", HandCommand(hand::Homing()), HandHead(1, id, 0).bytes()},
      {"Grasp", HandCommand(g), grasp.bytes()},
      {"Move", HandCommand(move), HandHead(3, id, 16).Put(move.width).Put(move.speed).bytes()},
      {"Stop", HandCommand(hand::Stop()), HandHead(4, id, 0).bytes()},
  };
}

TEST(ArmRequestTest, IsEncodedAsPublished) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (const ArmExample& one : ArmExamples(seed)) {
      const std::uint32_t id = FrameOf(HeadKind::kArm, one.frame).head.command_id;
      ASSERT_EQ(EncodeRequest(id, one.request), one.frame) << one.name << ", seed " << seed;
    }
  }
}

TEST(ArmRequestTest, ComesBackAsItWas) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (const ArmExample& one : ArmExamples(seed)) {
      const Frame frame = FrameOf(HeadKind::kArm, one.frame);
      const auto request = Take<ArmRequest>(ParseArmRequest(frame));
      ASSERT_EQ(request.index(), one.request.index()) << one.name;
      // Encoding, which the case above compares with the published bytes, tells every value apart.
      ASSERT_EQ(EncodeRequest(frame.head.command_id, request), one.frame)
          << one.name << ", seed " << seed;
    }
  }
}

TEST(ArmRequestTest, IsRefusedWithAnySizeButItsOwn) {
  for (const ArmExample& one : ArmExamples(1)) {
    const Frame whole = FrameOf(HeadKind::kArm, one.frame);
    for (std::size_t size = 0; size < 430; ++size) {
      if (size == whole.payload.size()) continue;
      Bytes payload = ToBytes(whole.payload);
      payload.resize(size);
      const std::string what = WhatIsBad(ParseArmRequest(BareFrame(whole.head.command, payload)));
      ASSERT_EQ(what, std::string(one.name) + ": " + std::to_string(size) + " bytes of payload, " +
                          std::to_string(whole.payload.size()) + " are needed");
    }
  }
}

TEST(ArmRequestTest, IsRefusedWithACommandThatDoesNotExist) {
  for (const std::uint32_t command :
       {kArmCommands, kArmCommands + 1, 255U, 256U, 65536U, 0xFFFFFFFFU}) {
    const std::string what = WhatIsBad(ParseArmRequest(BareFrame(command, {})));
    EXPECT_THAT(what, HasSubstr("command " + std::to_string(command)));
    EXPECT_THAT(what, HasSubstr("0 to " + std::to_string(kArmCommands - 1)));
  }
}

TEST(ArmRequestTest, HasNoGuidingFlagsButZeroAndOne) {
  for (std::size_t i = 0; i < 7; ++i) {
    for (int flag = 0; flag < 256; ++flag) {
      Bytes payload(7, std::byte{1});
      payload[i] = static_cast<std::byte>(flag);
      const std::string what = WhatIsBad(ParseArmRequest(BareFrame(7, payload)));
      ASSERT_EQ(what, flag <= 1 ? "nothing" : "Set Guiding Mode: a flag is neither 0 nor 1");
    }
  }
}

TEST(ArmRequestTest, IsReadWithModesNoMotionHasWhenTheirNumbersDoNotExist) {
  const std::uint32_t numbers[] = {0, 1, 2, 3, 4, 5, 255, 256, 0x7FFFFFFF, 0xFFFFFFFF};
  for (const std::uint32_t controller : numbers) {
    for (const std::uint32_t generator : numbers) {
      BytePacker payload;
      payload.Put(controller).Put(generator).Put(std::array<double, 6>{});
      const Move move =
          std::get<Move>(Take<ArmRequest>(ParseArmRequest(BareFrame(1, payload.bytes()))));
      EXPECT_EQ(move.modes.controller,
                controller < 3 ? static_cast<ControllerMode>(controller) : ControllerMode::kOther);
      EXPECT_EQ(move.modes.generator, generator < 4
                                          ? static_cast<MotionGeneratorMode>(generator + 1)
                                          : MotionGeneratorMode::kIdle);
    }
  }
}

TEST(ArmRequestTest, HandsModesNoMotionHasOnAsSuch) {
  Move move;
  move.modes = {ControllerMode::kOther, MotionGeneratorMode::kIdle};
  const Bytes frame = EncodeRequest(1, ArmRequest(move));
  const Move back =
      std::get<Move>(Take<ArmRequest>(ParseArmRequest(FrameOf(HeadKind::kArm, frame))));
  EXPECT_EQ(back.modes.controller, ControllerMode::kOther);
  EXPECT_EQ(back.modes.generator, MotionGeneratorMode::kIdle);
}

TEST(ArmRequestTest, HandsOnWhatTheRobotHasToRefuse) {
  setting::JointImpedance stiffness;
  stiffness.K_theta[6] = kNaN;
  const Bytes frame = EncodeRequest(1, ArmRequest(Setting(stiffness)));
  const auto request = Take<ArmRequest>(ParseArmRequest(FrameOf(HeadKind::kArm, frame)));
  EXPECT_TRUE(FindBadValue(std::get<Setting>(request)).has_value());

  const auto machine = std::get<LoadModelLibrary>(
      Take<ArmRequest>(ParseArmRequest(BareFrame(13, {std::byte{9}, std::byte{7}}))));
  EXPECT_EQ(static_cast<int>(machine.architecture), 9);
  EXPECT_EQ(static_cast<int>(machine.system), 7);
}

TEST(HandRequestTest, IsEncodedAsPublished) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (const HandExample& one : HandExamples(seed)) {
      const std::uint32_t id = FrameOf(HeadKind::kHand, one.frame).head.command_id;
      ASSERT_EQ(EncodeRequest(id, one.request), one.frame) << one.name << ", seed " << seed;
    }
  }
}

TEST(HandRequestTest, ComesBackAsItWas) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (const HandExample& one : HandExamples(seed)) {
      const Frame frame = FrameOf(HeadKind::kHand, one.frame);
      const auto request = Take<HandRequest>(ParseHandRequest(frame));
      ASSERT_EQ(EncodeRequest(frame.head.command_id, request), one.frame)
          << one.name << ", seed " << seed;
    }
  }
}

TEST(HandRequestTest, IsRefusedWithAnySizeButItsOwn) {
  for (const HandExample& one : HandExamples(1)) {
    const Frame whole = FrameOf(HeadKind::kHand, one.frame);
    for (std::size_t size = 0; size < 60; ++size) {
      if (size == whole.payload.size()) continue;
      Bytes payload = ToBytes(whole.payload);
      payload.resize(size);
      const std::string what = WhatIsBad(ParseHandRequest(BareFrame(whole.head.command, payload)));
      ASSERT_THAT(what, HasSubstr(one.name));
      ASSERT_THAT(what, HasSubstr(std::to_string(size) + " bytes"));
    }
  }
}

TEST(HandRequestTest, IsRefusedWithACommandThatDoesNotExist) {
  for (const std::uint32_t command : {5U, 6U, 255U, 65535U, 65536U, 0xFFFFFFFFU}) {
    const std::string what = WhatIsBad(ParseHandRequest(BareFrame(command, {})));
    EXPECT_THAT(what, HasSubstr("command " + std::to_string(command)));
    EXPECT_THAT(what, HasSubstr("0 to 4"));
  }
}

std::vector<HandExample> VacuumExamples(std::uint64_t seed) {
  RandomMessages random(seed);
  std::uint32_t id = 0;
  Connect connect;
  hand::Vacuum v;
  hand::DropOff d;
  random.Fill(id, connect.version, connect.udp_port, v.vacuum, v.profile, v.timeout_ms,
              d.timeout_ms);
  BytePacker vacuum = HandHead(1, id, 10).Put(v.vacuum).Put(v.profile).Put(v.timeout_ms);
  return {
      {"Connect", connect, HandHead(0, id, 4).Put(connect.version).Put(connect.udp_port).bytes()},
      {"Vacuum", HandCommand(v), vacuum.bytes()},
      {"Drop Off", HandCommand(d), HandHead(2, id, 8).Put(d.timeout_ms).bytes()},
      {"Stop", HandCommand(hand::Stop()), HandHead(3, id, 0).bytes()},
  };
}

TEST(VacuumRequestTest, IsEncodedAsPublishedAndComesBackAsItWas) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (const HandExample& one : VacuumExamples(seed)) {
      const Frame frame = FrameOf(HeadKind::kHand, one.frame);
      const std::uint32_t id = frame.head.command_id;
      ASSERT_EQ(EncodeVacuumRequest(id, one.request), one.frame) << one.name << ", seed " << seed;
      const auto request = Take<HandRequest>(ParseVacuumRequest(frame));
      ASSERT_EQ(EncodeVacuumRequest(id, request), one.frame) << one.name << ", seed " << seed;
    }
  }
}

TEST(VacuumRequestTest, IsRefusedWithAnySizeButItsOwnAndWithAnUnknownCommand) {
  for (const HandExample& one : VacuumExamples(1)) {
    const Frame whole = FrameOf(HeadKind::kHand, one.frame);
    for (std::size_t size = 0; size < 30; ++size) {
      if (size == whole.payload.size()) continue;
      Bytes payload = ToBytes(whole.payload);
      payload.resize(size);
      const Frame bare = BareFrame(whole.head.command, payload);
      ASSERT_THAT(WhatIsBad(ParseVacuumRequest(bare)), HasSubstr(one.name));
    }
  }
  for (const std::uint32_t command : {4U, 5U, 255U, 65535U, 0xFFFFFFFFU}) {
    EXPECT_THAT(WhatIsBad(ParseVacuumRequest(BareFrame(command, {}))),
                HasSubstr("none of the vacuum gripper's, which are 0 to 3"));
  }
}

TEST(RequestNameTest, IsWhatClientsPrint) {
  for (const ArmExample& one : ArmExamples(1)) {
    const auto command = FrameOf(HeadKind::kArm, one.frame).head.command;
    EXPECT_EQ(Name(static_cast<ArmCommand>(command)), one.name);
    if (const auto* setting = std::get_if<Setting>(&one.request)) {
      EXPECT_EQ(twin::Name(*setting), one.name);
    }
  }
  for (const HandExample& one : HandExamples(1)) {
    const auto command = FrameOf(HeadKind::kHand, one.frame).head.command;
    EXPECT_EQ(Name(static_cast<HandCommandId>(command)), one.name);
  }
  for (const HandExample& one : VacuumExamples(1)) {
    const auto command = FrameOf(HeadKind::kHand, one.frame).head.command;
    EXPECT_EQ(Name(static_cast<VacuumCommandId>(command)), one.name);
  }
  EXPECT_EQ(Name(static_cast<VacuumCommandId>(kVacuumCommands)), "unknown");
  EXPECT_EQ(Name(static_cast<ArmCommand>(kArmCommands + 1)), "unknown");
  EXPECT_EQ(Name(static_cast<HandCommandId>(kHandCommands)), "unknown");
}

}  // namespace
}  // namespace twin::fci::fci_requests_test
