#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/truth_probe.h"

namespace twin::plant {

/// Parts that a free body touches and that may support it.
struct Support {
  bool left_finger = false;
  bool right_finger = false;
  bool robot = false;  ///< another part of the robot
  bool world = false;  ///< any other part
  bool operator==(const Support&) const = default;

  [[nodiscard]] bool between_fingers() const noexcept { return left_finger && right_finger; }
  [[nodiscard]] bool none() const noexcept { return *this == Support(); }
};

/// Pose of a free body.
struct ObjectSample {
  Time at{};
  Transform X_WB = kIdentityTransform;  ///< in the world; the robot's base O without a mobile base
  Transform X_HB = kIdentityTransform;  ///< in the hand's frame (body panda_hand)
  double speed = 0;                     ///< of its centre of mass, m/s
  double turn_rate = 0;                 ///< rad/s
};

/// A change of a free body's support.
struct SupportChange {
  Time at{};
  Support now;
};

/// First contact of a free body with a part outside the robot.
struct ObjectContact {
  std::string part;  ///< as in ContactPair
  Time first{};
  Time last{};
};

/// Record of a free body over a run.
struct ObjectTrack {
  std::string body;
  std::vector<ObjectSample> samples;   ///< every kSampleLooks looks
  ObjectSample last;                   ///< at the last look
  std::vector<SupportChange> changes;  ///< from the first look on, which always counts as one
  std::vector<ObjectContact> touched;  ///< in the order of first contact
  std::uint64_t missed_changes = 0;    ///< not stored
};

/// Tracks the freely moving bodies with the engine's data: ground truth for a run's report and
/// tests, never for control.
///
/// Threads: Look() from the plant's thread; the others after it has ended. Real-time: Look() is
/// noexcept, O(contacts + free bodies), allocates nothing.
class ObjectWatch {
 public:
  static constexpr std::size_t kMostBodies = 8;  ///< further bodies are not tracked
  static constexpr std::uint64_t kSampleLooks = 10;
  static constexpr std::size_t kMostSamples = 18'000;  ///< three minutes at 1 kHz; no later ones
  static constexpr std::size_t kMostChanges = 4096;
  static constexpr std::size_t kMostParts = 16;

  /// @param truth  must outlive the watch.
  explicit ObjectWatch(const TruthProbe& truth);

  /// Records poses and contacts. Once per cycle.
  void Look(Time now) noexcept TWIN_REALTIME;

  /// @returns one per free body, in the order of the model.
  [[nodiscard]] std::vector<ObjectTrack> Tracks() const;

 private:
  /// Role of a shape in contact with a free body.
  enum class Kind : std::uint8_t { kWorld, kRobot, kLeftFinger, kRightFinger };
  struct Part {
    int id = 0;
    Time first{};
    Time last{};
  };
  struct Watched {
    int body = 0;
    std::vector<ObjectSample> samples;
    ObjectSample last;
    std::vector<SupportChange> changes;
    std::uint64_t missed_changes = 0;
    std::array<Part, kMostParts> parts{};
    std::size_t part_count = 0;
    Support now;
  };

  void Note(Watched& watched, int geom, Time now) noexcept;
  void Sample(Watched& watched, Time now) noexcept;

  const TruthProbe& truth_;
  int hand_ = -1;  ///< body; -1: none
  std::vector<Kind> kind_of_geom_;
  std::vector<int> part_of_geom_;
  std::vector<int> watched_of_body_;  ///< -1: not watched
  std::map<int, std::string> names_;
  std::vector<Watched> watched_;
  std::uint64_t looks_ = 0;
};

}  // namespace twin::plant
