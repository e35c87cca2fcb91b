#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "fci/byte_packer.h"
#include "fci/datagram_fields.h"
#include "fci/random_messages.h"
#include "support/realtime_guard.h"
#include "twin/fci/datagrams.h"

namespace twin::fci::fci_datagrams_test {
namespace {

constexpr std::uint64_t kSeeds = 200;

/// A datagram put together from the published table, field by field, each with name and offset.
struct Table {
  BytePacker packer;
  std::vector<std::pair<std::string, std::size_t>> rows;

  template <typename T>
  Table& Row(const char* name, std::size_t offset, const T& value) {
    EXPECT_EQ(packer.size(), offset) << name;
    rows.emplace_back(name, offset);
    packer.Put(value);
    return *this;
  }
};

Table TableOf(const RobotState& s) {
  Table table;
  table.Row("message_id", 0, s.message_id).Row("O_T_EE", 8, s.O_T_EE);
  table.Row("O_T_EE_d", 136, s.O_T_EE_d).Row("F_T_EE", 264, s.F_T_EE);
  table.Row("EE_T_K", 392, s.EE_T_K).Row("F_T_NE", 520, s.F_T_NE);
  table.Row("NE_T_EE", 648, s.NE_T_EE).Row("m_ee", 776, s.m_ee).Row("I_ee", 784, s.I_ee);
  table.Row("F_x_Cee", 856, s.F_x_Cee).Row("m_load", 880, s.m_load).Row("I_load", 888, s.I_load);
  table.Row("F_x_Cload", 960, s.F_x_Cload).Row("elbow", 984, s.elbow);
  table.Row("elbow_d", 1000, s.elbow_d).Row("tau_J", 1016, s.tau_J);
  table.Row("tau_J_d", 1072, s.tau_J_d).Row("dtau_J", 1128, s.dtau_J).Row("q", 1184, s.q);
  table.Row("q_d", 1240, s.q_d).Row("dq", 1296, s.dq).Row("dq_d", 1352, s.dq_d);
  table.Row("ddq_d", 1408, s.ddq_d).Row("joint_contact", 1464, s.joint_contact);
  table.Row("cartesian_contact", 1520, s.cartesian_contact);
  table.Row("joint_collision", 1568, s.joint_collision);
  table.Row("cartesian_collision", 1624, s.cartesian_collision);
  table.Row("tau_ext_hat_filtered", 1672, s.tau_ext_hat_filtered);
  table.Row("O_F_ext_hat_K", 1728, s.O_F_ext_hat_K).Row("K_F_ext_hat_K", 1776, s.K_F_ext_hat_K);
  table.Row("O_dP_EE_d", 1824, s.O_dP_EE_d).Row("O_ddP_O", 1872, s.O_ddP_O);
  table.Row("elbow_c", 1896, s.elbow_c).Row("delbow_c", 1912, s.delbow_c);
  table.Row("ddelbow_c", 1928, s.ddelbow_c).Row("O_T_EE_c", 1944, s.O_T_EE_c);
  table.Row("O_dP_EE_c", 2072, s.O_dP_EE_c).Row("O_ddP_EE_c", 2120, s.O_ddP_EE_c);
  table.Row("theta", 2168, s.theta).Row("dtheta", 2224, s.dtheta);
  table.Row("motion_generator_mode", 2280, s.motion_generator_mode);
  table.Row("controller_mode", 2281, s.controller_mode).Row("errors", 2282, s.errors);
  table.Row("reflex_reason", 2323, s.reflex_reason).Row("robot_mode", 2364, s.robot_mode);
  table.Row("control_command_success_rate", 2365, s.control_command_success_rate);
  return table;
}

Table TableOf(const RobotCommand& c) {
  Table table;
  table.Row("message_id", 0, c.message_id).Row("q_c", 8, c.q_c).Row("dq_c", 64, c.dq_c);
  table.Row("O_T_EE_c", 120, c.O_T_EE_c).Row("O_dP_EE_c", 248, c.O_dP_EE_c);
  table.Row("elbow_c", 296, c.elbow_c).Row("valid_elbow", 312, c.valid_elbow);
  table.Row("motion_generation_finished", 313, c.motion_generation_finished);
  table.Row("tau_J_d", 314, c.tau_J_d);
  return table;
}

Table TableOf(const HandState& s) {
  Table table;
  table.Row("message_id", 0, s.message_id).Row("width", 4, s.width);
  table.Row("max_width", 12, s.max_width).Row("is_grasped", 20, s.is_grasped);
  table.Row("temperature", 21, s.temperature);
  return table;
}

Table TableOf(const VacuumState& s) {
  Table table;
  table.Row("message_id", 0, s.message_id).Row("in_control_range", 4, s.in_control_range);
  table.Row("part_detached", 5, s.part_detached).Row("part_present", 6, s.part_present);
  table.Row("device_status", 7, s.device_status).Row("actual_power", 8, s.actual_power);
  table.Row("vacuum", 12, s.vacuum);
  return table;
}

template <typename Datagram>
Bytes Pack(const Datagram& datagram) {
  return TableOf(datagram).packer.bytes();
}

/// How to make and to encode each of the four.
struct StateKind {
  using Value = RobotState;
  using Encoded = StateBytes;
  static constexpr std::size_t kSize = 2373;
  static const auto& Fields() { return kStateFields; }
  static Value Make(RandomMessages& random) { return random.State(); }
};
struct CommandKind {
  using Value = RobotCommand;
  using Encoded = CommandBytes;
  static constexpr std::size_t kSize = 370;
  static const auto& Fields() { return kCommandFields; }
  static Value Make(RandomMessages& random) { return random.Command(); }
};
struct HandKind {
  using Value = HandState;
  using Encoded = HandStateBytes;
  static constexpr std::size_t kSize = 23;
  static const auto& Fields() { return kHandStateFields; }
  static Value Make(RandomMessages& random) { return random.Hand(); }
};
struct VacuumKind {
  using Value = VacuumState;
  using Encoded = VacuumStateBytes;
  static constexpr std::size_t kSize = 16;
  static const auto& Fields() { return kVacuumStateFields; }
  static Value Make(RandomMessages& random) { return random.Vacuum(); }
};

template <typename Kind>
class DatagramTest : public testing::Test {
 protected:
  static typename Kind::Value Sample(std::uint64_t seed) {
    RandomMessages random(seed);
    return Kind::Make(random);
  }
  static Bytes Encoded(const typename Kind::Value& value) {
    typename Kind::Encoded bytes;
    Encode(value, bytes);
    return ToBytes(bytes);
  }
  /// Decodes into a value that must stay as it was when there is a fault.
  static DatagramFault DecodeInto(const Bytes& bytes, typename Kind::Value& value) {
    const Bytes before = Pack(value);
    const DatagramFault fault = Decode(bytes, value);
    if (fault != DatagramFault::kNone) {
      EXPECT_EQ(Pack(value), before);
    }
    return fault;
  }
};
using Kinds = testing::Types<StateKind, CommandKind, HandKind, VacuumKind>;
TYPED_TEST_SUITE(DatagramTest, Kinds);

TYPED_TEST(DatagramTest, HasEveryFieldAtItsPlace) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto value = this->Sample(seed);
    ASSERT_EQ(this->Encoded(value), Pack(value)) << "seed " << seed;
  }
}

TYPED_TEST(DatagramTest, NamesAndPlacesItsFieldsAsPublished) {
  std::vector<std::pair<std::string, std::size_t>> rows;
  const auto add = [&](const auto& field) {
    if (field.offset != kAbsent) rows.emplace_back(field.name, field.offset);
  };
  std::apply([&](const auto&... field) { (add(field), ...); }, TypeParam::Fields());
  EXPECT_EQ(rows, TableOf(this->Sample(1)).rows);
}

TYPED_TEST(DatagramTest, ComesBackAsItWas) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Bytes bytes = Pack(this->Sample(seed));
    auto value = this->Sample(seed + 1);
    ASSERT_EQ(Decode(bytes, value), DatagramFault::kNone) << "seed " << seed;
    ASSERT_EQ(Pack(value), bytes) << "seed " << seed;
  }
}

TYPED_TEST(DatagramTest, IsRefusedWhenAnyByteIsMissing) {
  const Bytes whole = Pack(this->Sample(1));
  ASSERT_EQ(whole.size(), TypeParam::kSize);
  auto value = this->Sample(2);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    ASSERT_EQ(this->DecodeInto(cut, value), DatagramFault::kSize) << size;
  }
}

TYPED_TEST(DatagramTest, IsCutWhenItIsLonger) {
  const Bytes whole = Pack(this->Sample(1));
  Bytes longer = whole;
  longer.resize(whole.size() + 100, std::byte{0xFF});
  auto value = this->Sample(2);
  ASSERT_EQ(Decode(longer, value), DatagramFault::kNone);
  EXPECT_EQ(Pack(value), whole);
}

TYPED_TEST(DatagramTest, IsForRealTime) {
  const auto value = this->Sample(1);
  auto back = value;
  typename TypeParam::Encoded bytes{};
  int faults = 0;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    Encode(value, bytes);
    faults += Decode(bytes, back) == DatagramFault::kNone ? 0 : 1;
    faults +=
        Decode(std::span(bytes).first(i % bytes.size()), back) == DatagramFault::kSize ? 0 : 1;
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
  EXPECT_EQ(faults, 0);
}

using StateDatagramTest = DatagramTest<StateKind>;
using CommandDatagramTest = DatagramTest<CommandKind>;
using HandStateDatagramTest = DatagramTest<HandKind>;
using VacuumStateDatagramTest = DatagramTest<VacuumKind>;

TEST_F(StateDatagramTest, HasNoModesButThoseThatExist) {
  const std::pair<std::size_t, int> modes[] = {{2280, 4}, {2281, 3}, {2364, 6}};
  auto value = Sample(2);
  for (const auto& [offset, last] : modes) {
    for (int mode = 0; mode < 256; ++mode) {
      Bytes bytes = Pack(Sample(1));
      bytes[offset] = static_cast<std::byte>(mode);
      ASSERT_EQ(DecodeInto(bytes, value),
                mode <= last ? DatagramFault::kNone : DatagramFault::kEnum)
          << "byte " << offset << ", mode " << mode;
    }
  }
}

TEST_F(StateDatagramTest, HasNoFlagsButZeroAndOne) {
  auto value = Sample(2);
  for (std::size_t offset = 2282; offset < 2364; ++offset) {
    for (const int flag : {0, 1, 2, 3, 128, 255}) {
      Bytes bytes = Pack(Sample(1));
      bytes[offset] = static_cast<std::byte>(flag);
      ASSERT_EQ(DecodeInto(bytes, value), flag <= 1 ? DatagramFault::kNone : DatagramFault::kBool)
          << "byte " << offset << ", flag " << flag;
    }
  }
}

TEST_F(StateDatagramTest, KeepsEachErrorApart) {
  for (std::size_t error = 0; error < kRobotErrorCount; ++error) {
    RobotState state;
    state.errors.set(error);
    state.reflex_reason.set(kRobotErrorCount - 1 - error);
    StateBytes bytes;
    Encode(state, bytes);
    RobotState back;
    ASSERT_EQ(Decode(bytes, back), DatagramFault::kNone);
    EXPECT_EQ(back.errors, state.errors);
    EXPECT_EQ(back.reflex_reason, state.reflex_reason);
  }
}

TEST_F(StateDatagramTest, IsTakenWithNumbersThatAreNone) {
  RobotState state = Sample(1);
  state.q[3] = std::numeric_limits<double>::quiet_NaN();
  state.tau_J[0] = -std::numeric_limits<double>::infinity();
  RobotState back;
  ASSERT_EQ(Decode(Pack(state), back), DatagramFault::kNone);
  EXPECT_EQ(Pack(back), Pack(state));
}

TEST_F(CommandDatagramTest, HasNoFlagsButZeroAndOne) {
  auto value = Sample(2);
  for (const std::size_t offset : {312, 313}) {
    for (int flag = 0; flag < 256; ++flag) {
      Bytes bytes = Pack(Sample(1));
      bytes[offset] = static_cast<std::byte>(flag);
      ASSERT_EQ(DecodeInto(bytes, value), flag <= 1 ? DatagramFault::kNone : DatagramFault::kBool);
    }
  }
}

TEST_F(CommandDatagramTest, IsRefusedWithAnyNumberThatIsNone) {
  using Limits = std::numeric_limits<double>;
  auto value = Sample(2);
  for (const double bad : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
    const Bytes number = BytePacker().Put(bad).bytes();
    for (std::size_t offset = 8; offset < 370; offset += 8) {
      if (offset == 312) offset = 314;  // behind the flags
      Bytes bytes = Pack(Sample(1));
      std::copy(number.begin(), number.end(), bytes.begin() + static_cast<std::ptrdiff_t>(offset));
      ASSERT_EQ(DecodeInto(bytes, value), DatagramFault::kNotFinite) << offset << ": " << bad;
    }
  }
}

TEST_F(CommandDatagramTest, IsTakenWithTheLargestNumbersThereAre) {
  RobotCommand command = Sample(1);
  command.message_id = std::numeric_limits<std::uint64_t>::max();
  command.q_c.fill(std::numeric_limits<double>::max());
  command.tau_J_d.fill(std::numeric_limits<double>::denorm_min());
  RobotCommand back;
  ASSERT_EQ(Decode(Pack(command), back), DatagramFault::kNone);
  EXPECT_EQ(Pack(back), Pack(command));
}

TEST_F(HandStateDatagramTest, HasNoFlagButZeroAndOne) {
  auto value = Sample(2);
  for (int flag = 0; flag < 256; ++flag) {
    Bytes bytes = Pack(Sample(1));
    bytes[20] = static_cast<std::byte>(flag);
    ASSERT_EQ(DecodeInto(bytes, value), flag <= 1 ? DatagramFault::kNone : DatagramFault::kBool);
  }
}

TEST_F(VacuumStateDatagramTest, HasNoFlagsButZeroAndOneAndNoStatusBeyondRed) {
  auto value = Sample(2);
  for (int byte = 0; byte < 256; ++byte) {
    for (const std::size_t offset : {4, 5, 6, 7}) {
      Bytes bytes = Pack(Sample(1));
      bytes[offset] = static_cast<std::byte>(byte);
      const bool is_status = offset == 7;
      const auto wrong = is_status ? DatagramFault::kEnum : DatagramFault::kBool;
      ASSERT_EQ(DecodeInto(bytes, value),
                byte <= (is_status ? 3 : 1) ? DatagramFault::kNone : wrong)
          << "byte " << offset << ", value " << byte;
    }
  }
}

TEST(DatagramFaultTest, HasNames) {
  EXPECT_EQ(Name(DatagramFault::kNone), "none");
  EXPECT_EQ(Name(DatagramFault::kSize), "size");
  EXPECT_EQ(Name(DatagramFault::kEnum), "enum");
  EXPECT_EQ(Name(DatagramFault::kBool), "bool");
  EXPECT_EQ(Name(DatagramFault::kNotFinite), "not_finite");
}

}  // namespace
}  // namespace twin::fci::fci_datagrams_test
