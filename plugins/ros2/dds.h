#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// The seam to DDS: bytes out, bytes in with their sender's identity. Nothing else of this folder
// names an implementation; fast_dds.cc has the one there is.
namespace twin::ros2 {

/// Where other participants are looked for.
enum class Discovery : std::uint8_t {
  kThisMachine,  ///< by unicast to 127.0.0.1: what ROS 2 calls LOCALHOST
  kSubnet,       ///< by multicast too: every machine that it reaches can send commands
};

struct DdsOptions {
  int domain = 0;  ///< ROS_DOMAIN_ID, in [0, 232]
  Discovery discovery = Discovery::kThisMachine;
};

/// Of an endpoint or a participant. The first two bytes name the implementation's vendor.
using Guid = std::array<std::uint8_t, 16>;

/// Identity of a sample: its writer, and its number among the writer's samples.
struct SampleIdentity {
  Guid writer{};  ///< all zero: none
  std::int64_t number = 0;
  bool operator==(const SampleIdentity&) const = default;
};

/// A message that came.
struct Sample {
  std::vector<std::byte> bytes;  ///< with the encapsulation's four bytes
  SampleIdentity identity;
  SampleIdentity related;  ///< that the sender gave with it
};

struct Quality {
  bool is_reliable = true;
  bool is_latched = false;  ///< transient local: late joiners get the last ones
  std::int32_t depth = 10;  ///< keep last
  bool is_large = false;    ///< longer than a datagram: sent by a thread of DDS
  bool operator==(const Quality&) const = default;
};

/// An endpoint's topic and type, as they are called on the wire.
struct WireTopic {
  std::string name;  ///< "rt/joint_states"
  std::string type;  ///< DdsName()
  std::string hash;  ///< TypeDescription::Hash()
};

/// Threads: any. Errors: none; what cannot be sent is lost.
class Writer {
 public:
  virtual ~Writer() = default;
  [[nodiscard]] virtual Guid guid() const = 0;
  virtual void Write(std::span<const std::byte> bytes) = 0;
  /// A reply. @param request  whose identity goes with it.
  virtual void Write(std::span<const std::byte> bytes, const SampleIdentity& request) = 0;
  /// Readers that receive what is written now.
  [[nodiscard]] virtual std::size_t readers() const = 0;
  /// Whether the reader `guid` receives what is written; of a writer, a reader of its participant.
  [[nodiscard]] virtual bool Reaches(const Guid& guid) const = 0;
};

class Reader {
 public:
  virtual ~Reader() = default;
  [[nodiscard]] virtual Guid guid() const = 0;
};

/// Receives a sample on a thread of DDS: it must return soon. It may write.
using OnSample = std::function<void(Sample&&)>;
/// Receives a line when another's endpoint fits the topic but not the quality; on a thread of DDS.
using OnMisfit = std::function<void(std::string_view line)>;

/// One of a DDS domain. Writers and readers end before it.
///
/// Threads: one.
class Participant {
 public:
  virtual ~Participant() = default;
  [[nodiscard]] virtual Guid guid() const = 0;
  /// @throws EnvironmentError when DDS refuses; likewise below.
  [[nodiscard]] virtual std::unique_ptr<Writer> MakeWriter(const WireTopic& topic,
                                                           const Quality& quality,
                                                           OnMisfit misfit) = 0;
  [[nodiscard]] virtual std::unique_ptr<Reader> MakeReader(const WireTopic& topic,
                                                           const Quality& quality, OnSample use,
                                                           OnMisfit misfit) = 0;
};

/// Joins a domain. @throws EnvironmentError when DDS refuses.
[[nodiscard]] std::unique_ptr<Participant> Join(const DdsOptions& options);

}  // namespace twin::ros2
