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

/// Where the device "network" listens, and to whom.
struct NetworkSettings {
  fci::Endpoint bind{0x7F000001, 4811};  ///< port 0: any free one
  std::optional<fci::Network> allow{};   ///< who may send, beside this machine; absent: nobody
  Token token{};                         ///< that every sample carries
  Duration silence = std::chrono::seconds(1);  ///< after which the sender has gone

  /// @throws InputError when others could send without being named, or the silence is not in
  /// [0.05, 60] s.
  void Validate() const;
  /// Whether somebody at `address` may: this machine, and who is in `allow`.
  [[nodiscard]] bool MaySend(std::uint32_t address) const noexcept TWIN_REALTIME;
};

/// A device's own program, which sends samples by UDP (operator_message.h) and gets the feedback
/// back at the address it sends from.
///
/// The first sender with the token holds the session until it has been silent for
/// NetworkSettings::silence; everybody else is passed over meanwhile. Samples that were overtaken
/// are dropped. Presses are counted from the session's first sample on, and sequences go on
/// growing, so that neither jumps when another program takes over.
///
/// lost(): from the end of a session to the first sample of the next one.
///
/// Threads: Read() and Feel() from one; lost() and Describe() from any. Real-time: at most
/// kMostDatagrams are read at once; what is waiting beyond is read next time.
class NetworkDevice final : public teleop::Device {
 public:
  /// What became of the datagrams.
  struct Tally {
    std::uint64_t taken = 0;
    std::uint64_t overtaken = 0;    ///< doubled, or later than one that was taken
    std::uint64_t foreign = 0;      ///< of somebody who may not, or beside the session's sender
    std::uint64_t wrong_token = 0;  ///< sound, but for the token
    std::uint64_t malformed = 0;
    bool operator==(const Tally&) const = default;
  };
  static constexpr int kMostDatagrams = 64;

  /// @param clock  must outlive this. @throws InputError as Validate; EnvironmentError when the
  /// port is taken.
  NetworkDevice(const MonotonicClock& clock, const NetworkSettings& settings);

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override;
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override;
  [[nodiscard]] bool lost() const noexcept override {
    return lost_.load(std::memory_order_relaxed);  // alone: nothing else is published with it
  }
  [[nodiscard]] std::string Describe() const override;

  [[nodiscard]] fci::Endpoint local() const noexcept { return socket_.local(); }
  /// From the thread of Read().
  [[nodiscard]] const Tally& tally() const noexcept { return tally_; }

 private:
  /// @returns the sample as the session has it, unless it is passed over.
  std::optional<teleop::OperatorSample> Take(const fci::Datagram& datagram, Time now) noexcept;
  void BeginSession(const fci::Endpoint& peer, const teleop::OperatorSample& first) noexcept;

  const NetworkSettings settings_;
  fci::UdpSocket socket_;
  std::optional<fci::Endpoint> peer_;  ///< who holds the session
  Time heard_{};                       ///< when, last
  std::uint64_t first_ = 0;            ///< sequence of the session's first sample
  std::uint64_t last_ = 0;             ///< and of its newest
  teleop::OperatorSample given_;       ///< newest sample, as it went out
  teleop::OperatorSample offset_;      ///< from the sender's sequence and presses to ours
  Tally tally_;
  std::atomic<bool> lost_{false};
};

/// The device "network". Parameters: bind, port, allow, token, silence (README.md). Without a
/// token, one is drawn that nobody can guess; Describe() tells it.
/// @throws InputError for a parameter, and in lockstep, where nobody could keep up.
[[nodiscard]] std::unique_ptr<teleop::Device> MakeNetworkDevice(
    const teleop::DeviceRequest& request);

}  // namespace twin::devices
