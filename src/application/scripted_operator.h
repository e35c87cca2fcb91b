#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "twin/core/mobile_base.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/plant/observers.h"
#include "twin/teleop/device.h"
#include "twin/teleop/teleoperator.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::application {

/// Object to transport, its target, and poses of the base. World frame, m and rad.
struct FetchTask {
  std::string object;   ///< body
  double height = 0;    ///< of the object, m
  Vector3 from{};       ///< approximate position of its centre, for positioning the base
  double from_yaw = 0;  ///< heading of the base at the object
  Vector3 to{};         ///< target position of its centre, standing
  double to_yaw = 0;    ///< heading of the base at the target
  double reach = 0.55;  ///< from the arm's base to the object, along the heading
  double mount = 0.22;  ///< of the arm's base, forward of the mobile base's centre
};

/// Skill of the scripted operator.
struct ScriptedOperatorConfig {
  Duration reaction = std::chrono::milliseconds(250);  ///< delay of what the operator sees
  double hand_noise = 0.06;   ///< relative error of a motion's length, standard deviation
  double tremor = 0.01;       ///< share of full deflection, standard deviation
  double eye_noise = 0.0015;  ///< m, perceived position of hand and object, standard deviation
  double far_noise = 0.008;   ///< m and rad, perceived pose of the base, standard deviation
  double arm_speed = 0.16;    ///< peak of a motion, m/s
  double base_speed = 0.4;    ///< m/s
  double base_turn = 0.6;     ///< rad/s
};

/// A simulated human operator at a stick who fetches an object with a mobile manipulator by sight,
/// for tests and the headless demo. It is a device, so all its input passes wire and mapping.
///
/// It uses the move-and-wait strategy of people at a slow wire (Ferrell 1965): it looks, makes one
/// motion based on what it saw, waits until the motion has taken effect, and looks again. A motion
/// has the velocity profile of minimum jerk (Flash, Hogan 1985), D/T 30 s^2 (1 - s)^2, s = t/T; its
/// length has an error of hand_noise, its direction of half as much, and tremor is added. A motion
/// has taken effect once the echo of its last sample has returned and nothing seen moves.
///
/// It sees the plant's ground truth with noise and the reaction's delay. The robot does not get
/// this data.
///
/// Threads: the plant's, hence lockstep only. Real-time: Read() and Feel() do not allocate.
class ScriptedOperator final : public teleop::Device {
 public:
  /// @throws InputError if the plant lacks a body that it observes.
  ScriptedOperator(const plant::TruthProbe& truth, const FetchTask& task,
                   const ScriptedOperatorConfig& config, const teleop::TeleoperatorConfig& robot,
                   std::uint64_t seed);

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override;
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override { felt_ = feedback; }
  [[nodiscard]] bool lost() const noexcept override { return false; }
  [[nodiscard]] std::string Describe() const override { return "a scripted person at a stick"; }

  /// Reason for giving up; empty: it did not.
  [[nodiscard]] std::string failure() const;
  /// Number of motions made.
  [[nodiscard]] int motions() const noexcept { return motions_; }

 private:
  enum class Doing : std::uint8_t { kDeciding, kMoving, kWaiting };
  using Axes = Eigen::Matrix<double, 6, 1>;

  /// The scene at an instant.
  struct Sight {
    Time at{};
    BasePose base;
    Eigen::Matrix3d R_WO = Eigen::Matrix3d::Identity();
    Eigen::Vector3d hand = Eigen::Vector3d::Zero();    ///< between the fingertips
    Eigen::Vector3d arm = Eigen::Vector3d::Zero();     ///< the arm's base O
    Eigen::Vector3d object = Eigen::Vector3d::Zero();  ///< its centre
  };

  /// What the operator does next.
  struct Intent {
    const char* text;  ///< "the person gave up while ..."
    /// Acts on the intent. @returns true if it is fulfilled.
    bool (*pursue)(ScriptedOperator& self, const Sight& seen, Time now);
  };
  static const std::array<Intent, 17> kIntents;  ///< in their order

  void Look(Time now) noexcept;
  /// Gets the newest sight older than `before`. @returns false if there is none.
  bool Seen(Time before, Sight& sight) const noexcept;
  [[nodiscard]] Sight Blurred(const Sight& sight) noexcept;
  [[nodiscard]] bool IsStill(Time now) const noexcept;

  void Act(Time now) noexcept;
  void Decide(Time now) noexcept;
  // Each acts on an intent. @returns true if it is fulfilled.
  bool Lead(teleop::Mode mode, Time now) noexcept;
  bool TurnHand(bool closed, Time now) noexcept;
  bool Press(std::uint32_t teleop::OperatorSample::*counter, Duration least, Time now) noexcept;
  bool Reach(const Eigen::Vector3d& path, const Sight& sight, double tolerance, Time now) noexcept;
  bool Drive(const BasePose& goal, const Sight& sight, Time now) noexcept;
  void Begin(const Axes& path, double duration, Time now) noexcept;
  void Wait(Duration least, Time now) noexcept;
  void GiveUp() noexcept;
  [[nodiscard]] BasePose StandFor(const Vector3& place, double yaw) const noexcept;
  [[nodiscard]] BasePose AtObject() const noexcept { return StandFor(task_.from, task_.from_yaw); }
  [[nodiscard]] BasePose AtTarget() const noexcept { return StandFor(task_.to, task_.to_yaw); }
  [[nodiscard]] Eigen::Vector3d target() const noexcept { return Eigen::Vector3d(task_.to.data()); }
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
  std::size_t intent_ = 0;  ///< of kIntents
  Doing doing_ = Doing::kWaiting;
  Axes path_ = Axes::Zero();  ///< displacement of the current motion, m and rad
  Time begun_{};
  double duration_ = 0;
  Time wait_until_{};
  std::uint64_t await_ = 0;  ///< sequence of the sample whose echo is awaited
  bool has_pressed_ = false;
  int motions_ = 0;
  int tries_ = 0;           ///< for this intent
  double lifted_from_ = 0;  ///< height of the object before lifting, m
  std::optional<std::size_t> gave_up_at_;
};

}  // namespace twin::application
