#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fastdds/rtps/common/WriteParams.h>
#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/TransportReceiverInterface.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <fmt/format.h>

#include "plugins/ros2/cdr.h"
#include "plugins/ros2/dds.h"
#include "plugins/ros2/rtps_gate.h"
#include "twin/core/error.h"

// Four settings decide whether ROS 2 (Jazzy, Kilted) and Debian 12's Fast DDS 2.9.1 understand each
// other: no shared memory, whose segments have another layout there and end the process; no type
// information in discovery; the user data by which rmw knows a ROS participant and its type hashes;
// no data sharing.
namespace twin::ros2 {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
namespace fast_rtps = eprosima::fastdds::rtps;

using Bytes = std::vector<std::byte>;

/// Initial peers, counted by participants: so many programs of a machine find each other.
constexpr std::uint32_t kMostPeers = 32;

Guid GuidOf(const rtps::GUID_t& guid) {
  Guid made{};
  std::copy_n(guid.guidPrefix.value, 12, made.begin());
  std::copy_n(guid.entityId.value, 4, made.begin() + 12);
  return made;
}

rtps::GUID_t FastGuidOf(const Guid& guid) {
  rtps::GUID_t made;
  std::copy_n(guid.begin(), 12, made.guidPrefix.value);
  std::copy_n(guid.begin() + 12, 4, made.entityId.value);
  return made;
}

SampleIdentity IdentityOf(const rtps::SampleIdentity& identity) {
  return {.writer = GuidOf(identity.writer_guid()),
          .number = static_cast<std::int64_t>(identity.sequence_number().to64long())};
}

template <typename T>
T* Require(T* made, std::string_view what) {
  if (made == nullptr) {
    throw EnvironmentError(fmt::format(
        "ROS 2: DDS made no {}; see its own message above, and whether this host has a network",
        what));
  }
  return made;
}

/// "typehash=RIHS01_...;"
std::vector<rtps::octet> UserData(const std::string& text) {
  return {text.begin(), text.end()};
}

/// Messages whose bytes are made and read elsewhere.
class ByteType final : public dds::TopicDataType {
 public:
  explicit ByteType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 512;  // at first; more is allocated when needed
    m_isGetKeyDefined = false;
    auto_fill_type_information(false);
    auto_fill_type_object(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    if (bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    if (payload->length > kMostMessageBytes) return false;
    const auto* from = reinterpret_cast<const std::byte*>(payload->data);
    static_cast<Bytes*>(data)->assign(from, from + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes(); }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void* /*data*/, rtps::InstanceHandle_t* /*handle*/, bool /*force_md5*/) override {
    return false;
  }
};

/// The settings that writers' and readers' qualities have in common.
template <typename Qos>
void Set(Qos& qos, const WireTopic& topic, const Quality& quality) {
  qos.reliability().kind =
      quality.is_reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind =
      quality.is_latched ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = quality.depth;
  qos.data_sharing().off();
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.user_data().data_vec(UserData(fmt::format("typehash={};", topic.hash)));
}

std::string MisfitLine(std::string_view topic, dds::QosPolicyId_t policy) {
  const char* what = policy == dds::RELIABILITY_QOS_POLICY_ID  ? "reliability"
                     : policy == dds::DURABILITY_QOS_POLICY_ID ? "durability"
                                                               : "quality of service";
  return fmt::format("{}: another node's {} does not fit ours; nothing goes between them", topic,
                     what);
}

class FastWriter final : public Writer, private dds::DataWriterListener {
 public:
  FastWriter(dds::Publisher& publisher, dds::Topic& topic, const WireTopic& wire,
             const Quality& quality, OnMisfit misfit)
      : publisher_(publisher), topic_(wire.name), misfit_(std::move(misfit)) {
    dds::DataWriterQos qos;
    Set(qos, wire, quality);
    if (quality.is_large) qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
    writer_ = Require(publisher.create_datawriter(&topic, qos, this), "writer of " + wire.name);
  }
  ~FastWriter() override {
    writer_->set_listener(nullptr);
    publisher_.delete_datawriter(writer_);
  }
  FastWriter(const FastWriter&) = delete;
  FastWriter& operator=(const FastWriter&) = delete;

  [[nodiscard]] Guid guid() const override { return GuidOf(writer_->guid()); }
  void Write(std::span<const std::byte> bytes) override {
    Bytes data(bytes.begin(), bytes.end());
    writer_->write(&data);
  }
  void Write(std::span<const std::byte> bytes, const SampleIdentity& request) override {
    Bytes data(bytes.begin(), bytes.end());
    rtps::WriteParams parameters;
    parameters.related_sample_identity().writer_guid(FastGuidOf(request.writer));
    parameters.related_sample_identity().sequence_number(
        rtps::SequenceNumber_t(static_cast<std::int32_t>(request.number >> 32),
                               static_cast<std::uint32_t>(request.number)));
    writer_->write(&data, parameters);
  }
  [[nodiscard]] std::size_t readers() const override {
    return matched_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] bool Reaches(const Guid& guid) const override {
    const bool is_reader = (guid[15] & 0x3f) == 0x04 || (guid[15] & 0x3f) == 0x07;
    const std::lock_guard lock(mutex_);
    return std::ranges::any_of(readers_, [&](const Guid& reader) {
      return std::equal(reader.begin(), reader.begin() + (is_reader ? 16 : 12), guid.begin());
    });
  }

 private:
  void on_publication_matched(dds::DataWriter* /*writer*/,
                              const dds::PublicationMatchedStatus& status) override {
    const Guid reader = GuidOf(rtps::iHandle2GUID(status.last_subscription_handle));
    const std::lock_guard lock(mutex_);
    if (status.current_count_change > 0) readers_.insert(reader);
    if (status.current_count_change < 0) readers_.erase(reader);
    matched_.store(readers_.size(), std::memory_order_relaxed);
  }
  void on_offered_incompatible_qos(dds::DataWriter* /*writer*/,
                                   const dds::OfferedIncompatibleQosStatus& status) override {
    if (misfit_) misfit_(MisfitLine(topic_, status.last_policy_id));
  }

  dds::Publisher& publisher_;
  const std::string topic_;
  const OnMisfit misfit_;
  mutable std::mutex mutex_;  ///< guards readers_
  std::set<Guid> readers_;
  std::atomic<std::size_t> matched_{0};
  dds::DataWriter* writer_ = nullptr;
};

class FastReader final : public Reader, private dds::DataReaderListener {
 public:
  FastReader(dds::Subscriber& subscriber, dds::Topic& topic, const WireTopic& wire,
             const Quality& quality, OnSample use, OnMisfit misfit)
      : subscriber_(subscriber),
        topic_(wire.name),
        use_(std::move(use)),
        misfit_(std::move(misfit)) {
    dds::DataReaderQos qos;
    Set(qos, wire, quality);
    reader_ = Require(subscriber.create_datareader(&topic, qos, this), "reader of " + wire.name);
  }
  ~FastReader() override {
    reader_->set_listener(nullptr);
    subscriber_.delete_datareader(reader_);
  }
  FastReader(const FastReader&) = delete;
  FastReader& operator=(const FastReader&) = delete;

  [[nodiscard]] Guid guid() const override { return GuidOf(reader_->guid()); }

 private:
  void on_data_available(dds::DataReader* reader) override {
    Sample sample;
    dds::SampleInfo info;
    while (reader->take_next_sample(&sample.bytes, &info) ==
           eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      sample.identity = IdentityOf(info.sample_identity);
      sample.related = IdentityOf(info.related_sample_identity);
      use_(std::move(sample));
      sample = {};
    }
  }
  void on_requested_incompatible_qos(dds::DataReader* /*reader*/,
                                     const dds::RequestedIncompatibleQosStatus& status) override {
    if (misfit_) misfit_(MisfitLine(topic_, status.last_policy_id));
  }

  dds::Subscriber& subscriber_;
  const std::string topic_;
  const OnSample use_;
  const OnMisfit misfit_;
  dds::DataReader* reader_ = nullptr;
};

struct GatedTransportDescriptor final : fast_rtps::ChainingTransportDescriptor {
  GatedTransportDescriptor(std::shared_ptr<fast_rtps::TransportDescriptorInterface> udp, bool own)
      : ChainingTransportDescriptor(std::move(udp)), own_machine(own) {}
  const bool own_machine;  ///< drop what comes from others
  fast_rtps::TransportInterface* create_transport() const override;
};

/// UDP of which DDS reads what is well-formed, and comes from this machine where no other may
/// speak. (DDS's own list of interfaces would do the latter, and then finds no node of ROS.)
class GatedTransport final : public fast_rtps::ChainingTransport {
 public:
  explicit GatedTransport(const GatedTransportDescriptor& descriptor)
      : ChainingTransport(descriptor), descriptor_(descriptor) {}

  fast_rtps::TransportDescriptorInterface* get_configuration() override { return &descriptor_; }
  bool send(rtps::SenderResource* sender, const rtps::octet* bytes, std::uint32_t size,
            rtps::LocatorsIterator* begin, rtps::LocatorsIterator* end,
            const std::chrono::steady_clock::time_point& timeout) override {
    return sender->send(bytes, size, begin, end, timeout);
  }
  void receive(fast_rtps::TransportReceiverInterface* receiver, const rtps::octet* bytes,
               std::uint32_t size, const rtps::Locator_t& local,
               const rtps::Locator_t& remote) override {
    if (descriptor_.own_machine && !is_local_locator(remote)) return;
    const std::size_t readable = ReadableBytes(std::as_bytes(std::span(bytes, size)));
    if (readable == 0) return;
    receiver->OnDataReceived(bytes, static_cast<std::uint32_t>(readable), local, remote);
  }

 private:
  GatedTransportDescriptor descriptor_;
};

fast_rtps::TransportInterface* GatedTransportDescriptor::create_transport() const {
  return new GatedTransport(*this);
}

dds::DomainParticipantQos ParticipantQos(const DdsOptions& options) {
  dds::DomainParticipantQos qos;
  qos.name("panda-twin");
  qos.user_data().data_vec(UserData("enclave=/;"));
  qos.transport().use_builtin_transports = false;
  const auto udp = std::make_shared<fast_rtps::UDPv4TransportDescriptor>();
  udp->maxInitialPeersRange = kMostPeers;
  const bool own_machine = options.discovery == Discovery::kThisMachine;
  qos.transport().user_transports.push_back(
      std::make_shared<GatedTransportDescriptor>(udp, own_machine));
  if (!own_machine) return qos;
  rtps::Locator_t loopback;
  loopback.kind = LOCATOR_KIND_UDPv4;
  rtps::IPLocator::setIPv4(loopback, 127, 0, 0, 1);
  auto& builtin = qos.wire_protocol().builtin;
  builtin.avoid_builtin_multicast = true;
  builtin.metatrafficUnicastLocatorList.push_back(loopback);
  builtin.initialPeersList.push_back(loopback);
  qos.wire_protocol().default_unicast_locator_list.push_back(loopback);
  return qos;
}

class FastParticipant final : public Participant {
 public:
  explicit FastParticipant(const DdsOptions& options)
      : participant_(Require(dds::DomainParticipantFactory::get_instance()->create_participant(
                                 static_cast<dds::DomainId_t>(options.domain),
                                 ParticipantQos(options), nullptr, dds::StatusMask::none()),
                             "participant")),
        publisher_(Require(participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT, nullptr),
                           "publisher")),
        subscriber_(Require(participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT, nullptr),
                            "subscriber")) {}
  ~FastParticipant() override {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  FastParticipant(const FastParticipant&) = delete;
  FastParticipant& operator=(const FastParticipant&) = delete;

  [[nodiscard]] Guid guid() const override { return GuidOf(participant_->guid()); }
  [[nodiscard]] std::unique_ptr<Writer> MakeWriter(const WireTopic& topic, const Quality& quality,
                                                   OnMisfit misfit) override {
    return std::make_unique<FastWriter>(*publisher_, TopicOf(topic), topic, quality,
                                        std::move(misfit));
  }
  [[nodiscard]] std::unique_ptr<Reader> MakeReader(const WireTopic& topic, const Quality& quality,
                                                   OnSample use, OnMisfit misfit) override {
    return std::make_unique<FastReader>(*subscriber_, TopicOf(topic), topic, quality,
                                        std::move(use), std::move(misfit));
  }

 private:
  /// A participant has each topic once.
  dds::Topic& TopicOf(const WireTopic& wire) {
    if (auto* there = participant_->lookup_topicdescription(wire.name)) {
      return dynamic_cast<dds::Topic&>(*there);
    }
    dds::TypeSupport type(new ByteType(wire.type));
    type.register_type(participant_);
    return *Require(participant_->create_topic(wire.name, wire.type, dds::TOPIC_QOS_DEFAULT),
                    "topic " + wire.name);
  }

  dds::DomainParticipant* participant_;
  dds::Publisher* publisher_;
  dds::Subscriber* subscriber_;
};

}  // namespace

std::unique_ptr<Participant> Join(const DdsOptions& options) {
  return std::make_unique<FastParticipant>(options);
}

}  // namespace twin::ros2
