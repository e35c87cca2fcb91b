#include "fuzz/fci_targets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "fci/byte_packer.h"
#include "fci/random_messages.h"
#include "fuzz/mutations.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/requests.h"

namespace twin::fci::fci_fuzz_test {
namespace {

constexpr std::uint64_t kRounds = 20'000;

void Append(Bytes& stream, const Bytes& more) {
  stream.insert(stream.end(), more.begin(), more.end());
}

void FeedMutations(fuzz::Target target, const std::vector<Bytes>& whole, std::uint64_t seed) {
  fuzz::FeedMutations(target, whole, seed, kRounds);
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

TEST(FciFuzzTest, VacuumRequestsSurviveMutations) {
  Bytes stream;
  const HandRequest requests[] = {Connect{1, 1}, HandCommand(hand::Vacuum()),
                                  HandCommand(hand::DropOff()), HandCommand(hand::Stop())};
  for (const HandRequest& request : requests) Append(stream, EncodeVacuumRequest(3, request));
  FeedMutations(fuzz::VacuumRequests, {InPieces(256, stream), InPieces(3, stream)}, 8);
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
  VacuumStateBytes vacuum;
  Encode(random.Vacuum(), vacuum);
  FeedMutations(fuzz::VacuumStateDatagram, {ToBytes(vacuum)}, 9);
}

TEST(FciFuzzTest, NothingIsSurvivedToo) {
  for (const fuzz::Target target :
       {fuzz::ArmRequests, fuzz::HandRequests, fuzz::ArmAnswers, fuzz::HandAnswers,
        fuzz::StateDatagram, fuzz::CommandDatagram, fuzz::HandStateDatagram, fuzz::VacuumRequests,
        fuzz::VacuumStateDatagram}) {
    target({});
  }
}

}  // namespace
}  // namespace twin::fci::fci_fuzz_test
