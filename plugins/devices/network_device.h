#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "plugins/devices/operator_message.h"
#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/fci/sockets.h"
#include "twin/teleop/device.h"
#include "twin/teleop/device_registry.h"

namespace twin::devices {

/// Configuration of the device "network".
struct NetworkSettings {
  fci::Endpoint bind{0x7F000001, 4811};  ///< port 0: any free port
  std::optional<fci::Network>
      allow{};    ///< remote network that may send; nullopt: this machine only
  Token token{};  ///< required in every sample
  Duration silence = std::chrono::seconds(1);  ///< after which the session ends

  /// @throws InputError if other machines reach the bound address and `allow` is missing, or the
  /// silence is not in [0.05, 60] s.
  void Validate() const;
  /// True if `address` may send: this machine, or one in `allow`.
  [[nodiscard]] bool MaySend(std::uint32_t address) const noexcept TWIN_REALTIME;
};

/// An external program as a device: it sends samples by UDP (operator_message.h) and receives the
/// feedback at its source address.
///
/// The first sender with the token holds the session until it has been silent for
/// NetworkSettings::silence; other senders are ignored meanwhile. Overtaken samples are dropped.
/// Presses count from the session's first sample, and sequences keep rising, so that neither jumps
/// when another program takes over.
///
/// lost(): from the end of a session to the first sample of the next one.
///
/// Threads: Read() and Feel() from one; lost() and Describe() from any. Real-time: a call reads at
/// most kMostDatagrams datagrams; the next call reads the rest.
class NetworkDevice final : public teleop::Device {
 public:
  /// Datagrams by outcome.
  struct Tally {
    std::uint64_t taken = 0;
    std::uint64_t overtaken = 0;    ///< duplicated, or later than an accepted one
    std::uint64_t foreign = 0;      ///< from a forbidden sender, or not from the session's
    std::uint64_t wrong_token = 0;  ///< valid except for the token
    std::uint64_t malformed = 0;
    bool operator==(const Tally&) const = default;
  };
  static constexpr int kMostDatagrams = 64;

  /// @param clock  must outlive this object. @throws InputError as Validate; EnvironmentError if
  /// the port is in use.
  NetworkDevice(const MonotonicClock& clock, const NetworkSettings& settings);

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override;
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override;
  [[nodiscard]] bool lost() const noexcept override {
    return lost_.load(std::memory_order_relaxed);  // relaxed: publishes no other data
  }
  [[nodiscard]] std::string Describe() const override;

  [[nodiscard]] fci::Endpoint local() const noexcept { return socket_.local(); }
  /// From Read()'s thread only.
  [[nodiscard]] const Tally& tally() const noexcept { return tally_; }

 private:
  /// @returns the sample with the session's numbers; nullopt if it is ignored.
  std::optional<teleop::OperatorSample> Take(const fci::Datagram& datagram, Time now) noexcept;
  void BeginSession(const fci::Endpoint& peer, const teleop::OperatorSample& first) noexcept;

  const NetworkSettings settings_;
  fci::UdpSocket socket_;
  std::optional<fci::Endpoint> peer_;  ///< holder of the session
  Time heard_{};                       ///< time of its last sample
  std::uint64_t first_ = 0;            ///< sequence of the session's first sample
  std::uint64_t last_ = 0;             ///< sequence of its newest sample
  teleop::OperatorSample given_;       ///< newest sample returned by Read()
  teleop::OperatorSample offset_;      ///< from the sender's sequence and presses to ours
  Tally tally_;
  std::atomic<bool> lost_{false};
};

/// The device "network". Parameters: bind, port, allow, token, silence (README.md). Without a
/// token, an unguessable one is drawn; Describe() shows it.
/// @throws InputError for a parameter, and in lockstep, where an operator cannot keep up.
[[nodiscard]] std::unique_ptr<teleop::Device> MakeNetworkDevice(
    const teleop::DeviceRequest& request);

}  // namespace twin::devices
