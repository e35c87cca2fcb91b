#include "twin_session.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "controllers/registration.h"
#include "law.h"
#include "twin/backend/hand.h"
#include "twin/backend/registry.h"
#include "twin/core/error.h"
#include "twin/robot/robot.h"
#include "twin/run/plan_to.h"
#include "twin/run/robot_config.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/names.h"

namespace twin::python {
namespace {

constexpr const char* kLaw = "python_law";
/// Longest motion under a law, and longest log of scenes.
constexpr Duration kLongest = std::chrono::hours(24);

std::uint64_t NextId() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

scenario::Scenario ScenarioOf(const Opening& opening) {
  scenario::Scenario scenario =
      opening.text ? scenario::ParseServed(*opening.text, opening.file)
                   : scenario::LoadServed(scenario::FindScenario(opening.file, Files().models));
  if (opening.lab) {
    scenario::ApplyLab(scenario::FindLab(*opening.lab, Files().models), scenario);
  }
  if (opening.seed) scenario.seed = *opening.seed;
  if (scenario.is_remote()) {
    throw InputError(
        "backend fci: a session simulates its robot; leave backend out, or move a real arm by "
        "panda-twin run");
  }
  scenario.Validate();
  return scenario;
}

control::CommandInterface InterfaceOf(const std::string& name) {
  std::string names;
  for (const auto& [known, interface] : scenario::kInterfaceNames) {
    if (known == name) return interface;
    names += (names.empty() ? "" : ", ") + std::string(known);
  }
  throw InputError(fmt::format("interface \"{}\": unknown; there are {}", name, names));
}

ControllerMode ImpedanceOf(const std::string& name) {
  for (const ControllerMode mode :
       {ControllerMode::kJointImpedance, ControllerMode::kCartesianImpedance}) {
    if (Name(mode) == name) return mode;
  }
  throw InputError(fmt::format(
      "impedance \"{}\": unknown; there are joint_impedance, cartesian_impedance", name));
}

/// A section `tick`, with the defaults that it has on this interface in a scenario of a bare loop.
scenario::TickSection TickOf(const std::string& section, control::CommandInterface interface) {
  return scenario::Parse(
             fmt::format("name: control\nloop: bare\nmotion:\n  interface: {}\n  trajectory: "
                         "{{unit: rad, waypoints: [{{q: [0, 0, 0, -2, 0, 2, 0]}}, {{q: [0, 0, 0, "
                         "-2, 0, 2, 0.1]}}]}}\ntick: {}\n",
                         scenario::NameOf(scenario::kInterfaceNames, interface), section),
             "tick")
      .tick;
}

}  // namespace

/// The one call that is under way.
class TwinSession::Use {
 public:
  explicit Use(TwinSession& session) : session_(session) {
    if (session.records_) session.home_.Require("a session with a log");
    if (session.clock_ != nullptr) call_.emplace(*session.clock_, session.robot_);
    if (session.in_use_.exchange(true, std::memory_order_acq_rel)) {
      throw std::runtime_error(
          "the session is in use, by another thread or by the call whose law this is; take one "
          "session for each thread");
    }
    if (!session.session_) {
      Leave();
      throw InputError("the session is closed; open another");
    }
  }
  ~Use() { Leave(); }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

 private:
  void Leave() { session_.in_use_.store(false, std::memory_order_release); }

  TwinSession& session_;
  std::optional<CellClock::Call> call_;
};

TwinSession::TwinSession(const Opening& opening)
    : TwinSession(ScenarioOf(opening), opening.log, nullptr) {}

TwinSession::TwinSession(const scenario::Scenario& scenario,
                         const std::optional<std::filesystem::path>& log, const Seat& seat)
    : TwinSession(scenario, log, &seat) {}

TwinSession::TwinSession(scenario::Scenario scenario,
                         const std::optional<std::filesystem::path>& log, const Seat* seat)
    : id_(NextId()),
      scenario_(std::move(scenario)),
      files_(seat == nullptr ? Files() : seat->files),
      clock_(seat == nullptr ? nullptr : &seat->clock),
      robot_(seat == nullptr ? 0 : seat->robot) {
  controllers::RegisterControllers(controllers_);
  controllers_.Add(kLaw, [this](const control::ControllerRequest& /*request*/) { return law_(); });
  if (log) records_ = std::make_unique<run::RunRecords>();
  session_ = Connect(seat == nullptr ? TheCatalogue().backends : seat->backends);
  Begin(log);
}

std::unique_ptr<run::Session> TwinSession::Connect(const backend::Registry& backends) {
  record::RecordSink* sink = records_.get();
  if (clock_ != nullptr) {
    ends_ = std::make_unique<CycleEnds>(*clock_, robot_, sink);
    sink = ends_.get();
    clock_->SetLead(robot_, [this] {
      const std::uint64_t before = clock_->cycles(robot_);
      session_->PassUntil([this, before] { return clock_->cycles(robot_) > before; });
    });
  }
  return std::make_unique<run::Session>(
      scenario_, run::Catalogue{backends, controllers_, TheCatalogue().devices}, files_, sink);
}

void TwinSession::Begin(const std::optional<std::filesystem::path>& log) {
  run::RunHooks hooks;
  if (records_) {
    records_->Log(*log, run::InfoOf(scenario_, session_->robot()),
                  scenario_.is_lockstep() ? record::FullRing::kWait : record::FullRing::kDrop);
    if (const plant::TruthProbe* truth = session_->connection().truth) {
      if (run::RunRecords::CanFilm(*truth)) {
        records_->Film(*truth, kLongest, scenario_.render.fps,
                       render::SnapshotRecorder::Keep::kLast);
      }
      records_->WatchContacts(*truth);
    }
    hooks.event = [this](Time at, std::string_view kind, std::string_view text) {
      records_->Event(at, kind, text);
    };
  }
  hooks.interrupted = &signals_.interrupted();
  hooks.look = [this] { Look(); };
  session_->Begin(hooks);
}

TwinSession::~TwinSession() {
  if (records_ && home_.is_elsewhere()) {  // their threads are not here to be joined
    static_cast<void>(session_.release());
    static_cast<void>(records_.release());
  }
  session_.reset();  // a log that was not completed stays partial
}

RobotState TwinSession::State() {
  const Use use(*this);
  return scenario_.is_lockstep() ? session_->Peek() : session_->ReadState();
}

double TwinSession::Now() {
  const Use use(*this);
  return ToSeconds(session_->Now().time_since_epoch());
}

void TwinSession::Look() {
  signals_.Look();
  if (clock_ != nullptr && clock_->is_stopping()) signals_.Stop();
}

void TwinSession::Rethrow() {
  signals_.Rethrow();
  if (clock_ != nullptr && clock_->is_stopping()) throw Cancelled();
}

template <typename Call>
auto TwinSession::Interruptible(Call call) {
  try {
    auto result = call();
    Rethrow();
    return result;
  } catch (...) {
    Rethrow();  // why it failed
    throw;
  }
}

void TwinSession::RequireAlone(std::string_view call) const {
  if (clock_ == nullptr) return;
  throw InputError(
      fmt::format("{}: time does not go back for one robot of a cell; open the cell anew", call));
}

run::MotionResult TwinSession::Run(const run::Motion& motion) {
  return Interruptible([&] { return session_->Move(motion); });
}

run::Motion TwinSession::MotionOn(control::CommandInterface interface, const std::string& impedance,
                                  const std::string& name, reference::Trajectory trajectory) const {
  run::Motion motion = run::MotionOn(scenario_, name, interface, std::move(trajectory));
  motion.impedance = ImpedanceOf(impedance);
  if (motion.controller.type == scenario_.controller.type) return motion;
  motion.controller.library.clear();  // another controller's
  motion.controller.parameters.clear();
  return motion;
}

scenario::TickSection TwinSession::TickFor(control::CommandInterface interface) const {
  constexpr auto kTorque = control::CommandInterface::kTorque;
  scenario::TickSection tick = scenario_.tick;
  if ((interface == kTorque) != (scenario_.motion.interface == kTorque)) {
    tick = interface == kTorque ? scenario::TorqueTick() : scenario::TickSection();
    tick.cost = scenario_.tick.cost;
  } else if (!loop::Misfit(tick.generator, interface).empty()) {
    tick.generator = loop::Generator::kRejoining;
  }
  tick.period_tolerance = {};  // the bare loop has none
  return tick;
}

run::MotionResult TwinSession::MoveOwn() {
  const Use use(*this);
  const scenario::MotionSection& own = scenario_.motion;
  // A scenario without a motion stands at its start.
  const bool stands = own.waypoints.empty() || own.waypoints.front().q == own.waypoints.back().q;
  if (stands && own.waypoints.size() <= 2 && own.poses.empty() && !own.plan) {
    throw InputError("move: the scenario has no motion of its own; give a Trajectory");
  }
  return Interruptible([&] { return session_->MoveOwn(scenario_, files_); });
}

run::MotionResult TwinSession::Move(const reference::Trajectory& trajectory,
                                    const std::string& interface, const std::string& impedance,
                                    const std::string& name) {
  const Use use(*this);
  return Run(MotionOn(InterfaceOf(interface), impedance, name, trajectory));
}

run::MotionResult TwinSession::MoveTo(const JointVector& q, const std::string& interface,
                                      const reference::Timing& pace, double clearance) {
  const Use use(*this);
  const control::CommandInterface on = InterfaceOf(interface);
  if (scenario_.base) {
    throw InputError("move_to: it plans for an arm that stands on the world, without a base");
  }
  if (!world_) {
    world_ = run::MakeWorld(scenario_, session_->robot(), files_);
  }
  planning::PlannerOptions options{.clearance = clearance, .pace = pace};
  options.stopped = [this] {
    Look();
    return signals_.interrupted();
  };
  const planning::Plan plan =
      Interruptible([&] { return run::PlanTo(*session_, *world_, q, scenario_.seed, options); });
  return Run(
      MotionOn(on, std::string(Name(ControllerMode::kJointImpedance)), "move_to", plan.trajectory));
}

/// Keeps the law where the session's controllers find it.
class TwinSession::LawInUse {
 public:
  LawInUse(TwinSession& session, Law& law) : session_(session) {
    session.law_ = [&law] { return law.MakeController(); };
  }
  ~LawInUse() { session_.law_ = nullptr; }
  LawInUse(const LawInUse&) = delete;
  LawInUse& operator=(const LawInUse&) = delete;

 private:
  TwinSession& session_;
};

run::MotionResult TwinSession::Control(nb::object law, const ControlOptions& options) {
  const Use use(*this);
  if (!scenario_.is_lockstep()) {
    throw InputError(
        "control: a law runs in lockstep, whose time waits for it; say drive: lockstep");
  }
  if (options.until) {
    RequireInRange("control: until, s,", *options.until, ToSeconds(kCycle), ToSeconds(kLongest));
  }
  const Duration until = options.until ? FromSeconds(*options.until) : kLongest;
  Law called(std::move(law), until);
  const LawInUse in_use(*this, called);
  RobotState state = session_->Peek();
  const control::CommandInterface interface = called.Begin(state);
  run::MotionResult result = [&] {
    const GilReleased released;
    run::Motion motion = MotionOn(interface, options.impedance, "control",
                                  run::StandingFor(state.q_d, until, session_->robot().limits));
    motion.loop = loop::LoopKind::kBare;
    scenario::ControllerSection controller;
    controller.type = kLaw;
    controller.cost = scenario_.controller.cost;
    motion.controller = controller;
    motion.tick = options.tick ? TickOf(*options.tick, interface) : TickFor(interface);
    return Run(motion);
  }();
  called.Rethrow();
  return result;
}

run::HandOutcome TwinSession::Command(const HandCommand& command) {
  const Use use(*this);
  return Interruptible([&] { return session_->Command(command); });
}

HandState TwinSession::ReadHand() {
  const Use use(*this);
  const backend::Hand* hand = session_->connection().hand;
  if (hand == nullptr) throw InputError("hand: the scenario's robot has none (robot.hand)");
  return hand->ReadState();
}

std::vector<std::pair<std::string, Transform>> TwinSession::Bodies() {
  const Use use(*this);
  return session_->Bodies();
}

void TwinSession::Place(const std::string& body, const Transform& X_WB) {
  const Use use(*this);
  session_->Place(body, X_WB);
}

void TwinSession::Wait(double seconds) {
  const Use use(*this);
  if (!(seconds >= 0 && seconds <= ToSeconds(kLongest))) {
    throw InputError(
        fmt::format("wait: {:g} s; it must be in [0, {:g}] s", seconds, ToSeconds(kLongest)));
  }
  const auto never = [](const RobotState& /*state*/) { return false; };
  static_cast<void>(Interruptible([&] { return session_->Wait(FromSeconds(seconds), never); }));
}

void TwinSession::Recover() {
  const Use use(*this);
  static_cast<void>(Interruptible([this] {
    session_->Recover();
    return true;
  }));
}

void TwinSession::Reset(const std::optional<JointVector>& q) {
  const Use use(*this);
  RequireAlone("reset");
  const robot::Robot* robot = session_->connection().lockstep_robot;
  session_->Reset(q                  ? *q
                  : robot != nullptr ? robot->config().q_start
                                     : JointVector{});  // refused anyway
}

void TwinSession::PressUserStop(bool pressed) {
  const Use use(*this);
  session_->connection().panel->Operate(pressed ? PanelAction::kPressUserStop
                                                : PanelAction::kReleaseUserStop);
  static_cast<void>(session_->ReadState());  // which shows it
}

Snapshot TwinSession::Save() {
  const Use use(*this);
  RequireAlone("snapshot");
  return {session_->Save(), id_};
}

void TwinSession::Restore(const Snapshot& snapshot) {
  const Use use(*this);
  RequireAlone("restore");
  if (snapshot.session != id_) {
    throw InputError("restore: the snapshot is another session's");
  }
  session_->Restore(*snapshot.copy);
}

void TwinSession::Close() {
  if (is_closed()) return;
  const Use use(*this);
  result_ = session_->End();
  session_.reset();
  world_.reset();
  closed_ = true;
  if (records_) static_cast<void>(records_->Finish());
}

run::SessionResult TwinSession::Result() {
  if (!is_closed()) throw InputError("the session goes on; its result is known once it is closed");
  return *result_;
}

}  // namespace twin::python
