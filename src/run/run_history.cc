#include "twin/run/run_history.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/core/calendar_clock.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/plant/mjcf_files.h"
#include "twin/run/summary.h"

namespace twin::run {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostKept = 1000;

void AddBytes(std::string_view bytes, WordHash& hash) {
  hash.AddWord(bytes.size());
  for (const char byte : bytes) hash.AddWord(static_cast<unsigned char>(byte));
}

/// What is not a file, or not there, has no bytes: the run says so in its own words.
std::string BytesOf(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {};
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// A scene, and all files that it and the files that it includes name: beside each of these, and in
/// the folders that any of them names.
class SceneFiles {
 public:
  explicit SceneFiles(const fs::path& scene) {
    Add(scene);
    // Files that are found may name more of both.
    for (std::size_t before = 0; before != files_.size();) {
      before = files_.size();
      for (const fs::path& base : bases_) {
        for (const fs::path& folder : folders_) {
          for (const fs::path& name : names_) found_.insert(base / folder / name);
        }
      }
      for (const fs::path& file : found_) Add(file);
    }
  }

  [[nodiscard]] const std::set<fs::path>& files() const { return files_; }

 private:
  void Add(const fs::path& named) {
    const fs::path file = named.lexically_normal();
    std::error_code error;
    if (!fs::is_regular_file(file, error) || !files_.insert(file).second) return;
    if (file.extension() != ".xml") return;
    bases_.insert(file.parent_path());
    const plant::NamedFiles more = plant::FilesNamedIn(BytesOf(file));
    folders_.insert(more.folders.begin(), more.folders.end());
    for (const fs::path name : more.files) {
      names_.insert(name);
      names_.insert(name.filename());  // with strippath
    }
  }

  std::set<fs::path> files_;
  std::set<fs::path> bases_;
  std::set<fs::path> folders_{""};
  std::set<fs::path> names_;
  std::set<fs::path> found_;  ///< candidates, of which not all are there
};

double Hours(Duration time) {
  return ToSeconds(time) / 3600;
}

/// "24.0 h", "12 min".
std::string AgeText(Duration age) {
  if (age >= std::chrono::hours(1)) return fmt::format("{:.1f} h", Hours(age));
  if (age < std::chrono::minutes(1)) return "less than a minute";
  return fmt::format("{} min", std::chrono::floor<std::chrono::minutes>(age).count());
}

/// Files of the folder, the newest first; those of other programs may vanish meanwhile.
std::vector<fs::path> NewestFirst(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const fs::file_time_type written = fs::last_write_time(entry.path(), error);
    if (!error) files.emplace_back(written, entry.path());
  }
  std::ranges::sort(files, std::ranges::greater());
  std::vector<fs::path> sorted;
  sorted.reserve(files.size());
  for (auto& [written, file] : files) sorted.push_back(std::move(file));
  return sorted;
}

}  // namespace

std::string RehearsalHash(const scenario::Scenario& scenario, const RunFiles& files) {
  const scenario::Scenario usual;
  scenario::Scenario motion = scenario;
  motion.backend = usual.backend;
  motion.drive = usual.drive;
  motion.render = usual.render;
  motion.record = usual.record;
  WordHash hash;
  AddBytes(TWIN_VERSION, hash);
  AddBytes(scenario::ToYaml(motion), hash);
  if (!scenario.controller.library.empty()) AddBytes(BytesOf(scenario.controller.library), hash);
  if (!scenario.scene.empty()) {
    const SceneFiles scene(files.models / scenario.scene);
    for (const fs::path& file : scene.files()) AddBytes(BytesOf(file), hash);
  }
  return FormatHash(hash.value());
}

RunHistory::RunHistory(fs::path folder, const Clock& calendar)
    : folder_(std::move(folder)), calendar_(calendar) {}

fs::path RunHistory::FileOf(std::string_view hash, std::string_view robot) const {
  std::string name(hash);
  if (!robot.empty()) name += '@';
  for (const char c : robot) {
    name += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' ? c : '_';
  }
  return folder_ / (name + ".json");
}

void RunHistory::Keep(PastRun run) const {
  if (folder_.empty()) return;
  run.ended = calendar_.Now();
  const nlohmann::ordered_json json{
      {"hash", run.hash},
      {"scenario", run.scenario},
      {"robot", run.robot},
      {"outcome", run.failure.empty() ? "success" : "failed"},
      {"failure", run.failure},
      {"max_speed", run.max_speed},
      {"q_start_rad", run.q_start ? nlohmann::ordered_json(*run.q_start) : nullptr},
      {"ended", FormatUtc(run.ended)},
      {"ended_ns", run.ended.time_since_epoch().count()}};
  const fs::path file = FileOf(run.hash, run.robot);
  // Other programs may keep the same run: each writes a file of its own first.
  const fs::path partial = fmt::format("{}.{}.partial", file.string(), ::getpid());
  std::error_code error;
  fs::create_directories(folder_, error);
  std::ofstream out(partial, std::ios::binary);
  out << TextOf(json);
  out.close();
  if (out) fs::rename(partial, file, error);
  if (!out || error) {
    std::error_code ignored;
    fs::remove(partial, ignored);
    throw EnvironmentError(fmt::format(
        "{}: cannot be written, so that this run counts as no rehearsal; make its folder writable, "
        "or name another by XDG_STATE_HOME",
        file.string()));
  }
  const std::vector<fs::path> files = NewestFirst(folder_);
  for (std::size_t i = kMostKept; i < files.size(); ++i) fs::remove(files[i], error);
}

std::optional<PastRun> RunHistory::Find(std::string_view hash, std::string_view robot) const {
  if (folder_.empty()) return std::nullopt;
  try {
    const auto json = nlohmann::json::parse(BytesOf(FileOf(hash, robot)));
    const auto& ended_ns = json.at("ended_ns");
    if (!ended_ns.is_number_integer()) return std::nullopt;
    PastRun run{.hash = json.at("hash"),
                .scenario = json.at("scenario"),
                .robot = json.at("robot"),
                .failure = json.at("failure"),
                .max_speed = json.at("max_speed"),
                .q_start = {},
                .ended = Time(Duration(ended_ns.get<Duration::rep>()))};
    if (!json.at("q_start_rad").is_null()) run.q_start = json.at("q_start_rad").get<JointVector>();
    // Names of robots may differ in what names of files cannot hold.
    const bool is_it = run.hash == hash && run.robot == robot;
    return is_it && run.ended >= Time() ? std::optional(run) : std::nullopt;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

CheckLine CheckRehearsal(const RunHistory& history, const RehearsalDemand& demand) {
  const auto refuse = [&demand](const std::string& why) {
    return CheckLine{"rehearsal", false,
                     fmt::format("{}; make one: {}   or say why none is needed: --no-rehearsal "
                                 "REASON",
                                 why, demand.command)};
  };
  if (history.folder().empty()) {
    return refuse("none is kept, since neither XDG_STATE_HOME nor HOME is set: set one");
  }
  const std::optional<PastRun> last = history.Find(demand.hash, {});
  if (!last) return refuse("the twin has not run this scenario as it is now");
  if (!last->failure.empty()) return refuse(fmt::format("the last one failed: {}", last->failure));
  const Duration age = history.Now() - last->ended;
  if (age < Duration::zero()) {
    return refuse(
        fmt::format("the last one ended at {}, which is to come: is this machine's "
                    "calendar right?",
                    FormatUtc(last->ended)));
  }
  if (age > demand.within) {
    return refuse(
        fmt::format("the last one ended {} ago, and {} are allowed "
                    "(--rehearsed-within)",
                    AgeText(age), AgeText(demand.within)));
  }
  if (last->max_speed < demand.max_speed) {
    return refuse(
        fmt::format("the last one was at {:.3g} of the scenario's speed, and this run is "
                    "at {:.3g} (--max-speed)",
                    last->max_speed, demand.max_speed));
  }
  return {"rehearsal", true,
          fmt::format("ended well in the twin {} ago (scenario {})", AgeText(age), last->hash)};
}

}  // namespace twin::run
