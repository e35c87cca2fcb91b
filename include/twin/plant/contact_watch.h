#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/object_watch.h"
#include "twin/plant/truth_probe.h"

namespace twin::plant {

/// Two parts that touched during a run. A part is a body of the model ("panda_link5", "box"), or a
/// single shape by its name if fixed to the world ("table").
struct ContactPair {
  std::string a;  ///< moves with the arm
  std::string b;
  Time first{};              ///< first time in contact
  std::uint64_t cycles = 0;  ///< number of looks in contact
};

/// A pair of parts that touches at an instant, or did shortly before.
struct NearContact {
  std::string a;  ///< moves with the arm, or is a free body that the arm touches
  std::string b;
  Vector3 p_W{};               ///< a point of the contact, the last one, in the world, m
  double force = 0;            ///< of the pair, the largest since then, N; 0: not known
  Time since{};                ///< begin of this contact
  std::optional<Time> last{};  ///< last cycle in contact, if it has ended
};

/// The contacts at an instant.
struct ContactMoment {
  Time at{};
  std::vector<NearContact> contacts;  ///< the strongest first

  /// "panda_leftfinger and floor at (0.512, 0.000, 0.001) m with up to 153 N, since 1.204 s; ...",
  /// or "none".
  [[nodiscard]] std::string Text() const;
};

/// Contacts of the arm during a run, from the engine: ground truth for a run's report and tests,
/// never for control. It counts pairs with at least one part that moves with the arm (its links
/// from 1 on, hand, fingers; of a mobile base all but its wheels). A box on a table does not count;
/// objects() tracks such bodies. While the arm touches the box, moments have both pairs: a held box
/// carries a table's force to the hand.
///
/// Threads: Look() and Keep() from the plant's thread; the others after it has ended. Real-time:
/// both are noexcept, O(contacts) and O(pairs), and allocate nothing.
class ContactWatch {
 public:
  /// Further pairs are only counted.
  static constexpr std::size_t kMostPairs = 64;
  /// Further moments are not kept, nor further contacts of a moment.
  static constexpr std::size_t kMostMoments = 64;
  static constexpr std::size_t kMostOfMoment = 6;
  /// Looks after its end for which a contact still belongs to a moment.
  static constexpr std::uint64_t kRecentLooks = 50;

  /// @param truth  must outlive the watch.
  explicit ContactWatch(const TruthProbe& truth);

  /// Records present contacts. Once per cycle.
  void Look(Time now) noexcept TWIN_REALTIME;

  /// Keeps the contacts of the last Look(), and those that ended shortly before, for Moments().
  void Keep(Time now) noexcept TWIN_REALTIME;

  /// @returns what Keep() kept, in the order of its calls.
  [[nodiscard]] std::vector<ContactMoment> Moments() const;
  /// @returns the pairs in the order of their first contact.
  [[nodiscard]] std::vector<ContactPair> Pairs() const;
  /// Number of looks with any contact of the arm.
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_; }
  [[nodiscard]] std::uint64_t looks() const noexcept { return looks_; }

  /// The freely moving bodies.
  [[nodiscard]] const ObjectWatch& objects() const noexcept { return objects_; }

 private:
  struct Seen {
    int a = 0;
    int b = 0;
    Time first{};
    Time since{};  ///< of the present or last contact
    Time last{};
    Vector3 p_W{};
    double force = 0;  ///< sum over the points of the last look, N
    double peak = 0;   ///< largest of these in the present or last contact
    std::uint64_t cycles = 0;
    std::uint64_t last_look = 0;
    bool is_arms = true;  ///< a moves with the arm
  };
  struct KeptContact {
    Seen seen;
    bool has_ended = false;
  };
  struct KeptMoment {
    Time at{};
    std::size_t count = 0;
    std::array<KeptContact, kMostOfMoment> contacts{};
  };
  /// The parts of a contact, that of the arm first; nullopt if the arm has no part in it.
  [[nodiscard]] std::optional<std::array<int, 2>> PartsOf(int contact) const noexcept;
  /// The parts of a contact, one that the arm touches in this look first; nullopt for others.
  [[nodiscard]] std::optional<std::array<int, 2>> PartsBeyond(int contact) const noexcept;
  /// Whether the arm touches a free body in this look.
  [[nodiscard]] bool Carries(int geom) const noexcept;
  void Note(int a, int b, Time now, int contact, bool is_arms) noexcept;
  /// Magnitude of a contact's force by the last step, N.
  [[nodiscard]] double ForceOf(int contact) const noexcept;

  const TruthProbe& truth_;
  ObjectWatch objects_;
  std::vector<int> part_of_geom_;
  std::vector<bool> moves_;  ///< by geom: moves with the arm
  std::vector<bool> free_;   ///< by geom: of a body that moves without the arm
  std::map<int, std::string> names_;
  std::array<Seen, kMostPairs> seen_{};
  std::size_t pairs_ = 0;
  std::array<KeptMoment, kMostMoments> moments_{};
  std::size_t moment_count_ = 0;
  std::uint64_t cycles_ = 0;
  std::uint64_t looks_ = 0;
};

}  // namespace twin::plant
