#include "sweep/log.h"

#include <unistd.h>

#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "twin/application/record_run.h"
#include "twin/core/error.h"
#include "twin/run/console.h"
#include "twin/run/result_folder.h"

namespace twin::sweep {
namespace {

namespace fs = std::filesystem;

/// Tells nothing: the run has been carried out before, and its result says what came of it.
class Silence final : public run::Console {
 public:
  explicit Silence(const volatile bool* interrupted)
      : interrupted_(interrupted != nullptr ? interrupted : &own_) {}

  void Print(std::string_view /*text*/) override {}
  void Say(std::string_view /*text*/) override {}
  void Debug(std::string_view /*text*/) override {}
  void Note(std::string_view /*text*/) override {}
  void Warn(std::string_view /*text*/) override {}
  void Show(std::string_view /*work*/, double /*share*/, std::string_view /*note*/) override {}
  [[nodiscard]] const volatile bool& interrupted() const noexcept override { return *interrupted_; }
  void Interrupt() noexcept override { own_ = true; }

 private:
  volatile bool own_ = false;
  const volatile bool* interrupted_;
};

}  // namespace

bool KeepsLog(const Sweep& sweep, const Result& result) noexcept {
  const scenario::SweepFile::Keep keep = sweep.file().keep;
  return keep == scenario::SweepFile::Keep::kAll ||
         (keep == scenario::SweepFile::Keep::kFailures && !result.succeeded());
}

bool KeepLog(const PreparedCase& prepared, const run::Catalogue& catalogue,
             const run::RunFiles& files, const fs::path& out, const volatile bool* interrupted) {
  const fs::path folder = LogFolderOf(out, prepared.address);
  const run::ScratchFolder own(folder.string() + fmt::format(".{}", ::getpid()));
  scenario::Scenario scenario = prepared.scenario;
  scenario.record = true;
  application::RunOptions options;
  options.scenario = prepared.scenario.name;
  options.out = own.path();
  options.makes_video = false;
  options.makes_plots = false;
  Silence console(interrupted);
  try {
    application::RecordRun({scenario, options, files, catalogue, console});
  } catch (const run::Interrupted&) {
    return false;
  } catch (const InputError&) {
    throw;
  } catch (const EnvironmentError&) {
    throw;
  } catch (const Error&) {  // the failure whose log this is
  }
  std::error_code error;
  fs::rename(own.path(), folder, error);
  if (std::error_code none;
      error && !fs::exists(folder, none)) {  // else another process was faster
    throw EnvironmentError(fmt::format("{}: {}", folder.string(), error.message()));
  }
  return true;
}

}  // namespace twin::sweep
