#include "fuzz/fci_targets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "fci/byte_packer.h"
#include "fci/random_messages.h"
#include "twin/core/random.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/requests.h"

namespace twin::fci {
namespace {

constexpr std::uint64_t kRounds = 20'000;

void Append(Bytes& stream, const Bytes& more) {
  stream.insert(stream.end(), more.begin(), more.end());
}

/// Changes `bytes` in one of the ways in which they break on the way, or are broken.
void Mutate(Bytes& bytes, const Random& random, std::uint64_t round) {
  const auto bits = random.Bits(round);
  if (bytes.empty()) return;
  const std::size_t at = bits[1] % bytes.size();
  const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  switch (bits[0] % 6) {
    case 0: bytes[at] ^= static_cast<std::byte>(1U << bits[2] % 8); break;
    case 1: bytes.resize(at); break;
    case 2: {  // a size, a mode, a flag, or the end of a number that is none
      const std::uint32_t values[] = {0, 1, 2, 12, 0x7FF00000, 0x7FFFFFFF, 0xFFFFFFFF, bits[2]};
      std::memcpy(&bytes[at], &values[bits[3] % 8], std::min<std::size_t>(4, bytes.size() - at));
      break;
    }
    case 3: bytes.erase(place); break;
    case 4: bytes.insert(place, static_cast<std::byte>(bits[2])); break;
    default: {  // a part of it again, as a network repeats one
      const Bytes part(place, bytes.end());
      Append(bytes, part);
    }
  }
}

void FeedMutations(fuzz::Target target, const std::vector<Bytes>& whole, std::uint64_t seed) {
  const Random random(seed, RandomStream::kTest);
  for (std::uint64_t round = 0; round < kRounds; ++round) {
    Bytes bytes = whole[round % whole.size()];
    target(bytes);
    for (std::uint64_t i = 0; i <= round % 3; ++i) Mutate(bytes, random, 3 * round + i);
    target(bytes);
  }
}

Bytes Prefixed(std::byte first, const Bytes& rest) {
  Bytes bytes(1 + rest.size());
  bytes[0] = first;
  std::copy(rest.begin(), rest.end(), bytes.begin() + 1);
  return bytes;
}

/// With a first byte that makes pieces of `piece` bytes.
Bytes InPieces(std::size_t piece, const Bytes& stream) {
  return Prefixed(static_cast<std::byte>(piece - 1), stream);
}

Bytes ArmStream() {
  Bytes stream;
  const ArmRequest requests[] = {Connect{5, 1},
                                 Move(),
                                 StopMove(),
                                 GetCartesianLimit{2},
                                 Setting(setting::CollisionBehavior()),
                                 Setting(setting::JointImpedance()),
                                 Setting(setting::CartesianImpedance()),
                                 Setting(setting::GuidingMode()),
                                 Setting(setting::StiffnessFrame()),
                                 Setting(setting::EndEffectorFrame()),
                                 Setting(setting::Load()),
                                 Setting(setting::Filters()),
                                 AutomaticErrorRecovery(),
                                 LoadModelLibrary()};
  for (const ArmRequest& request : requests) Append(stream, EncodeRequest(3, request));
  return stream;
}

Bytes HandStream() {
  Bytes stream;
  const HandRequest requests[] = {Connect{3, 1}, HandCommand(hand::Homing()),
                                  HandCommand(hand::Grasp()), HandCommand(hand::Move()),
                                  HandCommand(hand::Stop())};
  for (const HandRequest& request : requests) Append(stream, EncodeRequest(3, request));
  return stream;
}

TEST(FciFuzzTest, ArmRequestsSurviveMutations) {
  const Bytes stream = ArmStream();
  FeedMutations(fuzz::ArmRequests, {InPieces(256, stream), InPieces(7, stream)}, 1);
}

TEST(FciFuzzTest, HandRequestsSurviveMutations) {
  const Bytes stream = HandStream();
  FeedMutations(fuzz::HandRequests, {InPieces(256, stream), InPieces(3, stream)}, 2);
}

TEST(FciFuzzTest, ArmAnswersSurviveMutations) {
  std::vector<Bytes> all;
  const auto add = [&all](ArmCommand asked, const Bytes& answer) {
    all.push_back(Prefixed(static_cast<std::byte>(asked), InPieces(100, answer)));
  };
  add(ArmCommand::kConnect, EncodeArmConnectAnswer(0, ConnectStatus::kSuccess, 5));
  add(ArmCommand::kMove, EncodeArmAnswer(ArmCommand::kMove, 1, 1));
  add(ArmCommand::kGetCartesianLimit,
      EncodeCartesianLimitAnswer(2, SetterStatus::kSuccess, CartesianLimit()));
  add(ArmCommand::kLoadModelLibrary,
      EncodeModelLibraryAnswer(3, ModelLibraryStatus::kSuccess, Bytes(200, std::byte{0x7F})));
  FeedMutations(fuzz::ArmAnswers, all, 3);
}

TEST(FciFuzzTest, HandAnswersSurviveMutations) {
  const Bytes connect = EncodeHandConnectAnswer(0, ConnectStatus::kSuccess, 3);
  const Bytes grasp = EncodeHandAnswer(HandCommandId::kGrasp, 1, HandResult::kUnsuccessful);
  FeedMutations(
      fuzz::HandAnswers,
      {Prefixed(std::byte{0}, InPieces(5, connect)), Prefixed(std::byte{2}, InPieces(200, grasp))},
      4);
}

TEST(FciFuzzTest, DatagramsSurviveMutations) {
  RandomMessages random(5);
  StateBytes state;
  Encode(random.State(), state);
  FeedMutations(fuzz::StateDatagram, {ToBytes(state)}, 5);
  CommandBytes command;
  Encode(random.Command(), command);
  FeedMutations(fuzz::CommandDatagram, {ToBytes(command)}, 6);
  HandStateBytes hand;
  Encode(random.Hand(), hand);
  FeedMutations(fuzz::HandStateDatagram, {ToBytes(hand)}, 7);
}

TEST(FciFuzzTest, NothingIsSurvivedToo) {
  for (const fuzz::Target target :
       {fuzz::ArmRequests, fuzz::HandRequests, fuzz::ArmAnswers, fuzz::HandAnswers,
        fuzz::StateDatagram, fuzz::CommandDatagram, fuzz::HandStateDatagram}) {
    target({});
  }
}

}  // namespace
}  // namespace twin::fci
