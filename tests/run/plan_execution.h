#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "controllers/registration.h"
#include "plugins/backends.h"
#include "support/panda_limits.h"
#include "twin/planning/random_goal.h"
#include "twin/plant/contact_watch.h"
#include "twin/run/run.h"

namespace twin::run::test {

/// What a run was seen to do, from outside: what the arm touched, by ground truth, and how far it
/// was from where it was to be.
class Watcher final : public record::RecordSink {
 public:
  void Watch(const plant::TruthProbe& truth) { contacts_.emplace(truth); }
  void Put(const record::CycleRecord& record) noexcept override {
    contacts_->Look(record.at);
    q_ = record.state.q;
  }
  void Put(const record::TickRecord& record) noexcept override {
    if (record.action != record::TickAction::kWritten) return;
    for (std::size_t i = 0; i < kJoints; ++i) {
      off_ = std::max(off_, std::abs(record.q_ext[i] - q_[i]));
    }
  }
  [[nodiscard]] const plant::ContactWatch& contacts() const { return *contacts_; }
  /// Largest distance of a joint from its target, rad; the link's delay included.
  [[nodiscard]] double off() const { return off_; }

 private:
  std::optional<plant::ContactWatch> contacts_;
  JointVector q_{};
  double off_ = 0;
};

/// What became of a problem.
struct Outcome {
  bool is_solved = false;
  std::string unsolved;  ///< why it is not
  RunResult result;
  double planning_s = 0;
  double off = 0;             ///< see Watcher
  std::uint64_t touched = 0;  ///< cycles in which the arm touched anything
  std::uint64_t looks = 0;    ///< of all cycles
  std::string touch;          ///< what it first touched
};

/// Random problems in the clutter, planned and executed as plan_and_execute.yaml does.
class Problems {
 public:
  Problems() : scenario_(scenario::Load(files_.models / "scenarios" / "plan_and_execute.yaml")) {
    plugins::RegisterMujoco(backends_);
    controllers::RegisterControllers(controllers_);
    plant::MujocoPlantOptions options;
    options.urdf = files_.models / "robots" / "panda" / "panda.urdf";
    options.scene = files_.models / scenario_.scene;
    world_.emplace(options);
  }

  [[nodiscard]] scenario::Scenario scenario() const { return scenario_; }
  [[nodiscard]] Catalogue catalogue() const { return {backends_, controllers_}; }
  [[nodiscard]] const RunFiles& files() const { return files_; }

  /// The n-th: from somewhere free to somewhere else.
  [[nodiscard]] scenario::Scenario Problem(std::uint64_t n) {
    scenario::Scenario scenario = scenario_;
    scenario.seed = 2 * n + 1;
    scenario.robot.q_start =
        planning::RandomGoal(*world_, twin::test::PandaLimits(), 2 * n,
                             {.clearance = scenario_.motion.plan.value().clearance});
    return scenario;
  }

  [[nodiscard]] Outcome Execute(const scenario::Scenario& scenario) const {
    Outcome outcome;
    Watcher watcher;
    try {
      run::Run run(scenario, catalogue(), files_, &watcher);
      outcome.is_solved = true;
      outcome.planning_s = ToSeconds(run.planning_time().value());
      watcher.Watch(*run.connection().truth);
      outcome.result = run.Execute();
      outcome.off = watcher.off();
      outcome.touched = watcher.contacts().cycles();
      outcome.looks = watcher.contacts().looks();
      for (const plant::ContactPair& pair : watcher.contacts().Pairs()) {
        outcome.touch += pair.a + " and " + pair.b + "; ";
      }
    } catch (const NoPlanError& error) {
      outcome.unsolved = error.what();
    }
    return outcome;
  }

 private:
  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const RunFiles files_{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
  const scenario::Scenario scenario_;
  std::optional<planning::CollisionWorld> world_;
};

}  // namespace twin::run::test
