#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "twin/core/clock.h"
#include "twin/fci/requests.h"
#include "twin/fci/sockets.h"
#include "twin/proxy/proxy.h"
#include "twin/rt/host_time.h"

namespace twin::proxy {

using Bytes = std::vector<std::byte>;

constexpr std::uint32_t kLoopback = 0x7f000001;
constexpr std::uint32_t kElsewhere = 0x7f000002;  ///< this machine all the same
constexpr Duration kLong = std::chrono::seconds(60);

inline Bytes ArmRequest(std::uint32_t id, const fci::ArmRequest& request) {
  return fci::EncodeRequest(id, request);
}
inline Bytes Join(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// A proxy on a thread of its own, between the test's robot and the test's client.
class ProxyTest : public ::testing::Test {
 protected:
  ProxyTest() {
    config_.arm_port = 0;
    config_.hand_port = 0;
    config_.robot_arm = robot_arm_.local();
    config_.robot_hand = robot_hand_.local();
    config_.fifo_priority = 0;
    config_.connect_timeout = kLong;
  }
  ~ProxyTest() override { End(); }

  void Start() {
    proxy_ = std::make_unique<Proxy>(config_, clock_, [this](std::string_view line) {
      const std::scoped_lock lock(mutex_);
      lines_.emplace_back(line);
    });
    thread_ = std::jthread([this](const std::stop_token& stop) {
      proxy_->Run([&] { return stop.stop_requested(); });
    });
  }
  void End() {
    if (!thread_.joinable()) return;
    thread_.request_stop();
    thread_.join();
  }
  /// Once it has been told.
  void AwaitLine(std::string_view what) {
    const auto was_told = [&] {
      const std::scoped_lock lock(mutex_);
      return std::ranges::any_of(
          lines_, [&](const std::string& line) { return line.find(what) != std::string::npos; });
    };
    while (!was_told()) rt::Pause(std::chrono::milliseconds(1));
  }

  fci::TcpStream ConnectArm() { return fci::TcpStream::Connect(proxy_->arm(), kLong); }
  static fci::TcpStream AwaitConnection(fci::TcpListener& listener) {
    for (;;) {
      if (auto stream = listener.Accept()) return std::move(*stream);
      rt::Pause(std::chrono::milliseconds(1));
    }
  }
  static void Send(fci::TcpStream& stream, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      std::size_t sent = 0;
      ASSERT_LE(stream.Send(bytes, sent), fci::StreamResult::kPending);
      bytes = bytes.subspan(sent);
    }
  }
  /// What comes next: as many bytes, or fewer when the stream endpoints before.
  static Bytes Receive(fci::TcpStream& stream, std::size_t count) {
    Bytes bytes(count);
    std::size_t have = 0;
    while (have < count) {
      std::size_t received = 0;
      const auto result = stream.Receive(std::span(bytes).subspan(have), received);
      if (result == fci::StreamResult::kPending) rt::Pause(std::chrono::milliseconds(1));
      if (result > fci::StreamResult::kPending) break;
      have += received;
    }
    bytes.resize(have);
    return bytes;
  }
  /// How the stream endpoints; nothing must come before.
  static fci::StreamResult AwaitEnd(fci::TcpStream& stream) {
    std::array<std::byte, 1> one{};
    for (;;) {
      std::size_t received = 0;
      const auto result = stream.Receive(one, received);
      if (result != fci::StreamResult::kPending) return result;
      rt::Pause(std::chrono::milliseconds(1));
    }
  }

  /// A session of the arm: TCP of both endpoints, and where the robot was told to send to.
  struct Session {
    fci::TcpStream client;
    fci::TcpStream robot;
    fci::Endpoint robot_side;
  };
  Session OnConnect() {
    fci::TcpStream client = ConnectArm();
    Send(client, ArmRequest(0, fci::Connect{5, client_udp_.local().port}));
    fci::TcpStream robot = AwaitConnection(robot_arm_);
    const std::uint16_t port = PortIn(Receive(robot, 16));
    return {std::move(client), std::move(robot), {kLoopback, port}};
  }
  /// The UDP port of an arm's Connect.
  static std::uint16_t PortIn(const Bytes& connect) {
    if (connect.size() != 16) return 0;
    return static_cast<std::uint16_t>(std::to_integer<unsigned>(connect[14]) |
                                      std::to_integer<unsigned>(connect[15]) << 8);
  }

  const MonotonicClock clock_;
  fci::TcpListener robot_arm_{fci::Endpoint{kLoopback, 0}};
  fci::TcpListener robot_hand_{fci::Endpoint{kLoopback, 0}};
  fci::UdpSocket robot_udp_{clock_, {kLoopback, 0}};
  fci::UdpSocket client_udp_{clock_, {kLoopback, 0}};
  /// For the test to change, before Start().
  ProxyConfig config_;

  std::mutex mutex_;
  std::vector<std::string> lines_;
  std::unique_ptr<Proxy> proxy_;
  std::jthread thread_;
};

}  // namespace twin::proxy
