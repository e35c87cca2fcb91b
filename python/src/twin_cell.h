#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bindings.h"
#include "cell_clock.h"
#include "twin/backend/registry.h"
#include "twin/plant/shared_model.h"
#include "twin/run/islands.h"
#include "twin/run/result_folder.h"
#include "twin/scenario/cell.h"
#include "twin_session.h"

namespace twin::python {

/// Where a cell's scenario comes from, and where its logs go.
struct CellOpening {
  std::optional<std::string> text;  ///< nullopt: `file` is read
  std::filesystem::path file;       ///< or the text's name in messages
  std::optional<std::uint64_t> seed;
  std::optional<std::filesystem::path> log;  ///< folder of results
};

/// The robots of a cell, for Python: a TwinSession for each, and one time of all (CellClock), in
/// lockstep. As in a run of the cell, robots that cannot reach each other have models of their own,
/// so each moves to the bit as alone.
///
/// With a log, the folder has scenario.yaml, and for each robot a folder with scenario.yaml and
/// run.mcap, as a run leaves them.
///
/// All calls are made with the GIL released, but AwaitEnd(). @throws InputError, EnvironmentError
/// as run::Session and scenario::LoadServedCell.
class TwinCell {
 public:
  explicit TwinCell(const CellOpening& opening);
  ~TwinCell();
  TwinCell(const TwinCell&) = delete;
  TwinCell& operator=(const TwinCell&) = delete;

  [[nodiscard]] const std::string& name() const noexcept { return cell_.common.name; }
  /// In their order.
  [[nodiscard]] std::vector<std::string> Names() const;
  /// @param robot  index in Names().
  [[nodiscard]] TwinSession& robot(std::size_t robot) { return sessions_.at(robot); }
  [[nodiscard]] CellClock& clock() noexcept { return *clock_; }

  /// Waits until all functions have left and handles Python's signals meanwhile, as SignalWatch: a
  /// handler that raises stops all calls. @pre the GIL is held. @throws what a handler raised.
  void AwaitEnd();

  /// Ends all sessions and completes the logs. A second call does nothing.
  /// @throws std::runtime_error while a call is under way.
  void Close();
  [[nodiscard]] bool is_closed() const noexcept { return closed_.load(); }

 private:
  /// @param island  number, of an island with several robots.
  [[nodiscard]] std::shared_ptr<plant::SharedModel> Share(const run::Island& island,
                                                          std::size_t number);
  /// Opens the session of a robot. @param island  number. @param own  index in its island.
  void Open(std::size_t island, std::size_t own);
  /// Makes a folder of results, without those of an earlier run. @returns it.
  run::ResultFolder& MakeFolder(const std::filesystem::path& folder, const std::string& scenario);
  /// From now on no session waits for another.
  void Release() noexcept;

  const scenario::Cell cell_;
  const run::RunFiles files_;
  const std::vector<run::Island> islands_;
  const std::optional<std::filesystem::path> log_;
  std::optional<CellClock> clock_;                           ///< set by the constructor
  std::vector<std::shared_ptr<plant::SharedModel>> shared_;  ///< by island; null: of one robot
  std::deque<backend::Registry> seats_;                      ///< by robot; outlive the sessions
  std::deque<run::ResultFolder> folders_;                    ///< locked; none without a log
  std::deque<TwinSession> sessions_;                         ///< by robot
  std::atomic<bool> closed_{false};
};

}  // namespace twin::python
