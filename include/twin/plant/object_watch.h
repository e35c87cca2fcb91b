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

/// Who bears a free body: what it touches.
struct Support {
  bool left_finger = false;
  bool right_finger = false;
  bool robot = false;  ///< another part of the robot
  bool world = false;  ///< anything else
  bool operator==(const Support&) const = default;

  [[nodiscard]] bool between_fingers() const noexcept { return left_finger && right_finger; }
  [[nodiscard]] bool none() const noexcept { return *this == Support(); }
};

/// Where a free body is.
struct ObjectSample {
  Time at{};
  Transform X_WB = kIdentityTransform;  ///< in the world; without a mobile base that is the robot's
  Transform X_HB = kIdentityTransform;  ///< in the hand's frame (body panda_hand)
  double speed = 0;                     ///< of its centre of mass, m/s
  double turn_rate = 0;                 ///< rad/s
};

/// A change of what bears a free body.
struct SupportChange {
  Time at{};
  Support now;
};

/// What it touched that is no part of the robot.
struct ObjectContact {
  std::string part;  ///< as ContactPair's
  Time first{};
  Time last{};
};

/// What became of a free body in a run.
struct ObjectTrack {
  std::string body;
  std::vector<ObjectSample> samples;   ///< every kSampleLooks looks
  ObjectSample last;                   ///< of the last look
  std::vector<SupportChange> changes;  ///< from the first look on, which is always one
  std::vector<ObjectContact> touched;  ///< in the order in which it first touched
  std::uint64_t missed_changes = 0;    ///< beyond those that are kept
};

/// What became of the bodies that move freely, by the engine's own figures: ground truth, for the
/// report of a run and for tests, never for what controls it.
///
/// Threads: Look() from the plant's thread; the others once it has ended. Real-time: Look() is
/// noexcept, O(contacts + free bodies), allocates nothing.
class ObjectWatch {
 public:
  static constexpr std::size_t kMostBodies = 8;  ///< more are not watched
  static constexpr std::uint64_t kSampleLooks = 10;
  static constexpr std::size_t kMostSamples = 18'000;  ///< three minutes at 1 kHz; later: none
  static constexpr std::size_t kMostChanges = 4096;
  static constexpr std::size_t kMostParts = 16;

  /// @param truth  must outlive the watch.
  explicit ObjectWatch(const TruthProbe& truth);

  /// Notes where they are and what they touch. Once per cycle.
  void Look(Time now) noexcept TWIN_REALTIME;

  /// @returns one for each free body, in the order of the model.
  [[nodiscard]] std::vector<ObjectTrack> Tracks() const;

 private:
  /// What a shape is to a body that touches it.
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
  int hand_ = -1;  ///< body; -1: there is none
  std::vector<Kind> kind_of_geom_;
  std::vector<int> part_of_geom_;
  std::vector<int> watched_of_body_;  ///< -1: not watched
  std::map<int, std::string> names_;
  std::vector<Watched> watched_;
  std::uint64_t looks_ = 0;
};

}  // namespace twin::plant
