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

/// Keeps a session's datagrams and TCP bytes in a pcapng file, off the threads that exchange them.
///
///     PutRealtime() --ring of 1024--> +---------------+
///     Put() -----------list, lock---> | writer thread | --> <path>.partial, <path> when finished
///                                     +---------------+
///
/// Packets are in order of their time as far as they wait together, about a millisecond.
///
/// Threads: PutRealtime() from one, Put() from any. Real-time: PutRealtime() is noexcept,
/// wait-free, and allocates nothing; a full ring drops and counts. Put() is not for real
/// time.
class Capture {
 public:
  /// The longest datagram of the protocol.
  static constexpr std::size_t kLongestDatagram = kStateBytes;

  /// Creates `<path>.partial`. @throws EnvironmentError when that is not possible.
  explicit Capture(const std::filesystem::path& path);
  /// Without Finish(): leaves `<path>.partial`.
  ~Capture();
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  /// The file's time, from 0 when it was created, for who has no clock that is never restarted.
  [[nodiscard]] const MonotonicClock& clock() const noexcept { return clock_; }
  /// An instant of another clock on clock(). Real-time: noexcept, O(1).
  [[nodiscard]] Time TimeOf(const MonotonicClock& other, Time at) const noexcept TWIN_REALTIME {
    return Time(Duration(other.MonotonicNs(at) - clock_.MonotonicNs(Time())));
  }

  /// @param packet  a datagram; of more than kLongestDatagram bytes, those.
  void PutRealtime(const record::Packet& packet) noexcept TWIN_REALTIME;
  /// @param packet  bytes of a TCP stream, or a datagram.
  void Put(const record::Packet& packet);

  /// Why nothing is written any more, as soon as that is so; empty: all is well. Threads: any.
  [[nodiscard]] std::string Failure() const { return failure_.Text(); }

  /// Writes what waits, and gives the file its name. Call once, after the last Put.
  /// @returns datagrams that were dropped. @throws EnvironmentError when anything could not be
  /// written, now or before.
  std::uint64_t Finish();

 private:
  static constexpr std::size_t kRing = 1024;

  struct Datagram {
    record::Packet packet;  ///< whose bytes are `bytes`
    std::array<std::byte, kLongestDatagram> bytes;
  };
  struct Kept {
    record::Packet packet;  ///< whose bytes are `bytes`
    std::vector<std::byte> bytes;
  };

  void Run(const std::stop_token& stop);
  [[nodiscard]] bool Drain();
  void StopThread();

  const MonotonicClock clock_;
  record::PcapngWriter writer_;  ///< the writer thread's, then Finish()'s
  rt::SpscRing<Datagram> datagrams_{kRing};
  std::mutex others_lock_;
  std::vector<Kept> others_;               ///< guarded by others_lock_
  std::vector<Kept> waiting_;              ///< the writer thread's
  std::atomic<std::uint64_t> dropped_{0};  ///< a count only: relaxed
  record::WriteFailure failure_;           ///< the writer thread's
  std::jthread thread_;
};

}  // namespace twin::fci
