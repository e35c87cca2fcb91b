#include "twin_cell.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "twin/core/error.h"
#include "twin/scenario/data_directory.h"

namespace twin::python {
namespace {

scenario::Cell CellOf(const CellOpening& opening) {
  scenario::Cell cell =
      opening.text ? scenario::ParseServedCell(*opening.text, opening.file, opening.seed)
                   : scenario::LoadServedCell(scenario::FindScenario(opening.file, Files().models),
                                              opening.seed);
  if (cell.common.is_lockstep()) return cell;
  throw InputError(
      "drive: a Cell runs in lockstep; say drive: lockstep, or run or serve the scenario: panda-twin "
      "run, panda-twin serve");
}

/// A robot: its island, and its index there.
struct Placed {
  std::string name;
  std::size_t island = 0;
  std::size_t own = 0;
};

/// In the order of their names.
std::vector<Placed> PlacedIn(const std::vector<run::Island>& islands) {
  std::vector<Placed> placed;
  for (std::size_t i = 0; i < islands.size(); ++i) {
    const auto& robots = islands[i].robots;
    for (std::size_t own = 0; own < robots.size(); ++own) {
      placed.push_back({robots[own].name, i, own});
    }
  }
  std::ranges::sort(placed, {}, &Placed::name);
  return placed;
}

}  // namespace

TwinCell::TwinCell(const CellOpening& opening)
    : cell_(CellOf(opening)),
      files_(Files()),
      islands_(run::IslandsOf(cell_, files_)),
      log_(opening.log) {
  run::RequireApartAtStart(cell_, files_);
  const std::vector<Placed> placed = PlacedIn(islands_);
  std::vector<CellMember> members;
  for (const Placed& one : placed) members.push_back({one.name, one.island});
  clock_.emplace(std::move(members));
  for (std::size_t i = 0; i < islands_.size(); ++i) shared_.push_back(Share(islands_[i], i));
  if (log_) {
    if (!opening.text) run::ResultFolder(*log_).RequireOther(opening.file);
    MakeFolder(*log_, scenario::ToYaml(cell_));
  }
  for (const Placed& one : placed) Open(one.island, one.own);
}

TwinCell::~TwinCell() {
  Release();
}

std::shared_ptr<plant::SharedModel> TwinCell::Share(const run::Island& island, std::size_t number) {
  if (island.robots.size() == 1) return nullptr;
  return plant::SharedModel::Create(run::PlantsOf(island.robots, files_),
                                    [this, number] { clock_->LetOthers(number); });
}

void TwinCell::Open(std::size_t island, std::size_t own) {
  const std::vector<scenario::CellRobot>& robots = islands_[island].robots;
  const scenario::CellRobot& robot = robots[own];
  const std::shared_ptr<plant::SharedModel>& shared = shared_[island];
  const backend::Registry& known = TheCatalogue().backends;
  const backend::Registry& seat =
      seats_.emplace_back(shared ? run::SeatOf(robot, shared, known) : known);
  std::optional<std::filesystem::path> log;
  if (log_) log = MakeFolder(*log_ / robot.name, scenario::ToYaml(robot.scenario)).log();
  run::RunFiles files = files_;
  files.neighbours = {robots, own};
  sessions_.emplace_back(
      robot.scenario, log,
      Seat{.clock = *clock_, .robot = sessions_.size(), .backends = seat, .files = files});
}

run::ResultFolder& TwinCell::MakeFolder(const std::filesystem::path& folder,
                                        const std::string& scenario) {
  run::ResultFolder& made = folders_.emplace_back(folder);
  made.Prepare();
  made.Clear();
  run::WriteWholeFile(made.scenario(), scenario);
  return made;
}

std::vector<std::string> TwinCell::Names() const {
  std::vector<std::string> names;
  for (const scenario::CellRobot& robot : cell_.robots) names.push_back(robot.name);
  return names;
}

void TwinCell::AwaitEnd() {
  static constexpr std::chrono::milliseconds kLook(50);
  const auto wait = [this] {
    const GilReleased released;
    return clock_->AwaitEnd(kLook);
  };
  std::exception_ptr raised;
  while (!wait()) {
    if (raised || PyErr_CheckSignals() == 0) continue;
    try {
      throw nb::python_error();
    } catch (...) {
      raised = std::current_exception();
    }
    clock_->Stop();
  }
  if (raised) std::rethrow_exception(raised);
}

void TwinCell::Release() noexcept {
  for (const auto& shared : shared_) {
    if (shared) shared->Release();
  }
}

void TwinCell::Close() {
  if (is_closed()) return;
  clock_->RequireIdle();
  Release();
  for (TwinSession& session : sessions_) session.Close();
  folders_.clear();
  closed_ = true;
}

}  // namespace twin::python
