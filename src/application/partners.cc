#include "twin/application/partners.h"

#include <algorithm>
#include <utility>

#include "twin/run/robot_config.h"

namespace twin::application {

MessageBoard::MessageBoard(std::span<const scenario::CellRobot> robots)
    : robots_(robots), seats_(robots.size()) {}

void MessageBoard::Say(std::size_t robot, Message message) {
  const std::lock_guard lock(mutex_);
  seats_[robot].said.push_back(std::move(message));
}

std::optional<Message> MessageBoard::Heard(std::size_t robot, std::string_view word,
                                           Time now) const {
  const std::lock_guard lock(mutex_);
  const std::vector<Message>& said = seats_[robot].said;
  const auto last = std::find_if(said.rbegin(), said.rend(), [&](const Message& message) {
    return message.word == word && message.at < now;
  });
  return last == said.rend() ? std::nullopt : std::optional(*last);
}

void MessageBoard::End(std::size_t robot, std::string failure) {
  const std::lock_guard lock(mutex_);
  std::optional<std::string>& end = seats_[robot].end;
  if (!end) end = std::move(failure);
}

std::optional<std::string> MessageBoard::EndOf(std::size_t robot, Time now) const {
  const std::lock_guard lock(mutex_);
  const Seat& seat = seats_[robot];
  const bool is_heard = seat.said.empty() || seat.said.back().at < now;
  return is_heard ? seat.end : std::nullopt;
}

std::optional<std::size_t> Partners::Find(std::string_view name) const {
  for (std::size_t i = 0; i < robots().size(); ++i) {
    if (i != own_ && robots()[i].name == name) return i;
  }
  return std::nullopt;
}

JointVector Partners::StartOf(std::size_t robot) const {
  return run::StartOf(robots()[robot].scenario);
}

std::string Partners::Names() const {
  std::string names;
  for (std::size_t i = 0; i < robots().size(); ++i) {
    if (i != own_) names += (names.empty() ? "" : ", ") + robots()[i].name;
  }
  return names.empty() ? "none" : names;
}

}  // namespace twin::application
