#include "twin/application/record_cell.h"

#include <algorithm>
#include <deque>
#include <exception>
#include <fstream>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "twin/application/application.h"
#include "twin/application/partners.h"
#include "twin/application/validate.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/loop/shared_time.h"
#include "twin/plant/shared_model.h"
#include "twin/replay/cell_recording.h"
#include "twin/replay/recording.h"
#include "twin/rt/fiber.h"
#include "twin/rt/fiber_thread.h"
#include "twin/run/film.h"
#include "twin/run/islands.h"
#include "twin/run/result_folder.h"
#include "twin/run/summary.h"

namespace twin::application {
namespace {

using Json = nlohmann::ordered_json;

std::string NamesOf(const run::Island& island) {
  std::vector<std::string> names;
  for (const scenario::CellRobot& robot : island.robots) names.push_back(robot.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// A file that a robot's run has written; an empty object where it ended before.
Json ReadResult(const std::filesystem::path& path) {
  std::ifstream file(path);
  Json result = Json::parse(file, nullptr, false);
  return result.is_object() ? result : Json::object();
}

/// With the robot's neighbours.
run::RunFiles FilesFor(const Partners& partners, run::RunFiles files) {
  files.neighbours = {partners.robots(), partners.own()};
  return files;
}

/// What a robot's run says, with the robot's name.
class RobotConsole final : public run::Console {
 public:
  /// @param mutex  of `console`.
  RobotConsole(run::Console& console, std::mutex& mutex, std::string name)
      : console_(console), mutex_(mutex), name_(std::move(name)) {}

  void Print(std::string_view text) override { Locked()->Print(Marked(text)); }
  void Say(std::string_view text) override { Locked()->Say(Marked(text)); }
  void Debug(std::string_view text) override { Locked()->Debug(Named(text)); }
  void Note(std::string_view text) override { Locked()->Note(Named(text)); }
  void Warn(std::string_view text) override { Locked()->Warn(Named(text)); }
  void Show(std::string_view work, double share, std::string_view note) override {
    Locked()->Show(work, share, Named(note));
  }
  [[nodiscard]] const volatile bool& interrupted() const noexcept override {
    return console_.interrupted();
  }
  void Interrupt() noexcept override { console_.Interrupt(); }

 private:
  /// The console, for one call.
  class Lock {
   public:
    explicit Lock(const RobotConsole& robot) : console_(robot.console_), lock_(robot.mutex_) {}
    run::Console* operator->() const noexcept { return &console_; }

   private:
    run::Console& console_;
    const std::lock_guard<std::mutex> lock_;
  };
  [[nodiscard]] Lock Locked() const { return Lock(*this); }
  [[nodiscard]] std::string Named(std::string_view text) const {
    return fmt::format("{}: {}", name_, text);
  }
  /// Each line with the name in front.
  [[nodiscard]] std::string Marked(std::string_view text) const {
    std::string marked;
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
      marked += fmt::format("{}: {}", name_, text.substr(0, end));
      text.remove_prefix(end);
    }
    return marked;
  }

  run::Console& console_;
  std::mutex& mutex_;
  const std::string name_;
};

/// How a robot's run ended.
struct RobotEnd {
  std::string name;
  std::string shares_with;  ///< names of its island's robots
  std::string failure;      ///< empty: success
};

class CellRecorder {
 public:
  explicit CellRecorder(const CellInputs& inputs) : inputs_(inputs), out_(inputs.options.out) {}

  void Execute();

 private:
  [[nodiscard]] const scenario::Scenario& common() const { return inputs_.cell.common; }
  [[nodiscard]] bool makes_video() const {
    return common().render.enabled && common().record && inputs_.options.makes_video;
  }
  /// Refuses what a run would, before the first of them.
  void RequireSound(const run::Island& island) const;
  void RunIsland(const run::Island& island);
  /// On one thread, in turn.
  void RunInTurn(MessageBoard& board, std::span<RobotEnd* const> ends);
  /// On a thread for each, and one for all robots.
  void RunTogether(MessageBoard& board, std::span<RobotEnd* const> ends);
  /// @param backends  of the run. @param seat  in real time; else null.
  /// Never throws: what it would is in the robot's end, or in why_.
  void RunRobot(const Partners& partners, const backend::Registry& backends, RobotEnd& end,
                loop::SharedTime::Seat* seat = nullptr);
  /// Sums up what their runs took.
  void TakeTimesOfRobots();
  [[nodiscard]] Json Summary() const;
  void MakeVideo();

  const MonotonicClock clock_;
  const CellInputs inputs_;
  run::ResultFolder out_;
  run::WallTimes times_;
  std::mutex mutex_;           ///< of the console and of why_
  std::exception_ptr why_{};   ///< the first of the robots' for which the whole cannot go on
  std::deque<RobotEnd> ends_;  ///< in the order of the robots
};

void CellRecorder::Execute() {
  out_.RequireOther(inputs_.options.scenario);
  run::RequireApartAtStart(inputs_.cell, inputs_.files);
  if (makes_video()) {
    replay::CheckCellPicture(inputs_.cell, inputs_.files, inputs_.options.scenario);
  }
  const std::vector<run::Island> islands = run::IslandsOf(inputs_.cell, inputs_.files);
  for (const run::Island& island : islands) RequireSound(island);
  inputs_.console.ThrowIfInterrupted();
  out_.Prepare();
  out_.Clear();
  times_.prepare_s = ToSeconds(clock_.Now().time_since_epoch());
  run::WriteWholeFile(out_.scenario(), scenario::ToYaml(inputs_.cell));
  const Time begin = clock_.Now();
  for (const run::Island& island : islands) RunIsland(island);
  times_.run_s = ToSeconds(clock_.Now() - begin);
  TakeTimesOfRobots();
  const Json summary = Summary();
  run::WriteWholeFile(out_.summary(), run::TextOf(summary));
  if (why_) std::rethrow_exception(why_);
  inputs_.console.ThrowIfInterrupted();
  times_.real_time_factor = summary.value("simulated_s", 0.0) / times_.run_s;
  if (makes_video()) MakeVideo();
  run::WriteWholeFile(out_.timing(), run::TimingJson(times_, {}));
  std::string failures;
  for (const RobotEnd& end : ends_) {
    if (end.failure.empty()) continue;
    failures += fmt::format("{}{}: {}", failures.empty() ? "" : "; ", end.name, end.failure);
  }
  inputs_.console.Print(fmt::format("{}: {}; files  {}\n", common().name,
                                    failures.empty() ? "success" : "failed",
                                    out_.folder().string()));
  if (!failures.empty()) throw RobotFault(failures);
}

void CellRecorder::RequireSound(const run::Island& island) const {
  MessageBoard board(island.robots);
  for (std::size_t i = 0; i < island.robots.size(); ++i) {
    const scenario::Scenario& scenario = island.robots[i].scenario;
    const Partners partners(board, i);
    if (scenario.application) {
      static_cast<void>(Make(scenario, &partners));
      continue;
    }
    try {
      static_cast<void>(
          run::Run(scenario, inputs_.catalogue, FilesFor(partners, inputs_.files), nullptr));
    } catch (const run::NoPlanError&) {  // its run reports it; the others go on
    }
  }
}

void CellRecorder::RunRobot(const Partners& partners, const backend::Registry& backends,
                            RobotEnd& end, loop::SharedTime::Seat* seat) {
  const scenario::CellRobot& robot = partners.robots()[partners.own()];
  RobotConsole console(inputs_.console, mutex_, robot.name);
  RunOptions options = inputs_.options;
  options.settings.threads.seat = seat;
  options.out = out_.folder() / robot.name;
  options.makes_video = false;
  options.hardware = {};
  const run::Catalogue catalogue{backends, inputs_.catalogue.controllers,
                                 inputs_.catalogue.devices};
  try {
    RecordRun({robot.scenario, options, FilesFor(partners, inputs_.files), catalogue, console,
               &partners});
  } catch (const RobotFault& fault) {
    end.failure = fault.what();
  } catch (const run::NoPlanError& error) {
    end.failure = error.what();
  } catch (...) {
    const std::lock_guard lock(mutex_);
    if (!why_) why_ = std::current_exception();
    console.Interrupt();  // the others stop, too
  }
  partners.board().End(partners.own(), end.failure);
}

void CellRecorder::RunIsland(const run::Island& island) {
  std::vector<RobotEnd*> ends;
  for (const scenario::CellRobot& robot : island.robots) {
    ends.push_back(&ends_.emplace_back(
        RobotEnd{.name = robot.name, .shares_with = NamesOf(island), .failure = {}}));
  }
  const backend::Registry& known = inputs_.catalogue.backends;
  MessageBoard board(island.robots);
  if (island.robots.size() == 1) return RunRobot(Partners(board, 0), known, *ends.front());
  common().is_lockstep() ? RunInTurn(board, ends) : RunTogether(board, ends);
}

void CellRecorder::RunInTurn(MessageBoard& board, std::span<RobotEnd* const> ends) {
  const auto shared = plant::SharedModel::Create(run::PlantsOf(board.robots(), inputs_.files),
                                                 [] { rt::Fiber::Yield(); });
  std::deque<backend::Registry> seats;
  std::deque<rt::Fiber> runs;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const backend::Registry& seat =
        seats.emplace_back(run::SeatOf(board.robots()[i], shared, inputs_.catalogue.backends));
    runs.emplace_back([this, partners = Partners(board, i), &seat, end = ends[i], &shared] {
      RunRobot(partners, seat, *end);
      shared->Forgo(run::PrefixOf(partners.robots()[partners.own()]));
    });
  }
  rt::ResumeInTurn(runs);
}

void CellRecorder::RunTogether(MessageBoard& board, std::span<RobotEnd* const> ends) {
  const auto shared = plant::SharedModel::Create(run::PlantsOf(board.robots(), inputs_.files),
                                                 rt::FiberThread::GiveWay);
  loop::SharedTime time(ends.size(), inputs_.options.settings.threads.robot,
                        [&shared] { shared->Release(); });
  const auto run = [&](std::size_t i) {
    const backend::Registry backends =
        run::SeatOf(board.robots()[i], shared, inputs_.catalogue.backends);
    // Robots that wait for a message of this one must not wait any longer.
    loop::SharedTime::Seat seat(time, [&board, i] { board.End(i, ""); });
    RunRobot(Partners(board, i), backends, *ends[i], &seat);
    shared->Forgo(run::PrefixOf(board.robots()[i]));
  };
  // The runs wait for each other, so none begins unless each has its thread.
  std::promise<bool> all_started;
  const std::shared_future<bool> begins = all_started.get_future();
  std::vector<std::jthread> runs;
  runs.reserve(ends.size());
  try {
    for (std::size_t i = 0; i < ends.size(); ++i) {
      runs.emplace_back([&run, begins, i] {
        if (begins.get()) run(i);
      });
    }
  } catch (const std::system_error& error) {
    all_started.set_value(false);
    throw EnvironmentError(fmt::format(
        "the operating system refused a thread for each robot: {}; see ulimit -u", error.what()));
  }
  all_started.set_value(true);
  runs.clear();
  for (const std::string& notice : time.notices()) inputs_.console.Note("robots: " + notice);
}

void CellRecorder::TakeTimesOfRobots() {
  double longest_s = 0;
  for (const RobotEnd& end : ends_) {
    const Json own = ReadResult(run::ResultFolder(out_.folder() / end.name).timing());
    const double prepare_s = own.value("prepare_s", 0.0);
    const double plots_s = own.value("plots_s", 0.0);
    times_.prepare_s += prepare_s;
    times_.plots_s += plots_s;
    times_.run_s -= prepare_s + plots_s;
    longest_s = std::max(longest_s, own.value("run_s", 0.0));
    times_.peak_memory_mb = std::max(times_.peak_memory_mb, own.value("peak_memory_mb", 0.0));
  }
  // In real time the runs overlap.
  if (!common().is_lockstep()) times_.run_s = longest_s;
}

Json CellRecorder::Summary() const {
  Json robots = Json::object();
  bool succeeded = true;
  double longest = 0;
  for (const RobotEnd& end : ends_) {
    succeeded = succeeded && end.failure.empty();
    const Json own = ReadResult(run::ResultFolder(out_.folder() / end.name).summary());
    Json& robot = robots[end.name];
    robot = {{"folder", end.name}, {"shares_a_model", end.shares_with}};
    for (const char* key :
         {"outcome", "failure", "violations", "simulated_s", "contacts", "states_hash"}) {
      if (own.contains(key)) robot[key] = own[key];
    }
    longest = std::max(longest, robot.value("simulated_s", 0.0));
  }
  return {{"scenario", common().name},
          {"seed", common().seed},
          {"outcome", succeeded ? "success" : "failed"},
          {"simulated_s", longest},
          {"robots", robots}};
}

void CellRecorder::MakeVideo() {
  const replay::CellRecording recording(out_.folder(), inputs_.files);
  render::FilmSettings settings = run::FilmOf(common().render);
  if (inputs_.options.has_fine_pictures) settings = run::Fine(settings);
  times_.video_s = replay::RenderClip(render::FramesOf(recording.Film(), settings),
                                      {out_.video(), out_.contact_sheet()}, clock_, inputs_.console)
                       .seconds;
}

}  // namespace

void RecordCell(const CellInputs& inputs) {
  CellRecorder(inputs).Execute();
}

std::string ValidateCell(const scenario::Cell& cell, const std::filesystem::path& file,
                         const run::Catalogue& catalogue, const run::RunFiles& files) {
  std::map<std::string, std::string> texts;  // in the order of the names
  std::string together;
  for (const run::Island& island : run::IslandsOf(cell, files)) {
    MessageBoard board(island.robots);
    for (std::size_t i = 0; i < island.robots.size(); ++i) {
      const Partners partners(board, i);
      const scenario::CellRobot& robot = island.robots[i];
      texts[robot.name] = Validate(robot.scenario, file, catalogue, FilesFor(partners, files),
                                   LibraryCheck::kNotLoaded, &partners);
    }
    if (island.robots.size() > 1 && cell.common.is_lockstep()) {
      together += fmt::format("  reach each other  {}\n", NamesOf(island));
    }
  }
  run::RequireApartAtStart(cell, files);
  if (cell.common.render.enabled) replay::CheckCellPicture(cell, files, file);
  std::string text;
  for (const auto& [name, checked] : texts) text += fmt::format("{}:\n{}", name, checked);
  return text + together;
}

}  // namespace twin::application
