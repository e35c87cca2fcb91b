#pragma once

#include <memory>
#include <string>

#include "twin/control/controller.h"
#include "twin/control/registry.h"
#include "twin/core/clock.h"
#include "twin/core/time.h"

namespace twin::experiment {

/// Wraps a controller and keeps the processor busy until every update has lasted `load`: the cost
/// of a stack's other controllers. The commands are the wrapped controller's.
///
/// Threads and real-time: as the wrapped controller.
class BusyController final : public control::Controller {
 public:
  BusyController(std::unique_ptr<control::Controller> inner, Duration load)
      : inner_(std::move(inner)), load_(load) {}

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return inner_->command_interface();
  }
  void Activate(const RobotState& state, Time now) override { inner_->Activate(state, now); }
  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override {
    const Time end = clock_.Now() + load_;
    inner_->Update(state, now, output);
    while (clock_.Now() < end) {
    }
  }
  void Deactivate() noexcept override { inner_->Deactivate(); }
  void Configure(control::ParameterReader& parameters) override { inner_->Configure(parameters); }
  [[nodiscard]] bool follows_pose() const noexcept override { return inner_->follows_pose(); }
  [[nodiscard]] std::string Explain() const override { return inner_->Explain(); }

 private:
  const MonotonicClock clock_;
  std::unique_ptr<control::Controller> inner_;
  Duration load_;
};

/// The same controllers with that load. @param registry  must outlive what is returned.
[[nodiscard]] inline control::ControllerRegistry Loaded(const control::ControllerRegistry& registry,
                                                        Duration load) {
  control::ControllerRegistry loaded;
  for (const std::string& name : registry.Names()) {
    loaded.Add(name,
               [&factory = registry.Find(name), load](const control::ControllerRequest& request) {
                 return std::make_unique<BusyController>(factory(request), load);
               });
  }
  return loaded;
}

}  // namespace twin::experiment
