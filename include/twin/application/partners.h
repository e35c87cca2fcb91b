#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/scenario/cell.h"

namespace twin::application {

/// What an application tells those of the other robots, measured or planned by itself: nothing that
/// a robot's program could not send over a network.
struct Message {
  std::string word;                     ///< "offered"
  Time at{};                            ///< robot's time when it is said
  JointVector q{};                      ///< of the arm that says it, rad
  double width = 0;                     ///< between its fingers, m
  JointVector q_to{};                   ///< where it will be when it has made room, rad
  Transform X_WB = kIdentityTransform;  ///< of the object, in the world
  Vector3 B_hand{};                     ///< between its fingertips, in the object's frame, m
};

/// The messages between the applications of robots that can reach each other.
///
/// Threads: any.
class MessageBoard {
 public:
  /// @param robots  in the order of their names; must outlive this.
  explicit MessageBoard(std::span<const scenario::CellRobot> robots);

  [[nodiscard]] std::span<const scenario::CellRobot> robots() const noexcept { return robots_; }
  void Say(std::size_t robot, Message message);
  /// The last message of a word that a robot said before `now`; nullopt: none. Messages of the same
  /// instant do not count, so that no order among the robots does.
  [[nodiscard]] std::optional<Message> Heard(std::size_t robot, std::string_view word,
                                             Time now) const;
  /// A robot's task is over; the first call counts. @param failure  empty: it succeeded.
  void End(std::size_t robot, std::string failure);
  /// Why a robot's task failed, or empty; nullopt while it goes on, or has said what is not heard
  /// yet.
  [[nodiscard]] std::optional<std::string> EndOf(std::size_t robot, Time now) const;

 private:
  struct Seat {
    std::vector<Message> said;
    std::optional<std::string> end;
  };
  const std::span<const scenario::CellRobot> robots_;
  mutable std::mutex mutex_;  ///< of all below
  std::vector<Seat> seats_;
};

/// The board as one robot has it.
class Partners {
 public:
  /// @param board  must outlive this. @param own  index of the robot.
  Partners(MessageBoard& board, std::size_t own) : board_(board), own_(own) {}

  [[nodiscard]] MessageBoard& board() const noexcept { return board_; }
  [[nodiscard]] std::size_t own() const noexcept { return own_; }
  [[nodiscard]] std::span<const scenario::CellRobot> robots() const { return board_.robots(); }
  /// The index of another robot; nullopt: none is called so.
  [[nodiscard]] std::optional<std::size_t> Find(std::string_view name) const;
  /// Where an arm begins, rad.
  [[nodiscard]] JointVector StartOf(std::size_t robot) const;
  /// Names of the other robots: "left, right"; "none".
  [[nodiscard]] std::string Names() const;
  void Say(Message message) const { board_.Say(own_, std::move(message)); }

 private:
  MessageBoard& board_;
  const std::size_t own_;
};

}  // namespace twin::application
