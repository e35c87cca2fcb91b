#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/fci/protocol.h"
#include "twin/record/packet.h"
#include "twin/record/pcapng_writer.h"
#include "twin/record/write_failure.h"
#include "twin/rt/spsc_ring.h"

namespace twin::fci {

/// Records a session's datagrams and TCP bytes to a pcapng file, on a thread of its own.
///
///     PutRealtime() --ring of 1024--> +---------------+
///     Put() -----------list, lock---> | writer thread | --> <path>.partial, <path> when finished
///                                     +---------------+
///
/// Orders packets by time among those that wait together, about one millisecond's worth.
///
/// Threads: PutRealtime() from one, Put() from any. Real-time: PutRealtime() is noexcept, wait-free
/// and does not allocate; a full ring drops and counts. Put() is not for real time.
class Capture {
 public:
  /// Length of the protocol's longest datagram.
  static constexpr std::size_t kLongestDatagram = kStateBytes;

  /// Creates `<path>.partial`. @throws EnvironmentError if it cannot.
  explicit Capture(const std::filesystem::path& path);
  /// Leaves `<path>.partial` if Finish() was not called.
  ~Capture();
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  /// The file's clock: 0 at its creation, never restarted.
  [[nodiscard]] const MonotonicClock& clock() const noexcept { return clock_; }
  /// Converts an instant of another clock to clock(). Real-time: noexcept, O(1).
  [[nodiscard]] Time TimeOf(const MonotonicClock& other, Time at) const noexcept TWIN_REALTIME {
    return Time(Duration(other.MonotonicNs(at) - clock_.MonotonicNs(Time())));
  }

  /// @param packet  a datagram; cut to kLongestDatagram bytes.
  void PutRealtime(const record::Packet& packet) noexcept TWIN_REALTIME;
  /// @param packet  bytes of a TCP stream, or a datagram.
  void Put(const record::Packet& packet);

  /// Reason why writing has stopped; empty while it works. Threads: any.
  [[nodiscard]] std::string Failure() const { return failure_.Text(); }

  /// Writes the remaining packets and renames the file to its final name. Call once, after the last
  /// Put.
  /// @returns the number of dropped datagrams. @throws EnvironmentError if any write has failed.
  std::uint64_t Finish();

 private:
  static constexpr std::size_t kRing = 1024;

  struct Datagram {
    record::Packet packet;  ///< its data is in `bytes`
    std::array<std::byte, kLongestDatagram> bytes;
  };
  struct Kept {
    record::Packet packet;  ///< its data is in `bytes`
    std::vector<std::byte> bytes;
  };

  void Run(const std::stop_token& stop);
  [[nodiscard]] bool Drain();
  void StopThread();

  const MonotonicClock clock_;
  record::PcapngWriter writer_;  ///< owned by the writer thread, then by Finish()
  rt::SpscRing<Datagram> datagrams_{kRing};
  std::mutex others_lock_;
  std::vector<Kept> others_;               ///< guarded by others_lock_
  std::vector<Kept> waiting_;              ///< owned by the writer thread
  std::atomic<std::uint64_t> dropped_{0};  ///< a counter: relaxed
  record::WriteFailure failure_;           ///< owned by the writer thread
  std::jthread thread_;
};

}  // namespace twin::fci
