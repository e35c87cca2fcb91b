#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "run/cycle_summary.h"
#include "run/resolve.h"
#include "twin/core/error.h"
#include "twin/core/setting.h"
#include "twin/plant/observers.h"
#include "twin/robot/robot.h"
#include "twin/run/session.h"

// What a session does beside moving: it looks at the twin, sets it up anew, and goes back in time.
namespace twin::run {

struct Session::Snapshot::Parts {
  std::unique_ptr<const loop::Drive::Snapshot> twin;
  CycleSummary::Copy counted;
  std::uint64_t motions = 0;
  std::vector<FollowedMotion> followed;
};

Session::Snapshot::Snapshot(std::unique_ptr<const Parts> parts) : parts_(std::move(parts)) {}
Session::Snapshot::~Snapshot() = default;

robot::Robot& Session::LockstepRobot(std::string_view wish) const {
  robot::Robot* robot = connection().lockstep_robot;
  if (robot == nullptr) {
    throw InputError(fmt::format(
        "{}: only a robot simulated in lockstep can; say drive: lockstep, with backend mujoco",
        wish));
  }
  return *robot;
}

RobotState Session::Peek() const {
  return LockstepRobot("look at the state without letting time pass").Peek();
}

std::vector<std::pair<std::string, Transform>> Session::Bodies() const {
  static_cast<void>(LockstepRobot("look at the bodies of the scene"));
  const plant::TruthProbe* truth = connection().truth;
  if (truth == nullptr) return {};
  return plant::FreeBodies(*truth);
}

void Session::Place(const std::string& body, const Transform& X_WB) {
  robot::Robot& robot = LockstepRobot("place a body");
  const plant::TruthProbe* truth = connection().truth;
  if (truth == nullptr) {
    throw InputError("place: the ideal plant has no objects; take one of kind: mujoco");
  }
  if (!IsRigid(X_WB)) {
    throw InputError(
        fmt::format("place: the pose of \"{}\" is not rigid: its rotation must be orthonormal and "
                    "right-handed, all values finite, and its last row 0 0 0 1",
                    body));
  }
  const int id = plant::FreeBodyNamed(truth->model(), body);
  const std::optional<plant::Overlap> overlap = robot.Place(id, X_WB);
  if (overlap) throw InputError(plant::DescribeOverlap(truth->model(), body, *overlap));
  Tell("place", body);
}

void Session::Reset(const JointVector& q) {
  TWIN_CHECK(begun_);
  robot::Robot& robot = LockstepRobot("reset the twin");
  const JointLimits& limits = robot.config().onboard.limits;
  for (std::size_t i = 0; i < kJoints; ++i) {
    RequireInRange(fmt::format("reset: joint {}, rad", i + 1), q[i], limits.q_min[i],
                   limits.q_max[i]);
  }
  RequireStartWithinLimits(scenario_, this->robot(), q);
  robot.Reset(q);
  Tell("reset", "the arm is set to rest");
  const std::uint64_t last = robot.Peek().message_id;
  static_cast<void>(drive_->PassUntil(Time::max(), [last](const RobotState* state) {
    return state != nullptr && state->message_id > last;
  }));
}

std::unique_ptr<const Session::Snapshot> Session::Save() const {
  TWIN_CHECK(begun_);
  static_cast<void>(LockstepRobot("take a snapshot"));
  auto parts = std::make_unique<Snapshot::Parts>();
  parts->twin = drive_->Save();
  parts->counted = summary_->Save();
  parts->motions = motions_;
  parts->followed = followed_;
  return std::unique_ptr<const Snapshot>(new Snapshot(std::move(parts)));
}

void Session::Restore(const Snapshot& snapshot) {
  TWIN_CHECK(begun_ && !result_);
  const Snapshot::Parts& parts = *snapshot.parts_;
  const robot::Robot& robot = LockstepRobot("restore a snapshot");
  drive_->Restore(*parts.twin);
  summary_->Restore(parts.counted, robot.records_ahead());
  motions_ = parts.motions;
  followed_ = parts.followed;
  Tell("restore", "back at a snapshot");
}

}  // namespace twin::run
