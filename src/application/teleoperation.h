#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "twin/application/application.h"
#include "twin/core/mobile_base.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/plant/observers.h"
#include "twin/teleop/device.h"
#include "twin/teleop/teleoperator.h"
#include "twin/teleop/teleoperator_config.h"

// The parts of the application `teleoperation`: scripted operator and evaluation.
namespace twin::application {

/// Where what is to be carried, and how the base stands for it. World frame, m and rad.
struct FetchTask {
  std::string object;   ///< body
  double height = 0;    ///< of the object, m
  Vector3 from{};       ///< about where it stands (its centre); the base goes by that
  double from_yaw = 0;  ///< heading of the base there
  Vector3 to{};         ///< where its centre is to be, standing
  double to_yaw = 0;    ///< heading of the base there
  double reach = 0.55;  ///< from the arm's base to the object, along the heading
  double mount = 0.22;  ///< of the arm's base before the middle of the mobile base
};

/// Skill of the person.
struct ScriptedOperatorConfig {
  Duration reaction = std::chrono::milliseconds(250);  ///< from what is there to what is seen
  double hand_noise = 0.06;   ///< share by which a motion is too long, standard deviation
  double tremor = 0.01;       ///< of full deflection, standard deviation
  double eye_noise = 0.0015;  ///< m, of what is seen of hand and object, standard deviation
  double far_noise = 0.008;   ///< m and rad, of what is seen of the base's place
  double arm_speed = 0.16;    ///< peak of a motion, m/s
  double base_speed = 0.4;    ///< m/s
  double base_turn = 0.6;     ///< rad/s
};

/// A person at a stick, who fetches an object with a mobile manipulator by what the eyes see: for
/// tests and the headless demo. A device, so that all that is done passes wire and mapping.
///
/// It moves as people do over a slow wire, by move and wait (Ferrell 1965): it looks, makes one
/// motion by what it saw, waits until that has had its effect, and looks again. A motion's velocity
/// is that of minimum jerk (Flash, Hogan 1985), D/T 30 s^2 (1 - s)^2, s = t/T; its length misses by
/// hand_noise, its direction by half of that, and hands tremble. It knows that a motion has had its
/// effect when the echo of its last sample has come back and all it sees is still.
///
/// Its eyes are the plant's ground truth, with noise and a reaction's delay: what people see of the
/// world. The robot knows nothing of it.
///
/// Threads: the plant's; so it is for lockstep. Real-time: Read() and Feel() allocate nothing.
class ScriptedOperator final : public teleop::Device {
 public:
  /// @throws InputError when a body it looks at is not there.
  ScriptedOperator(const plant::TruthProbe& truth, const FetchTask& task,
                   const ScriptedOperatorConfig& config, const teleop::TeleoperatorConfig& robot,
                   std::uint64_t seed);

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override;
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override { felt_ = feedback; }
  [[nodiscard]] bool lost() const noexcept override { return false; }
  [[nodiscard]] std::string Describe() const override { return "a scripted person at a stick"; }

  /// Why it gave up; empty: it did not.
  [[nodiscard]] std::string failure() const;
  /// Motions it made.
  [[nodiscard]] int motions() const noexcept { return motions_; }

 private:
  /// What it means to do next.
  enum class Intent : std::uint8_t {
    kLeadBase,
    kDriveToObject,
    kLeadArm,
    kOverObject,
    kAtObject,
    kClose,
    kLift,
    kCarry,
    kLeadBaseAgain,
    kBackOff,
    kDriveToTarget,
    kLeadArmAgain,
    kOverTarget,
    kAtTarget,
    kOpen,
    kLeave,
    kEnd,
  };
  enum class Doing : std::uint8_t { kDeciding, kMoving, kWaiting };
  using Axes = Eigen::Matrix<double, 6, 1>;

  /// What is there at an instant.
  struct Sight {
    Time at{};
    BasePose base;
    Eigen::Matrix3d R_WO = Eigen::Matrix3d::Identity();
    Eigen::Vector3d hand = Eigen::Vector3d::Zero();    ///< between the fingertips
    Eigen::Vector3d arm = Eigen::Vector3d::Zero();     ///< the arm's base O
    Eigen::Vector3d object = Eigen::Vector3d::Zero();  ///< its centre
  };

  void Look(Time now) noexcept;
  /// The newest that is older than this; false: there is none yet.
  bool Seen(Time before, Sight& sight) const noexcept;
  [[nodiscard]] Sight Blurred(const Sight& sight) noexcept;
  [[nodiscard]] bool IsStill(Time now) const noexcept;

  void Act(Time now) noexcept;
  void Decide(Time now) noexcept;
  /// Acts on the intent. @returns whether it is fulfilled.
  bool Pursue(const Sight& sight, Time now) noexcept;
  bool Press(std::uint32_t teleop::OperatorSample::*counter, bool is_so, Time now) noexcept;
  bool Reach(const Eigen::Vector3d& way, const Sight& sight, double tolerance, Time now) noexcept;
  bool Drive(const BasePose& goal, const Sight& sight, Time now) noexcept;
  void Begin(const Axes& way, double duration, Time now) noexcept;
  void Wait(Duration least, Time now) noexcept;
  void GiveUp() noexcept;
  [[nodiscard]] BasePose StandFor(const Vector3& place, double yaw) const noexcept;
  [[nodiscard]] double Deflection(double velocity, double full) const noexcept;
  [[nodiscard]] double Noise(double sigma) noexcept;
  void Move(Time now) noexcept;

  const FetchTask task_;
  const ScriptedOperatorConfig config_;
  const teleop::TeleoperatorConfig robot_;
  const Random random_;
  std::uint64_t draws_ = 0;
  const plant::BodyView base_;
  const plant::BodyView arm_;
  const plant::BodyView hand_;
  const plant::BodyView object_;

  static constexpr std::size_t kSights = 64;
  std::array<Sight, kSights> sights_{};
  std::size_t looks_ = 0;
  Time next_look_{};
  Time next_sample_{};

  teleop::OperatorSample sample_;
  teleop::OperatorFeedback felt_;
  Intent intent_ = Intent::kLeadBase;
  Doing doing_ = Doing::kWaiting;
  Axes way_ = Axes::Zero();  ///< of the motion under way, m and rad
  Time begun_{};
  double duration_ = 0;
  Time wait_until_{};
  std::uint64_t await_ = 0;  ///< sample whose echo it waits for
  bool has_pressed_ = false;
  int motions_ = 0;
  int tries_ = 0;           ///< of the intent
  double lifted_from_ = 0;  ///< height of the object before, m
  std::optional<Intent> gave_up_at_;
};

/// What a session of teleoperation noted of itself.
struct TeleoperationRecord {
  FetchTask task;
  teleop::TeleoperatorConfig config;
  std::vector<teleop::TeleoperatorStatus> trace{};  ///< every 50 ms
  std::vector<std::string> robot_errors{};
  int switches = 0;  ///< of the mode
  int motions = 0;   ///< of a scripted person
};

/// The demands of teleoperation, and figures beside them.
[[nodiscard]] Evaluation EvaluateTeleoperation(const TeleoperationRecord& record,
                                               const Evidence& evidence);

}  // namespace twin::application
