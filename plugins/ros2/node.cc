#include "plugins/ros2/node.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <regex>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::ros2 {
namespace {

/// Of requests that wait to be answered; more is a fault or an attack.
constexpr std::size_t kMostTasks = 10'000;
/// For the graph to tell of a client's reader.
constexpr twin::Duration kUntilReaderIsKnown = std::chrono::seconds(2);
constexpr auto kRetry = std::chrono::milliseconds(1);
constexpr std::array<std::uint8_t, 2> kCyclone{0x01, 0x10};
constexpr std::size_t kHeaderBytes = 16;

template <std::size_t N>
msg::GidOf<N> GidOf(const Guid& guid) {
  msg::GidOf<N> gid;
  std::ranges::copy(guid, gid.data.begin());
  return gid;
}

/// What a participant tells the graph of its one node.
template <std::size_t N>
std::vector<std::byte> GraphEntry(const NodeOptions& options, const Guid& participant,
                                  const std::vector<Guid>& readers,
                                  const std::vector<Guid>& writers) {
  msg::NodeEntitiesInfoOf<N> node;
  node.node_namespace.text = options.name_space;
  node.node_name.text = options.name;
  for (const Guid& reader : readers) node.reader_gid_seq.push_back(GidOf<N>(reader));
  for (const Guid& writer : writers) node.writer_gid_seq.push_back(GidOf<N>(writer));
  msg::ParticipantEntitiesInfoOf<N> info{.gid = GidOf<N>(participant),
                                         .node_entities_info_seq = {}};
  info.node_entities_info_seq.push_back(std::move(node));
  return ToBytes(info);
}

void RequireNames(const NodeOptions& options) {
  static const std::regex kName("[A-Za-z_][A-Za-z0-9_]*");
  static const std::regex kNameSpace("/|(/[A-Za-z_][A-Za-z0-9_]*)+");
  if (!std::regex_match(options.name, kName)) {
    throw InputError(
        fmt::format("ROS 2 permits no node called '{}': letters, digits and '_', no digit first",
                    options.name));
  }
  if (!std::regex_match(options.name_space, kNameSpace)) {
    throw InputError(fmt::format(
        "ROS 2 permits no namespace '{}': it begins with '/', and between slashes stand letters, "
        "digits and '_', no digit first, such as /left",
        options.name_space));
  }
  if (options.dds.domain < 0 || options.dds.domain > 232) {
    throw InputError(fmt::format("ROS_DOMAIN_ID is {}; domains are 0 to 232", options.dds.domain));
  }
}

}  // namespace

Node::Node(NodeOptions options) : options_(std::move(options)) {
  RequireNames(options_);
  participant_ = Join(options_.dds);
  graph_ = participant_->MakeWriter({.name = "ros_discovery_info",
                                     .type = DdsName(msg::ParticipantEntitiesInfo::kName),
                                     .hash = Describe<msg::ParticipantEntitiesInfo>().Hash()},
                                    {.is_reliable = true, .is_latched = true, .depth = 1}, {});
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

Node::~Node() {
  End();
}

void Node::End() {
  readers_.clear();
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
}

std::string Node::Resolve(std::string_view name) const {
  const std::string below = options_.name_space == "/" ? "/" : options_.name_space + "/";
  if (name.starts_with('/')) return std::string(name);
  if (name.starts_with("~/")) return below + options_.name + std::string(name.substr(1));
  return below + std::string(name);
}

std::unique_ptr<Writer> Node::MakeWriter(const WireTopic& topic, const Quality& quality) {
  auto writer = participant_->MakeWriter(topic, quality, options_.tell);
  writer_guids_.push_back(writer->guid());
  return writer;
}

Writer* Node::MakeReplies(const WireTopic& topic) {
  return replies_.emplace_back(MakeWriter(topic, {})).get();
}

void Node::MakeReader(const WireTopic& topic, const Quality& quality,
                      std::function<void(const Sample&)> use) {
  readers_.push_back(participant_->MakeReader(
      topic, quality, [use = std::move(use)](Sample&& sample) { use(sample); }, options_.tell));
}

void Node::Announce() {
  std::vector<Guid> readers;
  for (const auto& reader : readers_) readers.push_back(reader->guid());
  const auto entry = options_.is_humble ? &GraphEntry<24> : &GraphEntry<16>;
  graph_->Write(entry(options_, participant_->guid(), readers, writer_guids_));
}

Node::Asker Node::AskerOf(const Sample& sample) const {
  Asker asker{.identity = sample.identity, .header = {}};
  const bool is_cyclone =
      std::equal(kCyclone.begin(), kCyclone.end(), sample.identity.writer.begin());
  if (is_cyclone || options_.mapping == ServiceMapping::kHeader) {
    if (sample.bytes.size() < kEncapsulationBytes + kHeaderBytes) return asker;
    std::copy_n(sample.bytes.begin() + kEncapsulationBytes, kHeaderBytes,
                asker.header.emplace().begin());
    return asker;
  }
  // A client may name the reader of its replies; else they go to all of its participant's.
  if (sample.related.writer != Guid()) asker.identity.writer = sample.related.writer;
  return asker;
}

std::vector<std::byte> Node::WithoutHeader(const std::vector<std::byte>& bytes,
                                           const Asker& asker) {
  std::vector<std::byte> rest = bytes;
  if (!asker.header) return rest;
  rest.erase(rest.begin() + kEncapsulationBytes, rest.begin() + kEncapsulationBytes + kHeaderBytes);
  return rest;
}

void Node::Reply(Writer& writer, const Asker& asker, std::vector<std::byte> bytes) {
  Waiting reply{&writer, asker, std::move(bytes), clock_.Now() + kUntilReaderIsKnown};
  if (asker.header) {
    reply.bytes.insert(reply.bytes.begin() + kEncapsulationBytes, asker.header->begin(),
                       asker.header->end());
  }
  if (writer.Reaches(asker.identity.writer)) return Send(reply);
  const std::lock_guard lock(mutex_);
  waiting_.push_back(std::move(reply));
  wake_.notify_one();
}

void Node::Send(const Waiting& reply) {
  reply.writer->Write(reply.bytes, reply.asker.identity);
}

bool Node::SendWaiting() {
  const Time now = clock_.Now();
  const std::lock_guard lock(mutex_);
  std::erase_if(waiting_, [now](const Waiting& reply) {
    const bool is_known = reply.writer->Reaches(reply.asker.identity.writer);
    if (is_known) Send(reply);
    return is_known || now >= reply.until;  // then the client has gone
  });
  return !waiting_.empty();
}

void Node::TellOfGarbage(const std::string& topic) {
  {
    const std::lock_guard lock(mutex_);
    if (std::ranges::find(told_, topic) != told_.end()) return;
    told_.push_back(topic);
  }
  Tell(
      fmt::format("ROS 2: {}: a message that is none of its type is ignored; see which node sends "
                  "it (ros2 topic info -v); more of them are not told of",
                  topic));
}

void Node::Post(std::function<void()> task) {
  const std::lock_guard lock(mutex_);
  tasks_.push_back(std::move(task));
  wake_.notify_one();
}

void Node::PostRequest(std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    if (tasks_.size() >= kMostTasks) return;
  }
  Post(std::move(task));
}

void Node::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const bool retries = SendWaiting();
    std::function<void()> task;
    {
      std::unique_lock lock(mutex_);
      const auto has_work = [this] { return !tasks_.empty(); };
      if (retries) {
        wake_.wait_for(lock, stop, kRetry, has_work);
      } else {
        wake_.wait(lock, stop, [this] { return !tasks_.empty() || !waiting_.empty(); });
      }
      if (tasks_.empty()) continue;
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    try {
      task();
    } catch (const std::exception& error) {
      Tell(fmt::format("ROS 2: a request failed, and is not answered: {}", error.what()));
    }
  }
}

}  // namespace twin::ros2
