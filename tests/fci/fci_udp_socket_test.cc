#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/time.h>

#include <array>
#include <chrono>
#include <cstring>
#include <thread>

#include "fci/byte_packer.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/fci/sockets.h"
#include "twin/rt/host_time.h"

namespace twin::fci::fci_udp_socket_test {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr Endpoint kAnyPort{0x7F000001, 0};
/// Longer than anything here takes; only a failure waits for it.
constexpr Duration kTimeout = std::chrono::seconds(20);

class UdpSocketTest : public testing::Test {
 protected:
  /// The datagram that is on its way.
  std::optional<Datagram> Await(UdpSocket& socket) {
    EXPECT_TRUE(socket.AwaitUntil(clock_.Now() + kTimeout));
    return socket.Receive(buffer_);
  }
  static Bytes SomeBytes(std::size_t count) {
    Bytes bytes(count);
    for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(3 * i + 1);
    return bytes;
  }

  MonotonicClock clock_;
  UdpSocket near_{clock_, kAnyPort};
  UdpSocket far_{clock_, kAnyPort};
  std::array<std::byte, 4096> buffer_{};
};

TEST_F(UdpSocketTest, BindsAFreePortOfItsOwn) {
  EXPECT_EQ(near_.local().address, kAnyPort.address);
  EXPECT_NE(near_.local().port, 0);
  EXPECT_NE(near_.local().port, far_.local().port);
}

TEST_F(UdpSocketTest, NamesAnEndpointItCannotBind) {
  try {
    const UdpSocket second(clock_, near_.local());
    FAIL() << "bound " << ToString(second.local());
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr(ToString(near_.local())));
    EXPECT_THAT(error.what(), HasSubstr("another port"));
  }
  try {
    const UdpSocket foreign(clock_, {0xCB007101, 0});  // 203.0.113.1, of documentation only
    FAIL() << "bound " << ToString(foreign.local());
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("203.0.113.1:0"));
    EXPECT_THAT(error.what(), HasSubstr("address of this machine"));
  }
}

TEST_F(UdpSocketTest, HasNothingBeforeAnythingWasSent) {
  EXPECT_FALSE(near_.Receive(buffer_).has_value());
}

TEST_F(UdpSocketTest, BringsBytesAndSenderInTheOrderSent) {
  for (const std::size_t size : {1, 370, 2373, 23, 0, 4096}) {
    const Bytes bytes = SomeBytes(size);
    ASSERT_TRUE(near_.Send(bytes, far_.local()));
    ASSERT_TRUE(near_.Send(SomeBytes(5), far_.local()));
    const auto datagram = Await(far_);
    ASSERT_TRUE(datagram.has_value());
    EXPECT_EQ(ToBytes(datagram->bytes), bytes);
    EXPECT_EQ(datagram->from, near_.local());
    const auto second = Await(far_);
    ASSERT_TRUE(second.has_value());
    EXPECT_EQ(second->bytes.size(), 5U);
    EXPECT_FALSE(far_.Receive(buffer_).has_value());
  }
}

TEST_F(UdpSocketTest, AnswersFromTheSocketThatReceives) {
  ASSERT_TRUE(near_.Send(SomeBytes(1), far_.local()));
  const auto state = Await(far_);
  ASSERT_TRUE(state.has_value());
  ASSERT_TRUE(far_.Send(SomeBytes(2), state->from));
  const auto command = Await(near_);
  ASSERT_TRUE(command.has_value());
  EXPECT_EQ(command->from, far_.local());
}

TEST_F(UdpSocketTest, CutsADatagramToTheBuffer) {
  const Bytes bytes = SomeBytes(100);
  ASSERT_TRUE(near_.Send(bytes, far_.local()));
  ASSERT_TRUE(far_.AwaitUntil(clock_.Now() + kTimeout));
  const auto datagram = far_.Receive(std::span(buffer_).first(40));
  ASSERT_TRUE(datagram.has_value());
  EXPECT_EQ(ToBytes(datagram->bytes), Bytes(bytes.begin(), bytes.begin() + 40));
  EXPECT_FALSE(far_.Receive(buffer_).has_value());
}

TEST_F(UdpSocketTest, TellsWhenEachDatagramCame) {
  for (int i = 0; i < 100; ++i) {
    const Time before = clock_.Now();
    ASSERT_TRUE(near_.Send(SomeBytes(370), far_.local()));
    const auto datagram = Await(far_);
    const Time after = clock_.Now();
    ASSERT_TRUE(datagram.has_value());
    EXPECT_GE(datagram->at, before);
    EXPECT_LE(datagram->at, after);
  }
}

TEST_F(UdpSocketTest, TellsWhenTheKernelReceivedADatagramThatWaited) {
  // The kernel begins to stamp some time after it was asked to.
  for (const Time end = clock_.Now() + kTimeout; clock_.Now() < end;) {
    ASSERT_TRUE(near_.Send(SomeBytes(1), far_.local()));
    ASSERT_TRUE(far_.AwaitUntil(clock_.Now() + kTimeout));
    const Time was_there = clock_.Now();
    rt::SleepUntil(clock_, was_there + milliseconds(2));
    const auto datagram = far_.Receive(buffer_);
    ASSERT_TRUE(datagram.has_value());
    if (datagram->at <= was_there) return;
  }
  FAIL() << "every datagram was stamped when it was read";
}

TEST_F(UdpSocketTest, WaitsUntilTheDeadlineAndNotLess) {
  const Time deadline = clock_.Now() + milliseconds(5);
  EXPECT_FALSE(near_.AwaitUntil(deadline));
  EXPECT_GE(clock_.Now(), deadline);
  EXPECT_FALSE(near_.AwaitUntil(deadline));
  EXPECT_FALSE(near_.AwaitUntil(Time::min()));
}

TEST_F(UdpSocketTest, TellsOfWhatWaitsAfterTheDeadlineToo) {
  ASSERT_TRUE(near_.Send(SomeBytes(1), far_.local()));
  ASSERT_TRUE(far_.AwaitUntil(Time::max()));
  EXPECT_TRUE(far_.AwaitUntil(Time::min()));
  ASSERT_TRUE(far_.Receive(buffer_).has_value());
  EXPECT_FALSE(far_.AwaitUntil(Time::min()));
}

TEST_F(UdpSocketTest, WakesWhenADatagramComes) {
  std::jthread sender([this] {
    rt::SleepUntil(clock_, clock_.Now() + milliseconds(5));
    near_.Send(SomeBytes(1), far_.local());
  });
  EXPECT_TRUE(far_.AwaitUntil(clock_.Now() + kTimeout));
}

TEST_F(UdpSocketTest, WaitsOnWhenASignalInterrupts) {
  struct sigaction old {};
  struct sigaction quiet {};
  quiet.sa_handler = [](int) {};
  sigaction(SIGALRM, &quiet, &old);
  const itimerval every_ms{{0, 1000}, {0, 1000}};
  setitimer(ITIMER_REAL, &every_ms, nullptr);
  const Time deadline = clock_.Now() + milliseconds(20);
  const bool arrived = near_.AwaitUntil(deadline);
  const Time after = clock_.Now();
  const itimerval never{};
  setitimer(ITIMER_REAL, &never, nullptr);
  sigaction(SIGALRM, &old, nullptr);
  EXPECT_FALSE(arrived);
  EXPECT_GE(after, deadline);
}

TEST_F(UdpSocketTest, OutlivesAPeerThatIsGone) {
  Endpoint gone;
  {
    const UdpSocket peer(clock_, kAnyPort);
    gone = peer.local();
  }
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(near_.Send(SomeBytes(1), gone));
  EXPECT_FALSE(near_.Receive(buffer_).has_value());
  ASSERT_TRUE(far_.Send(SomeBytes(7), near_.local()));
  const auto datagram = Await(near_);
  ASSERT_TRUE(datagram.has_value());
  EXPECT_EQ(datagram->bytes.size(), 7U);
}

TEST_F(UdpSocketTest, LosesWhatTheKernelDoesNotTake) {
  const Bytes too_long(70'000);
  EXPECT_FALSE(near_.Send(too_long, far_.local()));
  EXPECT_FALSE(far_.Receive(buffer_).has_value());
}

TEST_F(UdpSocketTest, IsForRealTime) {
  const Bytes bytes = SomeBytes(2373);
  const Endpoint to = far_.local();
  int received = 0;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    near_.Send(bytes, to);
    if (!far_.AwaitUntil(clock_.Now() + kTimeout)) break;
    received += far_.Receive(buffer_).has_value() ? 1 : 0;
    received += far_.Receive(buffer_).has_value() ? 1 : 0;
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
  EXPECT_EQ(received, 1000);
}

}  // namespace
}  // namespace twin::fci::fci_udp_socket_test
