#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/cycle_record.h"
#include "twin/rt/event_queue.h"

namespace twin::plant {
class TruthProbe;
}  // namespace twin::plant

namespace twin::backend {

/// What a factory gets. References and pointers must outlive the backend.
struct Request {
  const robot::RobotConfig& robot;
  rt::EventQueue& events;         ///< the virtual clock of lockstep
  rt::EventHandler& state_ready;  ///< told (token = message_id) when a state has arrived
  rt::RecordSink* sink =
      nullptr;  ///< INT's cycle records, where the backend knows them; may be null
};

/// A connected backend, and what only a twin has.
struct Connection {
  std::unique_ptr<Backend> backend;
  const plant::TruthProbe* truth =
      nullptr;  ///< owned by the backend; null for hardware and the ideal plant
  /// What the simulation itself complained of since it was connected, for people; empty: nothing.
  /// Empty function: there is no simulation.
  std::function<std::string()> engine_warnings;
  bool uses_meshes = false;  ///< false: the arm is drawn in primitive shapes
};

using Factory = std::function<Connection(const Request&)>;

/// The backends a program knows, by name. Filled from an explicit list by the program's main.
class Registry {
 public:
  /// @pre no backend of this name was added.
  void Add(std::string name, Factory factory);

  /// @throws InputError when there is no such backend; the text lists those there are.
  [[nodiscard]] const Factory& Find(std::string_view name) const;

  [[nodiscard]] std::vector<std::string> Names() const;

 private:
  std::vector<std::pair<std::string, Factory>> entries_;
};

}  // namespace twin::backend
