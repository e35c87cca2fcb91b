#include <benchmark/benchmark.h>

#include "twin/model/arm_model.h"

namespace twin::model {
namespace {

const JointVector kQ{0.3, -0.7, 0.2, -2.1, 0.4, 1.6, 0.8};
const JointVector kDq{0.5, -0.4, 0.3, 0.2, -0.6, 0.7, -0.1};
const JointVector kDdq{1, -2, 3, -1, 2, -3, 1};
const Payload kHand{0.73, {-0.01, 0, 0.03}, {0.001, 0, 0, 0, 0.0025, 0, 0, 0, 0.0017}};
const Transform kHandPose{0.8, -0.6, 0, 0, 0.6, 0.8, 0, 0, 0, 0, 1, 0, 0, 0, 0.1034, 1};

/// Times one call, sines and cosines included unless it takes a Configuration from outside.
template <typename Call>
void Run(benchmark::State& state, Call call) {
  JointVector q = kQ;
  for (auto _ : state) {
    benchmark::DoNotOptimize(q);
    auto result = call(ArmModel::Panda(), q);
    benchmark::DoNotOptimize(result);
  }
}

/// What the robot serves of its model in a cycle: every frame's pose, the Jacobians of the end
/// effector, M, c and g.
struct ServedSet {
  std::array<Transform, 9> poses;
  Jacobian zero_jacobian;
  Jacobian body_jacobian;
  JointMatrix M;
  JointVector c;
  JointVector g;
};

ServedSet Serve(const ArmModel& arm, const Configuration& q) {
  ServedSet set;
  for (std::size_t i = 0; i < set.poses.size(); ++i) {
    set.poses[i] = arm.Pose(static_cast<Frame>(i), q, kHandPose);
  }
  set.zero_jacobian = arm.ZeroJacobian(Frame::kEndEffector, q, kHandPose);
  set.body_jacobian = arm.BodyJacobian(Frame::kEndEffector, q, kHandPose);
  set.M = arm.MassMatrix(q, kHand);
  set.c = arm.Coriolis(q, kDq, kHand);
  set.g = arm.Gravity(q, kHand);
  return set;
}

void BM_Configuration(benchmark::State& state) {
  Run(state, [](const ArmModel&, const JointVector& q) { return Configuration(q); });
}
BENCHMARK(BM_Configuration);

void BM_Pose(benchmark::State& state) {
  Run(state, [](const ArmModel& arm, const JointVector& q) {
    return arm.Pose(Frame::kEndEffector, q, kHandPose);
  });
}
BENCHMARK(BM_Pose);

void BM_Twist(benchmark::State& state) {
  Run(state, [](const ArmModel& arm, const JointVector& q) {
    return arm.Twist(Frame::kEndEffector, q, kDq, kHandPose);
  });
}
BENCHMARK(BM_Twist);

void BM_ZeroJacobian(benchmark::State& state) {
  Run(state, [](const ArmModel& arm, const JointVector& q) {
    return arm.ZeroJacobian(Frame::kEndEffector, q, kHandPose);
  });
}
BENCHMARK(BM_ZeroJacobian);

void BM_BodyJacobian(benchmark::State& state) {
  Run(state, [](const ArmModel& arm, const JointVector& q) {
    return arm.BodyJacobian(Frame::kEndEffector, q, kHandPose);
  });
}
BENCHMARK(BM_BodyJacobian);

void BM_MassMatrix(benchmark::State& state) {
  Run(state, [](const ArmModel& arm, const JointVector& q) { return arm.MassMatrix(q, kHand); });
}
BENCHMARK(BM_MassMatrix);

void BM_Coriolis(benchmark::State& state) {
  Run(state, [](const ArmModel& arm, const JointVector& q) { return arm.Coriolis(q, kDq, kHand); });
}
BENCHMARK(BM_Coriolis);

void BM_Gravity(benchmark::State& state) {
  Run(state, [](const ArmModel& arm, const JointVector& q) { return arm.Gravity(q, kHand); });
}
BENCHMARK(BM_Gravity);

void BM_InverseDynamics(benchmark::State& state) {
  Run(state, [](const ArmModel& arm, const JointVector& q) {
    return arm.InverseDynamics(q, kDq, kDdq, kHand);
  });
}
BENCHMARK(BM_InverseDynamics);

void BM_InverseDynamicsOfKnownSines(benchmark::State& state) {
  Configuration configuration(kQ);
  Run(state, [&](const ArmModel& arm, const JointVector&) {
    benchmark::DoNotOptimize(configuration);
    return arm.InverseDynamics(configuration, kDq, kDdq, kHand);
  });
}
BENCHMARK(BM_InverseDynamicsOfKnownSines);

void BM_ServedSet(benchmark::State& state) {
  Run(state, [](const ArmModel& arm, const JointVector& q) { return Serve(arm, q); });
}
BENCHMARK(BM_ServedSet);

}  // namespace
}  // namespace twin::model
