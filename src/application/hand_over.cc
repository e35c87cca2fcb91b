#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <Eigen/Core>

#include "application/applications.h"
#include "application/pick.h"
#include "application/pick_steps.h"
#include "twin/core/error.h"
#include "twin/model/transform.h"

namespace twin::application {
namespace {

using Eigen::Vector3d;

constexpr const char* kName = "hand_over";
// What the robots tell each other.
constexpr const char* kOffered = "offered";  ///< the giver holds the object out and stands still
constexpr const char* kTaken = "taken";      ///< the receiver holds it
constexpr const char* kClear = "clear";      ///< the giver has let go and stands aside

/// A hand has lost its object after so long: the other hand's fingers move it as they close.
constexpr Duration kLost = std::chrono::milliseconds(200);
/// Both hands hold the object for so long before the giver lets go.
constexpr Duration kTogether = std::chrono::milliseconds(300);

struct HandOverParameters {
  explicit HandOverParameters(control::ParameterReader& parameters);

  bool gives;           ///< [role]
  std::string partner;  ///< robot of the cell [partner]
  std::string partner_key;
  Handling handling;
  double off_centre = 0;            ///< of both hands on the object, m [grasp.off_centre]
  Duration timeout{};               ///< longest time without a word [timeout]
  scenario::FramePose meet;         ///< of the giver: the object's pose in the world [meet]
  double withdraw = 0;              ///< m, back from the object, after the retreat [withdraw]
  std::optional<PutDown> put_down;  ///< of the receiver
  control::Parameters controller;
};

HandOverParameters::HandOverParameters(control::ParameterReader& p)
    : gives(p.Choice("role", "", {"giver", "receiver"}) == "giver"),
      partner(p.Text("partner", "")),
      partner_key(p.PlaceOf("partner")),
      handling(p),
      off_centre(p.Quantity("grasp.off_centre", Dimension::kLength, 0.06, 0.02, 0.5)),
      timeout(p.Time("timeout", std::chrono::seconds(120), std::chrono::seconds(1),
                     std::chrono::seconds(600))) {
  if (!p.Has("role")) p.Refuse("role", "is missing; say giver or receiver");
  if (partner.empty()) p.Refuse("partner", "is missing; name another robot of the cell");
  if (gives) {
    if (!p.Has("meet.position")) {
      p.Refuse("meet.position", "is missing; say where the object is handed over, in the world");
    }
    meet = ReadPlace(p, "meet");
    withdraw = p.Quantity("withdraw", Dimension::kLength, 0.2, 0, 1);
    handling.options.gap = 0;
  } else {
    put_down.emplace(p);
  }
  controller = p.Below("controller");
}

class HandOver final : public Application {
 public:
  explicit HandOver(control::ParameterReader& parameters)
      : parameters_(parameters), steps_(parameters_.handling, parameters_.controller) {}

  void Require(const scenario::Scenario& scenario) const override;
  void RequirePartners(const scenario::Scenario& scenario, const Partners* partners) const override;
  [[nodiscard]] Duration longest(const scenario::Scenario& /*scenario*/) const override {
    return std::chrono::seconds(180);
  }
  void Perform(Stage& stage) override;
  [[nodiscard]] Evaluation Evaluate(const TaskResult& task_result,
                                    const Evidence& evidence) override {
    return EvaluatePick(steps_.record(), task_result, evidence);
  }

 private:
  [[nodiscard]] PickTask TaskOfGiver(const Partners& partners) const;
  [[nodiscard]] PickTask TaskOfReceiver(const Message& offer);
  void Give();
  void Receive();
  // Steps of the giver.
  StepEnd Offer();
  StepEnd AwaitTaker();
  StepEnd StandAside();
  // Steps of the receiver.
  StepEnd AwaitOffer();
  StepEnd Take();
  StepEnd AwaitRelease();

  /// Lets the robot's time pass until the partner says a word, at most for `timeout`.
  /// @param holds  the hand holds the object meanwhile, and must not lose it.
  [[nodiscard]] OrReason<Message> Await(std::string_view word, bool holds);
  /// @param q_to  as Message's.
  void Say(const char* word, const JointVector& q_to);
  [[nodiscard]] const std::string& name() const {
    return stage_->partners->robots()[stage_->partners->own()].name;
  }

  const HandOverParameters parameters_;
  PickSteps steps_;
  Stage* stage_ = nullptr;      ///< during Perform()
  std::size_t partner_ = 0;     ///< index among the partners
  JointVector q_partner_{};     ///< where the partner stands, or will, rad
  JointVector q_then_{};        ///< the same from the lift on
  double width_ = kHandStroke;  ///< of the partner's hand, m
};

void HandOver::Require(const scenario::Scenario& scenario) const {
  PickTask task = ObjectOf(scenario, parameters_.handling);
  if (parameters_.put_down) AddGoal(scenario, *parameters_.put_down, task);
  RequireFingers(scenario);
}

void HandOver::RequirePartners(const scenario::Scenario& /*scenario*/,
                               const Partners* partners) const {
  if (partners == nullptr) {
    throw InputError(
        fmt::format("{}the application {} takes two robots; describe both under robots, as "
                    "cells/hand_over.yaml does",
                    parameters_.partner_key, kName));
  }
  const auto index = partners->Find(parameters_.partner);
  if (!index) {
    throw InputError(
        fmt::format("{}\"{}\" is no other robot of the cell that this one can reach; there are: {}",
                    parameters_.partner_key, parameters_.partner, partners->Names()));
  }
  const scenario::CellRobot& partner = partners->robots()[*index];
  const auto& section = partner.scenario.application;
  if (!section || section->type != kName) {
    throw InputError(fmt::format(
        "{}{} has {}; it must have the application {}, too", parameters_.partner_key, partner.name,
        section ? fmt::format("the application {}", section->type) : "a motion", kName));
  }
  control::ParameterReader reader(section->parameters, "application.parameters");
  const HandOverParameters other(reader);
  const std::string& own = partners->robots()[partners->own()].name;
  if (other.partner != own) {
    throw InputError(fmt::format("{}the partner of {} is \"{}\", not {}", parameters_.partner_key,
                                 partner.name, other.partner, own));
  }
  if (other.gives == parameters_.gives) {
    throw InputError(fmt::format(
        "{}{} and {} are both {}s; say role: {} for one of them", parameters_.partner_key, own,
        partner.name, other.gives ? "giver" : "receiver", other.gives ? "receiver" : "giver"));
  }
  if (other.handling.object != parameters_.handling.object) {
    throw InputError(fmt::format("{}{} hands over \"{}\", and {} \"{}\"; name the same object",
                                 parameters_.partner_key, own, parameters_.handling.object,
                                 partner.name, other.handling.object));
  }
}

PickTask HandOver::TaskOfGiver(const Partners& partners) const {
  PickTask task = ObjectOf(stage_->scenario, parameters_.handling);
  task.O_T_goal = model::Multiply(model::Inverse(task.X_WO), parameters_.meet.Matrix());
  // The hand on the near end of the object leaves the far one to the partner.
  Vector3d home = -model::Position(task.O_T_goal);
  home.z() = 0;
  home.normalize();
  const Vector3d B_home = model::Orientation(task.O_T_goal).conjugate() * home;
  task.grip = {.off_centre = parameters_.off_centre,
               .B_side = {B_home.x(), B_home.y(), B_home.z()}};
  const Vector3d back = parameters_.withdraw * home;
  task.withdraw = {back.x(), back.y(), back.z()};
  task.around = [this, other = partner_, start = partners.StartOf(partner_)](
                    planning::CollisionWorld& world, Leg leg) {
    world.PlaceArm(other, leg == kRetreat ? q_partner_ : start, width_);
  };
  return task;
}

PickTask HandOver::TaskOfReceiver(const Message& offer) {
  PickTask task = ObjectOf(stage_->scenario, parameters_.handling);
  AddGoal(stage_->scenario, *parameters_.put_down, task);
  steps_.record().support = std::exchange(task.from, "");
  task.from_up = {0, 0, 1};
  task.O_T_object = model::Multiply(model::Inverse(task.X_WO), offer.X_WB);
  task.object.X_WB = task.O_T_object;
  task.grip = {.off_centre = parameters_.off_centre,
               .B_side = {-offer.B_hand[0], -offer.B_hand[1], -offer.B_hand[2]}};
  q_partner_ = offer.q;
  q_then_ = offer.q_to;
  width_ = offer.width;
  task.around = [this, other = partner_](planning::CollisionWorld& world, Leg leg) {
    const bool is_aside = leg >= kLift;
    world.PlaceArm(other, is_aside ? q_then_ : q_partner_, is_aside ? kHandStroke : width_);
  };
  return task;
}

void HandOver::Perform(Stage& stage) {
  stage_ = &stage;
  partner_ = stage.partners->Find(parameters_.partner).value();
  steps_.record().partner = parameters_.partner;
  parameters_.gives ? Give() : Receive();
  stage_ = nullptr;
}

void HandOver::Give() {
  q_partner_ = stage_->partners->StartOf(partner_);
  steps_.Begin(*stage_, TaskOfGiver(*stage_->partners));
  stage_->Carry({StepOf(steps_, "plan", &PickSteps::Plan),
                 StepOf(steps_, "approach", &PickSteps::Approach, "approach", 2),
                 StepOf(steps_, "grasp", &PickSteps::Grasp, "approach", parameters_.handling.tries),
                 StepOf(steps_, "lift", &PickSteps::Lift, "approach", 2),
                 StepOf(steps_, "transfer", &PickSteps::Transfer, "transfer", 2),
                 StepOf(*this, "offer", &HandOver::Offer, "offer", 2),
                 StepOf(*this, "await taker", &HandOver::AwaitTaker),
                 StepOf(steps_, "release", &PickSteps::Release),
                 StepOf(*this, "stand aside", &HandOver::StandAside, "stand aside", 2)});
}

void HandOver::Receive() {
  stage_->Carry({StepOf(*this, "await offer", &HandOver::AwaitOffer),
                 StepOf(steps_, "plan", &PickSteps::Plan),
                 StepOf(steps_, "approach", &PickSteps::Approach, "approach", 2),
                 StepOf(steps_, "grasp", &PickSteps::Grasp, "approach", parameters_.handling.tries),
                 StepOf(*this, "take", &HandOver::Take),
                 StepOf(*this, "await release", &HandOver::AwaitRelease),
                 StepOf(steps_, "lift", &PickSteps::Lift, "lift", 2),
                 StepOf(steps_, "transfer", &PickSteps::Transfer, "transfer", 2),
                 StepOf(steps_, "place", &PickSteps::Place, "place", 2),
                 StepOf(steps_, "release", &PickSteps::Release),
                 StepOf(steps_, "retreat", &PickSteps::Retreat, "retreat", 2)});
}

StepEnd HandOver::Offer() {
  StepEnd end = steps_.Place();
  if (!end.succeeded) return end;
  if (stage_->session.WaitForRest() != run::WaitEnd::kDone) {
    return {false, "the arm does not come to rest"};
  }
  steps_.record().offered = stage_->session.Now();
  Say(kOffered, steps_.plan().legs[kRetreat].q_end);
  return end;
}

StepEnd HandOver::AwaitTaker() {
  auto heard = Await(kTaken, true);
  if (auto* why = std::get_if<std::string>(&heard)) return {false, std::move(*why)};
  q_partner_ = std::get<Message>(heard).q;
  width_ = std::get<Message>(heard).width;
  const run::WaitEnd end =
      stage_->session.Wait(kTogether, [](const RobotState& /*state*/) { return false; });
  return {end == run::WaitEnd::kTimeLimit, ""};
}

StepEnd HandOver::StandAside() {
  // Between the arms as they stand now.
  if (StepEnd end = steps_.PlanFrom(kRetreat); !end.succeeded) return end;
  StepEnd end = steps_.Retreat();
  if (end.succeeded) Say(kClear, stage_->session.ReadState().q);
  return end;
}

StepEnd HandOver::AwaitOffer() {
  auto heard = Await(kOffered, false);
  if (auto* why = std::get_if<std::string>(&heard)) return {false, std::move(*why)};
  steps_.Begin(*stage_, TaskOfReceiver(std::get<Message>(heard)));
  return {};
}

StepEnd HandOver::Take() {
  steps_.Bear();
  Say(kTaken, stage_->session.ReadState().q);
  return {};
}

StepEnd HandOver::AwaitRelease() {
  auto heard = Await(kClear, true);
  if (auto* why = std::get_if<std::string>(&heard)) return {false, std::move(*why)};
  q_then_ = std::get<Message>(heard).q;
  return steps_.PlanFrom(kLift);
}

OrReason<Message> HandOver::Await(std::string_view word, bool holds) {
  const MessageBoard& board = stage_->partners->board();
  const std::string& partner = parameters_.partner;
  std::optional<Message> heard;
  std::optional<std::string> ended;
  bool is_lost = false;
  Time held = stage_->session.Now();
  const auto done = [&](const RobotState& /*state*/) {
    heard = board.Heard(partner_, word, stage_->session.Now());
    ended = board.EndOf(partner_, stage_->session.Now());
    if (!holds || steps_.Holds()) held = stage_->session.Now();
    is_lost = stage_->session.Now() - held > kLost;
    return heard || ended || is_lost;
  };
  const run::WaitEnd end = stage_->session.Wait(parameters_.timeout, done);
  if (is_lost) {
    return fmt::format("the hand lost the {}: it stands at {:.1f} mm", parameters_.handling.object,
                       steps_.hand_state().width * 1e3);
  }
  if (heard) return *heard;
  if (ended) {
    return fmt::format("{} has ended without having said \"{}\"{}{}", partner, word,
                       ended->empty() ? "" : ": ", *ended);
  }
  if (end == run::WaitEnd::kInterrupted) return "interrupted";
  return fmt::format("{} has not said \"{}\" within {:g} s (timeout)", partner, word,
                     ToSeconds(parameters_.timeout));
}

void HandOver::Say(const char* word, const JointVector& q_to) {
  const RobotState state = stage_->session.ReadState();
  const Transform& B_T_NE = steps_.plan().grip.B_T_NE;
  Message message{.word = word,
                  .at = stage_->session.Now(),
                  .q = state.q,
                  .width = steps_.hand_state().width,
                  .q_to = q_to,
                  .X_WB = steps_.ObjectAt(state.O_T_EE),
                  .B_hand = {B_T_NE[12], B_T_NE[13], B_T_NE[14]}};
  stage_->session.Tell("message", fmt::format("{} to {}: {} {}", name(), parameters_.partner,
                                              parameters_.handling.object, word));
  stage_->partners->Say(std::move(message));
}

}  // namespace

std::unique_ptr<Application> MakeHandOver(control::ParameterReader& parameters) {
  return std::make_unique<HandOver>(parameters);
}

}  // namespace twin::application
