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

/// Two parts that touched in a run. A part is a body of the model ("panda_link5", "box") or, of
/// what is fixed to the world, one shape by its name ("table").
struct ContactPair {
  std::string a;  ///< moves with the arm
  std::string b;
  Time first{};              ///< when they were first seen to touch
  std::uint64_t cycles = 0;  ///< in how many looks they did
};

/// What the arm touched in the course of a run, by the engine's own contacts: ground truth, for the
/// report of a run and for tests, never for what controls it. Counted are pairs of which at least
/// one moves with the arm (its links from 1 on, hand, fingers; of a mobile base all but its
/// wheels); a box that lies on a table is none. What became of such bodies is told apart from that
/// (objects()).
///
/// Threads: Look() from the plant's thread; the others once it has ended. Real-time: Look() is
/// noexcept, O(contacts), allocates nothing.
class ContactWatch {
 public:
  /// More pairs than these are counted, but not told apart.
  static constexpr std::size_t kMostPairs = 64;

  /// @param truth  must outlive the watch.
  explicit ContactWatch(const TruthProbe& truth);

  /// Notes what touches now. Once per cycle.
  void Look(Time now) noexcept TWIN_REALTIME;

  /// @returns the pairs in the order in which they first touched.
  [[nodiscard]] std::vector<ContactPair> Pairs() const;
  /// In how many looks the arm touched anything.
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_; }
  [[nodiscard]] std::uint64_t looks() const noexcept { return looks_; }

  /// The bodies that move freely.
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
  std::vector<bool> moves_;  ///< by geom: with the arm
  std::map<int, std::string> names_;
  std::array<Seen, kMostPairs> seen_{};
  std::size_t pairs_ = 0;
  std::uint64_t cycles_ = 0;
  std::uint64_t looks_ = 0;
};

}  // namespace twin::plant
