#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "twin/core/time.h"
#include "twin/fci/capture.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/requests.h"
#include "twin/fci/sockets.h"

namespace twin::fci {

/// Another socket that a channel's reader thread looks after.
struct SideSocket {
  int fd = -1;
  /// Called when it may have something; and after the bytes of the stream were received, before
  /// they are looked at: what the peer sent on it before an answer is drained before the answer.
  std::function<void()> drain;
};

/// The TCP side of a client: sends requests and hands each answer to who asked.
///
///     any thread: Send() ---TCP---> peer          reader thread: bytes -> frames -> answers by id
///                 Await(id) <---- condition ------------------------------------------+
///
/// An answer is matched by its command_id, whatever the order; one that nobody asked for, or no
/// longer, is thrown away. What is kept is bounded: the requests that somebody still asks for, two
/// answers each. A connection that ends wakes all who wait: nobody waits for ever.
///
/// Threads: any. The reader thread ends with the object, whose owner makes sure that nobody waits
/// any more. Not for real-time code, but for lost().
class RequestChannel {
 public:
  /// Turns a command_id into a request's frame.
  using Encoder = std::function<std::vector<std::byte>(std::uint32_t)>;

  /// What came.
  struct Answer {
    FrameHead head;
    std::vector<std::byte> payload;

    [[nodiscard]] Frame frame() const noexcept { return {head, payload}; }
  };

  /// @param peer      for texts: "the robot 127.0.0.1:1337".
  /// @param largest   answer that is taken, bytes.
  /// @param timeout  of a Send() that the peer does not take.
  /// @param capture   keeps the stream's bytes; must outlive the channel. Null: nothing.
  RequestChannel(HeadKind kind, TcpStream stream, std::string peer, std::size_t largest,
                 Duration timeout, Capture* capture, SideSocket side = {});
  ~RequestChannel();
  RequestChannel(const RequestChannel&) = delete;
  RequestChannel& operator=(const RequestChannel&) = delete;

  /// Sends a request; from then on its answers are kept. @returns its command_id, counted from 0.
  /// @throws RobotFault when the connection is lost.
  [[nodiscard]] std::uint32_t Send(std::string_view name, const Encoder& encode);

  /// The next answer to a request that was sent. @pre nobody forgets it meanwhile.
  /// @returns nothing when none came within `timeout`.
  /// @throws RobotFault when the connection is lost before one came.
  [[nodiscard]] std::optional<Answer> Await(std::uint32_t id, std::string_view name,
                                            Duration timeout);

  /// No answer to it is of interest any more.
  void Forget(std::uint32_t id);

  /// Whether the connection has ended. Real-time: noexcept, wait-free.
  [[nodiscard]] bool lost() const noexcept { return lost_.load(std::memory_order_acquire); }
  /// Why, for people; empty while it has not.
  [[nodiscard]] std::string WhyLost() const;

 private:
  void Run(const std::stop_token& stop);
  void ReceiveSome();
  void Dispatch(const Frame& frame);
  void Lose(std::string why);
  void SendAll(std::string_view name, std::span<const std::byte> bytes);
  void Keep(const Endpoint& from, const Endpoint& to, std::span<const std::byte> bytes);
  [[nodiscard]] std::string TextLocked(std::string_view name) const;

  TcpStream stream_;
  const std::string peer_;
  const Duration timeout_;
  Capture* const capture_;
  const SideSocket side_;
  FrameReader reader_;    ///< the reader thread's
  FileDescriptor awake_;  ///< written to end the reader thread

  std::mutex sending_;  ///< one frame after the other; before mutex_
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint32_t next_id_ = 0;                             ///< guarded by sending_
  std::map<std::uint32_t, std::deque<Answer>> requests_;  ///< guarded by mutex_
  std::string why_lost_;                                  ///< guarded by mutex_
  std::atomic<bool> lost_ = false;  ///< release after why_lost_ was written, acquire by readers
  std::jthread thread_;
};

}  // namespace twin::fci
