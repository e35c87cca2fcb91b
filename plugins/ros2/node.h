#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "plugins/ros2/cdr.h"
#include "plugins/ros2/dds.h"
#include "plugins/ros2/type_description.h"
#include "twin/core/clock.h"

namespace twin::ros2 {

/// How a service's replies find their requests.
enum class ServiceMapping : std::uint8_t {
  kByVendor,  ///< as the client's implementation of DDS does it
  kHeader,    ///< by a header in the payload, as rmw_cyclonedds: for clients that do it on others
};

struct NodeOptions {
  std::string name = "panda_twin";
  std::string name_space = "/";  ///< "/" or "/left"
  DdsOptions dds{};
  ServiceMapping mapping = ServiceMapping::kByVendor;
  bool is_humble = false;  ///< the graph's messages are Humble's, not those of Iron and later
  /// Receives a line about what people should know; any thread.
  std::function<void(std::string_view line)> tell{};
};

/// Writes messages of one type. Threads: any.
template <Message M>
class Publisher {
 public:
  explicit Publisher(std::unique_ptr<Writer> writer) : writer_(std::move(writer)) {}
  void Publish(const M& message) { writer_->Write(ToBytes(message)); }
  [[nodiscard]] bool has_readers() const { return writer_->readers() > 0; }

 private:
  std::unique_ptr<Writer> writer_;
};

/// A node of the ROS 2 graph, without ROS: topics and services by the names, qualities and types
/// that rmw gives them, and its entry in the graph (ros_discovery_info).
///
/// Life: construct -> Advertise, Subscribe, Serve -> Announce -> ... The node is in the graph from
/// Announce() on. Handlers must not outlive what they use: End() waits for them and no more come.
///
/// Threads: one until Announce(); Post() any. What Serve() and Post() are given runs on the node's
/// own thread, one after the other. Source: REP 2016, and the names as rmw_fastrtps_cpp 8 has them.
class Node {
 public:
  /// @throws InputError for a name that ROS 2 does not permit; EnvironmentError as Join.
  explicit Node(NodeOptions options);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// A name in full: "/x" stays, "~/x" is below the node, "x" below its namespace.
  [[nodiscard]] std::string Resolve(std::string_view name) const;

  template <Message M>
  [[nodiscard]] std::unique_ptr<Publisher<M>> Advertise(std::string_view name,
                                                        const Quality& quality) {
    return std::make_unique<Publisher<M>>(MakeWriter(
        {.name = "rt" + Resolve(name), .type = DdsName(NameOf<M>()), .hash = Describe<M>().Hash()},
        quality));
  }

  /// @param use  called as use(M&&, Guid writer) on a thread of DDS; it must return soon. Bytes
  /// that are no such message are told of, once.
  template <Message M, typename Use>
  void Subscribe(std::string_view name, const Quality& quality, Use use) {
    MakeReader(
        {.name = "rt" + Resolve(name), .type = DdsName(NameOf<M>()), .hash = Describe<M>().Hash()},
        quality, [this, use, topic = Resolve(name)](const Sample& sample) {
          std::optional<M> message = FromBytes<M>(sample.bytes);
          if (!message) return TellOfGarbage(topic);
          use(std::move(*message), sample.identity.writer);
        });
  }

  /// @param answer  called as answer(Request&&, reply) on the node's thread; it calls
  /// reply(Response), then or later, there or elsewhere.
  template <typename S, typename Answer>
  void Serve(std::string_view name, Answer answer) {
    using Request = typename S::Request;
    using Response = typename S::Response;
    const std::string full = Resolve(name);
    Writer* const replies = MakeReplies({.name = "rr" + full + "Reply",
                                         .type = DdsName(NameOf<Response>()),
                                         .hash = Describe<Response>().Hash()});
    const auto use = [this, answer, full, replies](const Sample& sample) {
      const Asker asker = AskerOf(sample);
      std::optional<Request> request = FromBytes<Request>(WithoutHeader(sample.bytes, asker));
      if (!request) return TellOfGarbage(full);
      const auto reply = [this, replies, asker](const Response& response) {
        Reply(*replies, asker, ToBytes(response));
      };
      PostRequest([answer, reply, request = std::make_shared<Request>(std::move(*request))] {
        answer(std::move(*request), reply);
      });
    };
    MakeReader({.name = "rq" + full + "Request",
                .type = DdsName(NameOf<Request>()),
                .hash = Describe<Request>().Hash()},
               {}, use);
  }

  /// Tells the graph of all endpoints there are.
  void Announce();

  /// Runs `task` on the node's thread.
  void Post(std::function<void()> task);
  /// Ends the node's thread, and what others send is used no more. Idempotent.
  void End();

  void Tell(std::string_view line) const {
    if (options_.tell) options_.tell(line);
  }

 private:
  /// Who asked, as the reply must name it.
  struct Asker {
    SampleIdentity identity;
    std::optional<std::array<std::byte, 16>> header;  ///< of the payload, to be echoed
  };
  struct Waiting {
    Writer* writer;
    Asker asker;
    std::vector<std::byte> bytes;
    Time until{};
  };

  [[nodiscard]] std::unique_ptr<Writer> MakeWriter(const WireTopic& topic, const Quality& quality);
  [[nodiscard]] Writer* MakeReplies(const WireTopic& topic);
  void MakeReader(const WireTopic& topic, const Quality& quality,
                  std::function<void(const Sample&)> use);
  [[nodiscard]] Asker AskerOf(const Sample& sample) const;
  [[nodiscard]] static std::vector<std::byte> WithoutHeader(const std::vector<std::byte>& bytes,
                                                            const Asker& asker);
  /// Once the asker's reader is known here: a reply sent before is lost.
  void Reply(Writer& writer, const Asker& asker, std::vector<std::byte> bytes);
  static void Send(const Waiting& reply);
  void TellOfGarbage(const std::string& topic);
  void Run(const std::stop_token& stop);
  /// As Post(), unless too many wait.
  void PostRequest(std::function<void()> task);
  /// Sends what can be sent now. @returns whether some is left.
  bool SendWaiting();

  const NodeOptions options_;
  const MonotonicClock clock_;
  std::unique_ptr<Participant> participant_;
  std::unique_ptr<Writer> graph_;
  std::vector<std::unique_ptr<Writer>> replies_;
  std::vector<std::unique_ptr<Reader>> readers_;
  std::vector<Guid> writer_guids_;
  std::mutex mutex_;  ///< guards the following, but for the node's thread
  std::condition_variable_any wake_;
  std::deque<std::function<void()>> tasks_;
  std::vector<Waiting> waiting_;
  std::vector<std::string> told_;  ///< topics whose garbage was told of
  std::jthread thread_;
};

}  // namespace twin::ros2
