#include "conformance/stream_runner.h"

#include <cmath>
#include <limits>
#include <optional>

#include "conformance/pose_math.h"
#include "conformance/rig.h"
#include "conformance/stream_source.h"

namespace twin::test {
namespace {

/// The number a generator moves by in this joint or axis, in a command.
double& ValueOf(RobotCommand& command, MotionGeneratorMode mode, std::size_t axis) {
  switch (mode) {
    case MotionGeneratorMode::kJointPosition: return command.q_c[axis % kJoints];
    case MotionGeneratorMode::kJointVelocity: return command.dq_c[axis % kJoints];
    case MotionGeneratorMode::kCartesianPosition:
      return axis == 2 ? command.elbow_c[0] : command.O_T_EE_c[12 + axis % 3];
    default: return axis == 2 ? command.elbow_c[0] : command.O_dP_EE_c[axis % 6];
  }
}

/// One stream on its way.
class Run {
 public:
  Run(const StreamPlan& plan, const HarnessCase& harness, bool checked)
      : plan_(plan), rig_(harness.make(plan.robot), plan.robot, checked) {}

  StreamResult Go() {
    Prepare();
    if (result_.started) {
      for (int k = 0; k < plan_.cycles && Moves(); ++k) Cycle(k);
      if (Moves()) End();
    }
    GoOn();
    result_.finding = rig_.finding();
    return result_;
  }

 private:
  [[nodiscard]] bool IsSound() const { return !rig_.finding(); }
  [[nodiscard]] bool Moves() const {
    return IsSound() && rig_.state().robot_mode == RobotMode::kMove;
  }

  void Pass() {
    rig_.Cycle();
    ++result_.cycles;
    const bool ends = was_moving_ && rig_.state().robot_mode == RobotMode::kReflex;
    if (ends) {
      result_.aborted = true;
      result_.errors = rig_.state().reflex_reason;
    }
    was_moving_ = rig_.state().robot_mode == RobotMode::kMove;
  }

  void Prepare() {
    for (const Setting& setting : plan_.settings) {
      const bool accepted = rig_.Configure(setting);
      if (const auto* filters = std::get_if<setting::Filters>(&setting); filters && accepted) {
        plan_.robot.onboard.filters = *filters;
      }
    }
    for (int i = 0; i < plan_.idle_cycles; ++i) Pass();
    result_.started = rig_.Start(plan_.modes);
    if (!result_.started) return;
    if (plan_.answers_idle) {
      RobotCommand late = rig_.Same();
      late.message_id = rig_.state().message_id;
      late.motion_generation_finished = true;
      rig_.Write(late);
    }
    Pass();
    Pass();
    source_.emplace(plan_, rig_.state());
    for (int i = 0; i < plan_.waiting_cycles && Moves(); ++i) Pass();
  }

  void Cycle(int k) {
    RobotCommand command = source_->Next(rig_.state(), false);
    if (k == 0 && plan_.start_offset != 0) {
      ValueOf(command, plan_.modes.generator, plan_.start_axis) += plan_.start_offset;
    }
    silent_ = std::max(0, silent_ - 1);
    for (const Disturbance& d : plan_.disturbances) {
      if (d.cycle == k) Disturb(d, command);
    }
    if (silent_ == 0) rig_.Write(command);
    Pass();
  }

  void Disturb(const Disturbance& d, RobotCommand& command) {
    double& value = ValueOf(command, plan_.modes.generator, d.axis);
    switch (d.mischief) {
      case Mischief::kEdge: source_->SetEdge(d); break;
      case Mischief::kStep: value += d.size; break;
      case Mischief::kNotANumber: value = std::numeric_limits<double>::quiet_NaN(); break;
      case Mischief::kInfinite: value = std::numeric_limits<double>::infinity(); break;
      case Mischief::kHuge: value = 1e300; break;
      case Mischief::kWrongId: command.message_id += static_cast<std::uint64_t>(d.size); break;
      case Mischief::kBadFrame: SpoilFrame(d, command); break;
      case Mischief::kObliqueFrame: command.O_T_EE_c[d.axis] += d.size; break;
      case Mischief::kElbowSign:
        command.elbow_c[1] = d.count % 2 == 0 ? 0 : -command.elbow_c[1];
        break;
      case Mischief::kElbowSwitch: source_->SwitchElbow(); break;
      case Mischief::kFinish: command.motion_generation_finished = true; break;
      case Mischief::kLoss: silent_ = d.count; break;
      case Mischief::kDouble: WriteOthers(d, command); break;
      case Mischief::kTorqueStep: command.tau_J_d[d.axis] += d.size; break;
      default: Ask(d); break;
    }
  }

  static void SpoilFrame(const Disturbance& d, RobotCommand& command) {
    switch (d.count % 5) {
      case 0: command.O_T_EE_c[3] = 0.1; break;
      case 1: command.O_T_EE_c[0] *= 1.01; break;
      case 2:  // left-handed
        for (std::size_t i = 0; i < 3; ++i) command.O_T_EE_c[i] = -command.O_T_EE_c[i];
        break;
      case 3: command.O_T_EE_c = Transform{}; break;
      default: command.O_T_EE_c[13] = std::numeric_limits<double>::quiet_NaN(); break;
    }
  }

  /// Others of this cycle, which the sound command replaces.
  void WriteOthers(const Disturbance& d, const RobotCommand& command) {
    for (int i = 1; i < d.count; ++i) {
      RobotCommand other = command;
      ValueOf(other, plan_.modes.generator, d.axis) += i;
      rig_.Write(other);
    }
  }

  void Ask(const Disturbance& d) {
    switch (d.mischief) {
      case Mischief::kStop: rig_.Stop(); break;
      case Mischief::kRecover: rig_.Recover(); break;
      case Mischief::kStartAgain: rig_.Start(plan_.modes); break;
      case Mischief::kSet: rig_.Configure(DrawSetting(static_cast<std::uint64_t>(d.count))); break;
      case Mischief::kPanel: rig_.Operate(static_cast<PanelAction>(d.count)); break;
      default: break;
    }
  }

  void End() {
    constexpr int kLongest = 1200;
    if (plan_.end == StreamEnd::kStop) rig_.Stop();
    bool finishes = false;
    RobotCommand last;
    for (int k = 0; k < kLongest && Moves(); ++k) {
      if (plan_.end == StreamEnd::kFinish && !finishes) {
        finishes = source_->MayFinish(rig_.state());
        last = finishes ? rig_.Same() : source_->Next(rig_.state(), true);
        last.motion_generation_finished = finishes;
        if (finishes) StandStill(last);
      }
      last.message_id = rig_.state().message_id;
      if (plan_.end == StreamEnd::kFinish) rig_.Write(last);
      Pass();
    }
    if (Moves()) result_.finding = "the stream does not end";
  }

  static void StandStill(RobotCommand& command) {
    command.dq_c = JointVector{};
    command.O_dP_EE_c = Vector6{};
  }

  /// What may come after a motion: requests in whatever mode it left the robot in, recovery, a
  /// short second motion.
  void GoOn() {
    if (!IsSound() || !plan_.goes_on) return;
    for (const Disturbance& d : plan_.disturbances) {
      if (d.mischief < Mischief::kStop) continue;
      Ask(d);
      Pass();
    }
    for (int i = 0; i < kPanelActions; ++i) {
      rig_.Operate(static_cast<PanelAction>(i));
      Pass();
      Pass();
    }
    rig_.ComeToRest();
    rig_.Operate(PanelAction::kReleaseUserStop);
    rig_.Operate(PanelAction::kReleaseGuidingButton);
    rig_.Operate(PanelAction::kOpenBrakes);
    Pass();
    if (rig_.state().robot_mode == RobotMode::kReflex) rig_.RecoverToIdle();
    if (!IsSound() || !rig_.StartMotion(plan_.modes)) return;
    plan_.end = StreamEnd::kFinish;
    source_.emplace(plan_, rig_.state());
    was_moving_ = false;
    for (int k = 0; k < 50 && Moves(); ++k) {
      rig_.Write(source_->Next(rig_.state(), false));
      Pass();
    }
    End();
  }

  StreamPlan plan_;
  Rig rig_;
  std::optional<StreamSource> source_;
  int silent_ = 0;
  bool was_moving_ = false;
  StreamResult result_;
};

}  // namespace

StreamResult RunStream(const StreamPlan& plan, const HarnessCase& harness, bool checked) {
  return Run(plan, harness, checked).Go();
}

StreamPlan Shrink(StreamPlan plan, const std::function<bool(const StreamPlan&)>& fails) {
  const auto keep_if_failing = [&](const StreamPlan& less) {
    if (fails(less)) plan = less;
  };
  for (std::size_t i = plan.disturbances.size(); i-- > 0;) {
    StreamPlan less = plan;
    less.disturbances.erase(less.disturbances.begin() + static_cast<std::ptrdiff_t>(i));
    keep_if_failing(less);
  }
  for (std::size_t i = plan.settings.size(); i-- > 0;) {
    StreamPlan less = plan;
    less.settings.erase(less.settings.begin() + static_cast<std::ptrdiff_t>(i));
    keep_if_failing(less);
  }
  for (const auto& simplify :
       {+[](StreamPlan& p) { p.goes_on = false; }, +[](StreamPlan& p) { p.answers_idle = false; },
        +[](StreamPlan& p) { p.start_offset = 0; }, +[](StreamPlan& p) { p.waiting_cycles = 0; },
        +[](StreamPlan& p) { p.idle_cycles = 0; }, +[](StreamPlan& p) { p.with_elbow = false; },
        +[](StreamPlan& p) { p.robot.onboard.F_T_NE = kIdentityTransform; },
        +[](StreamPlan& p) { p.end = StreamEnd::kFinish; },
        +[](StreamPlan& p) { p.modes.controller = {}; }}) {
    StreamPlan less = plan;
    simplify(less);
    keep_if_failing(less);
  }
  for (int cut = plan.cycles / 2; cut > 0; cut /= 2) {
    StreamPlan less = plan;
    less.cycles -= cut;
    keep_if_failing(less);
  }
  return plan;
}

}  // namespace twin::test
