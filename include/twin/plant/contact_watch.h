#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

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

/// Contacts of the arm during a run, from the engine: ground truth for a run's report and tests,
/// never for control. It counts pairs with at least one part that moves with the arm (its links
/// from 1 on, hand, fingers; of a mobile base all but its wheels). A box on a table does not count;
/// objects() tracks such bodies.
///
/// Threads: Look() from the plant's thread; the others after it has ended. Real-time: Look() is
/// noexcept, O(contacts), allocates nothing.
class ContactWatch {
 public:
  /// Further pairs are only counted.
  static constexpr std::size_t kMostPairs = 64;

  /// @param truth  must outlive the watch.
  explicit ContactWatch(const TruthProbe& truth);

  /// Records present contacts. Once per cycle.
  void Look(Time now) noexcept TWIN_REALTIME;

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
    std::uint64_t cycles = 0;
    std::uint64_t last_look = 0;
  };
  void Note(int a, int b, Time now) noexcept;

  const TruthProbe& truth_;
  ObjectWatch objects_;
  std::vector<int> part_of_geom_;
  std::vector<bool> moves_;  ///< by geom: moves with the arm
  std::map<int, std::string> names_;
  std::array<Seen, kMostPairs> seen_{};
  std::size_t pairs_ = 0;
  std::uint64_t cycles_ = 0;
  std::uint64_t looks_ = 0;
};

}  // namespace twin::plant
