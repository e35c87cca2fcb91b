#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "fci/byte_packer.h"
#include "twin/core/error.h"
#include "twin/fci/sockets.h"

namespace twin::fci::fci_tcp_stream_test {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr Endpoint kAnyPort{0x7F000001, 0};
/// Longer than anything here takes; only a failure waits for it.
constexpr Duration kTimeout = std::chrono::seconds(20);

/// Waits until the descriptor can be read from (or written to).
void Await(int fd, short events) {
  pollfd waiting{fd, events, 0};
  ASSERT_EQ(poll(&waiting, 1, static_cast<int>(kTimeout / milliseconds(1))), 1);
}

TcpStream Accept(TcpListener& listener) {
  Await(listener.fd(), POLLIN);
  auto stream = listener.Accept();
  EXPECT_TRUE(stream.has_value());
  return *std::move(stream);
}

/// Receives until there are `count` bytes or no more come.
Bytes ReceiveBytes(TcpStream& stream, std::size_t count, StreamResult& last) {
  Bytes all;
  std::array<std::byte, 1000> room;
  while (all.size() < count) {
    Await(stream.fd(), POLLIN);
    std::size_t received = 0;
    last = stream.Receive(room, received);
    if (last != StreamResult::kDone) break;
    all.insert(all.end(), room.begin(), room.begin() + static_cast<std::ptrdiff_t>(received));
  }
  return all;
}

StreamResult ReceiveEnd(TcpStream& stream) {
  StreamResult last = StreamResult::kPending;
  EXPECT_EQ(ReceiveBytes(stream, 1, last), Bytes());
  return last;
}

void SendAll(TcpStream& stream, const Bytes& bytes) {
  std::size_t sent = 0;
  ASSERT_EQ(stream.Send(bytes, sent), StreamResult::kDone);
  ASSERT_EQ(sent, bytes.size());
}

int OptionOf(const TcpStream& stream, int level, int option) {
  int value = -1;
  socklen_t size = sizeof value;
  EXPECT_EQ(getsockopt(stream.fd(), level, option, &value, &size), 0);
  return value;
}

/// Connecting to `to` fails with this text.
std::string WhyNotConnected(const Endpoint& to, Duration timeout) {
  try {
    static_cast<void>(TcpStream::Connect(to, timeout));
  } catch (const RobotFault& fault) {
    return fault.what();
  }
  return "";
}

class TcpStreamTest : public testing::Test {
 protected:
  TcpListener listener_{kAnyPort};
  TcpStream client_ = TcpStream::Connect(listener_.local(), kTimeout);
  TcpStream server_ = Accept(listener_);
};

TEST_F(TcpStreamTest, KnowsBothItsEnds) {
  EXPECT_EQ(client_.peer(), listener_.local());
  EXPECT_EQ(client_.local(), server_.peer());
  EXPECT_EQ(server_.local(), listener_.local());
}

TEST_F(TcpStreamTest, IsSetUpAsClientsOfTheRobotSetTheirs) {
  for (const TcpStream* stream : {&client_, &server_}) {
    EXPECT_NE(fcntl(stream->fd(), F_GETFL) & O_NONBLOCK, 0);
    EXPECT_EQ(OptionOf(*stream, IPPROTO_TCP, TCP_NODELAY), 1);
    EXPECT_EQ(OptionOf(*stream, SOL_SOCKET, SO_KEEPALIVE), 1);
    EXPECT_EQ(OptionOf(*stream, IPPROTO_TCP, TCP_KEEPIDLE), 1);
    EXPECT_EQ(OptionOf(*stream, IPPROTO_TCP, TCP_KEEPINTVL), 1);
    EXPECT_EQ(OptionOf(*stream, IPPROTO_TCP, TCP_KEEPCNT), 3);
  }
}

TEST_F(TcpStreamTest, HasNothingBeforeAnythingWasSent) {
  std::array<std::byte, 10> room;
  std::size_t received = 99;
  EXPECT_EQ(client_.Receive(room, received), StreamResult::kPending);
  EXPECT_EQ(received, 0U);
}

TEST_F(TcpStreamTest, BringsBytesBothWays) {
  const Bytes request = Hex("02000000 08000000 0c000000");
  const Bytes answer = Hex("02000000 08000000 0d000000 00");
  StreamResult last{};
  SendAll(client_, request);
  EXPECT_EQ(ReceiveBytes(server_, request.size(), last), request);
  SendAll(server_, answer);
  EXPECT_EQ(ReceiveBytes(client_, answer.size(), last), answer);
}

TEST_F(TcpStreamTest, ReceivesNothingWithoutRoom) {
  SendAll(client_, Bytes(1));
  Await(server_.fd(), POLLIN);
  std::size_t received = 99;
  EXPECT_EQ(server_.Receive({}, received), StreamResult::kPending);
  EXPECT_EQ(received, 0U);
}

TEST_F(TcpStreamTest, TellsThatThePeerClosed) {
  SendAll(client_, Hex("0102"));
  client_.Close();
  EXPECT_EQ(client_.fd(), -1);
  StreamResult last{};
  EXPECT_EQ(ReceiveBytes(server_, 2, last), Hex("0102"));
  EXPECT_EQ(ReceiveEnd(server_), StreamResult::kClosed);
}

TEST_F(TcpStreamTest, TellsThatThePeerReset) {
  client_.ResetConnection();
  EXPECT_EQ(client_.fd(), -1);
  EXPECT_EQ(ReceiveEnd(server_), StreamResult::kReset);
}

TEST_F(TcpStreamTest, ClosesInOrderWithBytesUnread) {
  SendAll(client_, Bytes(1000));
  Await(server_.fd(), POLLIN);
  SendAll(server_, Hex("0a0b0c"));
  server_.Close();
  StreamResult last{};
  EXPECT_EQ(ReceiveBytes(client_, 3, last), Hex("0a0b0c"));
  EXPECT_EQ(ReceiveEnd(client_), StreamResult::kClosed);
  // A connection that was reset behind its end would take nothing more.
  SendAll(client_, Hex("0d"));
}

TEST_F(TcpStreamTest, TellsASenderThatThePeerIsGone) {
  client_.ResetConnection();
  EXPECT_EQ(ReceiveEnd(server_), StreamResult::kReset);
  std::size_t sent = 99;
  // The process would end here if the system's SIGPIPE were let through.
  EXPECT_EQ(server_.Send(Bytes(10), sent), StreamResult::kReset);
  EXPECT_EQ(sent, 0U);
}

TEST_F(TcpStreamTest, TakesNoMoreThanThePeerReads) {
  const Bytes much(1 << 20);
  std::size_t total = 0;
  std::size_t sent = 0;
  StreamResult result = StreamResult::kDone;
  for (int i = 0; i < 1000 && result == StreamResult::kDone; ++i) {
    result = client_.Send(much, sent);
    total += sent;
  }
  EXPECT_EQ(result, StreamResult::kPending);
  EXPECT_EQ(sent, 0U);
  StreamResult last{};
  EXPECT_EQ(ReceiveBytes(server_, total, last).size(), total);
}

TEST_F(TcpStreamTest, CanBeEndedTwice) {
  client_.Close();
  client_.Close();
  client_.ResetConnection();
  server_.ResetConnection();
  server_.Close();
  std::size_t count = 0;
  std::array<std::byte, 1> room{};
  EXPECT_EQ(client_.Receive(room, count), StreamResult::kReset);
  EXPECT_EQ(client_.Send(room, count), StreamResult::kReset);
}

TEST_F(TcpStreamTest, OutlivesTheListener) {
  { const TcpListener gone = std::move(listener_); }
  SendAll(client_, Hex("01"));
  StreamResult last{};
  EXPECT_EQ(ReceiveBytes(server_, 1, last), Hex("01"));
}

TEST(TcpConnectTest, TellsThatNobodyListens) {
  // Bound, so that nobody else gets the port, but not listened at.
  const FileDescriptor fd(socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(kAnyPort.address);
  socklen_t size = sizeof address;
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  ASSERT_EQ(bind(fd.get(), generic, size), 0);
  ASSERT_EQ(getsockname(fd.get(), generic, &size), 0);
  const Endpoint to{kAnyPort.address, ntohs(address.sin_port)};
  const std::string why = WhyNotConnected(to, kTimeout);
  EXPECT_THAT(why, HasSubstr(ToString(to) + " refuses"));
  EXPECT_THAT(why, HasSubstr("panda-twin serve"));
}

TEST(TcpConnectTest, TellsThatNobodyAnswersInTime) {
  // Who accepts nothing gets no more connections than he lets wait.
  const TcpListener listener(kAnyPort);
  ASSERT_EQ(listen(listener.fd(), 0), 0);
  std::vector<TcpStream> waiting;
  std::string why;
  for (int i = 0; i < 8 && why.empty(); ++i) {
    try {
      waiting.push_back(TcpStream::Connect(listener.local(), milliseconds(300)));
    } catch (const RobotFault& fault) {
      why = fault.what();
    }
  }
  EXPECT_THAT(why, HasSubstr(ToString(listener.local()) + " does not answer within 0.3 s"));
}

TEST(TcpConnectTest, TellsWhatElseIsWrong) {
  const std::string why = WhyNotConnected({0xFFFFFFFF, 1337}, milliseconds(300));
  EXPECT_THAT(why, HasSubstr("255.255.255.255:1337 cannot be reached"));
}

TEST(TcpListenerTest, HasNothingBeforeAnybodyConnects) {
  TcpListener listener(kAnyPort);
  EXPECT_NE(listener.local().port, 0);
  EXPECT_FALSE(listener.Accept().has_value());
}

TEST(TcpListenerTest, NamesAPortThatIsTaken) {
  const TcpListener first(kAnyPort);
  try {
    const TcpListener second(first.local());
    FAIL() << "listens at " << ToString(second.local());
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr(ToString(first.local())));
    EXPECT_THAT(error.what(), HasSubstr("another port"));
  }
}

TEST(TcpListenerTest, TakesAPortAgainWhoseConnectionsHaveEnded) {
  Endpoint at;
  {
    TcpListener listener(kAnyPort);
    at = listener.local();
    TcpStream client = TcpStream::Connect(at, kTimeout);
    TcpStream server = Accept(listener);
    server.Close();  // the end that closes first goes on blocking the port
    EXPECT_EQ(ReceiveEnd(client), StreamResult::kClosed);
  }
  EXPECT_EQ(TcpListener(at).local(), at);
}

TEST(TcpListenerTest, OutlivesAClientThatIsGoneBeforeItIsAccepted) {
  TcpListener listener(kAnyPort);
  TcpStream::Connect(listener.local(), kTimeout).ResetConnection();
  if (auto stream = listener.Accept()) {
    EXPECT_EQ(ReceiveEnd(*stream), StreamResult::kReset);
  }
  TcpStream next = TcpStream::Connect(listener.local(), kTimeout);
  TcpStream server = Accept(listener);
  SendAll(next, Hex("42"));
  StreamResult last{};
  EXPECT_EQ(ReceiveBytes(server, 1, last), Hex("42"));
}

}  // namespace
}  // namespace twin::fci::fci_tcp_stream_test
