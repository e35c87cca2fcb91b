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

/// A second socket that the channel's reader thread polls.
struct SideSocket {
  int fd = -1;
  /// Called when the socket may be readable, and between receiving stream bytes and parsing them:
  /// what the peer sent here before an answer is drained before the answer.
  std::function<void()> drain;
};

/// The TCP side of a client: sends requests and returns each answer to its caller.
///
///     any thread: Send() ---TCP---> peer          reader thread: bytes -> frames -> answers by id
///                 Await(id) <---- condition ------------------------------------------+
///
/// Matches answers by command_id, in any order, and discards answers without a pending request.
/// Memory is bounded: two answers per pending request. The end of the connection wakes all waiting
/// threads, so none waits forever.
///
/// Threads: any. The reader thread ends with the object; the owner ensures that no thread waits
/// then. Not for real-time code, except lost().
class RequestChannel {
 public:
  /// Encodes a request with the given command_id.
  using Encoder = std::function<std::vector<std::byte>(std::uint32_t)>;

  /// A received answer.
  struct Answer {
    FrameHead head;
    std::vector<std::byte> payload;

    [[nodiscard]] Frame frame() const noexcept { return {head, payload}; }
  };

  /// @param peer      for messages: "the robot 127.0.0.1:1337".
  /// @param largest   largest accepted answer, bytes.
  /// @param timeout   of a Send() while the peer does not read.
  /// @param capture   records the stream's bytes; must outlive the channel. May be null.
  RequestChannel(HeadKind kind, TcpStream stream, std::string peer, std::size_t largest,
                 Duration timeout, Capture* capture, SideSocket side = {});
  ~RequestChannel();
  RequestChannel(const RequestChannel&) = delete;
  RequestChannel& operator=(const RequestChannel&) = delete;

  /// Sends a request and keeps its answers from then on. @returns its command_id, counted from 0.
  /// @throws RobotFault if the connection is lost.
  [[nodiscard]] std::uint32_t Send(std::string_view name, const Encoder& encode);

  /// Waits for the next answer to a request. @pre Forget(id) is not called meanwhile.
  /// @returns nullopt if none comes within `timeout`.
  /// @throws RobotFault if the connection is lost before an answer.
  [[nodiscard]] std::optional<Answer> Await(std::uint32_t id, std::string_view name,
                                            Duration timeout);

  /// Discards the request's further answers.
  void Forget(std::uint32_t id);

  /// True once the connection has ended. Real-time: noexcept, wait-free.
  [[nodiscard]] bool lost() const noexcept { return lost_.load(std::memory_order_acquire); }
  /// Why the connection ended, for users; empty while it is up.
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
  FrameReader reader_;    ///< owned by the reader thread
  FileDescriptor awake_;  ///< written to end the reader thread

  std::mutex sending_;  ///< serialises frames; locked before mutex_
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint32_t next_id_ = 0;                             ///< guarded by sending_
  std::map<std::uint32_t, std::deque<Answer>> requests_;  ///< guarded by mutex_
  std::string why_lost_;                                  ///< guarded by mutex_
  std::atomic<bool> lost_ = false;  ///< release after why_lost_ was written, acquire by readers
  std::jthread thread_;
};

}  // namespace twin::fci
