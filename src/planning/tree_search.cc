#include "planning/tree_search.h"

#include <algorithm>
#include <memory>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/goals/GoalStates.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include "twin/core/random.h"

namespace twin::planning {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using Space = ob::RealVectorStateSpace;

JointVector JointsOf(const ob::State* state) {
  JointVector q;
  std::copy_n(state->as<Space::StateType>()->values, kJoints, q.begin());
  return q;
}

ob::ScopedState<Space> StateOf(const ob::StateSpacePtr& space, const JointVector& q) {
  ob::ScopedState<Space> state(space);
  std::copy(q.begin(), q.end(), state->values);
  return state;
}

/// Draws samples with our own random numbers.
class Sampler final : public ob::StateSampler {
 public:
  Sampler(const ob::StateSpace* space, std::uint64_t seed)
      : StateSampler(space), random_(seed, RandomStream::kPlannerSample) {}

  void sampleUniform(ob::State* state) override {
    const ob::RealVectorBounds& bounds = space_->as<Space>()->getBounds();
    Draw(state, [&](std::size_t i, double share) {
      return bounds.low[i] + share * (bounds.high[i] - bounds.low[i]);
    });
  }
  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    const JointVector q = JointsOf(near);
    Draw(state, [&](std::size_t i, double share) { return q[i] + (2 * share - 1) * distance; });
  }
  void sampleGaussian(ob::State* state, const ob::State* mean, double deviation) override {
    const JointVector q = JointsOf(mean);
    for (std::size_t i = 0; i < kJoints; ++i) {
      state->as<Space::StateType>()->values[i] =
          q[i] + deviation * random_.Normal(drawn_, static_cast<std::uint32_t>(i));
    }
    ++drawn_;
    space_->enforceBounds(state);
  }

 private:
  template <typename Place>
  void Draw(ob::State* state, const Place& place) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      state->as<Space::StateType>()->values[i] =
          place(i, random_.Uniform(drawn_, static_cast<std::uint32_t>(i)));
    }
    ++drawn_;
    space_->enforceBounds(state);
  }

  Random random_;
  std::uint64_t drawn_ = 0;
};

class Motions final : public ob::MotionValidator {
 public:
  Motions(const ob::SpaceInformationPtr& information, MotionChecker& checker)
      : MotionValidator(information), checker_(checker) {}

  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    return checker_.IsFree(JointsOf(a), JointsOf(b));
  }
  bool checkMotion(const ob::State* a, const ob::State* b,
                   std::pair<ob::State*, double>& last_valid) const override {
    const bool free = checkMotion(a, b);
    last_valid.second = free ? 1 : 0;
    if (last_valid.first != nullptr) si_->copyState(last_valid.first, free ? b : a);
    return free;
  }

 private:
  MotionChecker& checker_;
};

ob::StateSpacePtr MakeSpace(const SearchProblem& problem) {
  auto space = std::make_shared<Space>(kJoints);
  ob::RealVectorBounds bounds(kJoints);
  bounds.low.assign(problem.bounds.low.begin(), problem.bounds.low.end());
  bounds.high.assign(problem.bounds.high.begin(), problem.bounds.high.end());
  space->setBounds(bounds);
  space->setStateSamplerAllocator([seed = problem.seed](const ob::StateSpace* of) {
    return std::make_shared<Sampler>(of, seed);
  });
  return space;
}

ob::ProblemDefinitionPtr MakeDefinition(const SearchProblem& problem,
                                        const ob::SpaceInformationPtr& information) {
  const ob::StateSpacePtr& space = information->getStateSpace();
  auto definition = std::make_shared<ob::ProblemDefinition>(information);
  definition->addStartState(StateOf(space, problem.start));
  auto goals = std::make_shared<ob::GoalStates>(information);
  for (const JointVector& goal : problem.goals) goals->addState(StateOf(space, goal));
  definition->setGoal(goals);
  return definition;
}

}  // namespace

std::vector<JointVector> FindPath(const SearchProblem& problem, MotionChecker& checker) {
  ompl::msg::noOutputHandler();  // silences OMPL's messages
  auto information = std::make_shared<ob::SpaceInformation>(MakeSpace(problem));
  information->setStateValidityChecker(
      [&checker](const ob::State* state) { return checker.IsFree(JointsOf(state)); });
  information->setMotionValidator(std::make_shared<Motions>(information, checker));
  information->setup();
  const auto definition = MakeDefinition(problem, information);

  og::RRTConnect planner(information);
  planner.setRange(problem.range);
  planner.setNearestNeighbors<ompl::NearestNeighborsLinear>();
  planner.setProblemDefinition(definition);
  planner.setup();
  const ob::PlannerTerminationCondition exhausted([&checker] { return checker.IsExhausted(); });
  if (planner.solve(exhausted) != ob::PlannerStatus::EXACT_SOLUTION) return {};

  std::vector<JointVector> path;
  for (const ob::State* state :
       definition->getSolutionPath()->as<og::PathGeometric>()->getStates()) {
    path.push_back(JointsOf(state));
  }
  return path;
}

}  // namespace twin::planning
