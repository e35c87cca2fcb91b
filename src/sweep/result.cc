#include "twin/sweep/result.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numeric>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/application/seed_run.h"
#include "twin/core/content_hash.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/plant/mjcf_files.h"
#include "twin/run/run.h"
#include "twin/run/summary.h"
#include "twin/scenario/text_changes.h"

namespace twin::sweep {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Of a file that is not there empty: the run says what is wrong.
std::string BytesOf(const fs::path& file) {
  std::error_code none;
  if (!fs::is_regular_file(file, none)) return {};
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void AddFolder(const fs::path& folder, ContentHash& hash) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::recursive_directory_iterator(folder, none)) {
    if (entry.is_regular_file(none)) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    hash.Add(file.lexically_relative(folder).string());
    hash.Add(BytesOf(file));
  }
}

void AddScene(const fs::path& scene, ContentHash& hash) {
  const std::string text = BytesOf(scene);
  hash.Add(text);
  const plant::NamedFiles named = plant::FilesNamedIn(text);
  std::vector<fs::path> folders{scene.parent_path()};
  for (const std::string& folder : named.folders) folders.push_back(folders.front() / folder);
  for (const std::string& file : named.files) {
    for (const fs::path& folder : folders) hash.Add(BytesOf(folder / file));
  }
}

/// What no scenario changes.
std::string HashOfProgram(const run::RunFiles& files) {
  ContentHash hash;
  hash.Add(TWIN_VERSION);
  hash.Add(FormatHash(LibmFingerprint()));
  AddFolder(files.models / "robots", hash);
  return hash.Hex();
}

/// All that decides on a run but its seed.
void AddScenario(scenario::Scenario scenario, const run::RunFiles& files, ContentHash& hash) {
  scenario.seed = 0;
  hash.Add(scenario::ToYaml(scenario));
  if (scenario.places.profile) hash.Add(scenario.places.profile->hash);  // for its draws
  const fs::path floor = "scenes/floor.xml";
  AddScene(files.models / (scenario.scene.empty() ? floor : scenario.scene), hash);
  if (!scenario.controller.library.empty()) hash.Add(BytesOf(scenario.controller.library));
}

/// Whether a value is a number with or without a unit, which names no file. "1e3", "0.5 %", "-3
/// ms".
bool IsNumber(const std::string& value) {
  constexpr std::string_view kNumber = "+-0123456789.eE";
  const std::size_t end = std::min(value.find_first_not_of(kNumber), value.size());
  const bool has_unit = end < value.size() && value[end] == ' ';
  if (end == 0 || (end < value.size() && !has_unit)) return false;
  if (value.find('.', end) != std::string::npos) return false;
  try {
    static_cast<void>(ParseNumber(value.substr(0, end)));
  } catch (const InputError&) {
    return false;
  }
  return true;
}

std::vector<std::size_t> InOrderOfKeys(const std::vector<scenario::SweepAxis>& axes) {
  std::vector<std::size_t> order(axes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&axes](std::size_t i) { return axes[i].key; });
  return order;
}

std::optional<double> Finite(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

Result RunMotion(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                 const run::RunFiles& files, const volatile bool* interrupted) {
  run::Run run(scenario, catalogue, files, nullptr);
  run::RunHooks hooks;
  hooks.interrupted = interrupted;
  const run::RunResult done = run.Execute(hooks);
  Result result{.address = {},
                .outcome = run::OutcomeOf(done, false),
                .error = done.report.failure,
                .served = done.counts.served,
                .held = done.counts.held,
                .final_error_rad = Finite(done.final_error),
                .deviation_rad = {},
                .deviation_m = {},
                .duration_s = ToSeconds(done.report.simulated),
                .states_hash = FormatHash(done.states_hash),
                .version = TWIN_VERSION};
  const auto& [joints, pose] = done.followed.deviation;
  if (joints) result.deviation_rad = Finite(joints->largest);
  if (pose) result.deviation_m = Finite(pose->position);
  return result;
}

Result RunApplication(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                      const run::RunFiles& files, const volatile bool* interrupted) {
  const application::SeedOutcome done =
      application::RunSeed(scenario, scenario.seed, catalogue, files, interrupted);
  return {.address = {},
          .outcome = done.succeeded() ? "success" : "failed",
          .error = done.failure,
          .served = done.counts.served,
          .held = done.counts.held,
          .final_error_rad = {},
          .deviation_rad = {},
          .deviation_m = {},
          .duration_s = ToSeconds(done.duration),
          .states_hash = FormatHash(done.states_hash),
          .version = TWIN_VERSION};
}

Json NumberJson(const std::optional<double>& number) {
  return number ? Json(*number) : Json();
}

std::optional<double> NumberIn(const Json& json) {
  return json.is_null() ? std::nullopt : std::optional(json.get<double>());
}

}  // namespace

CaseMaker::CaseMaker(const Sweep& sweep, const run::RunFiles& files)
    : sweep_(sweep),
      files_(files),
      robots_(HashOfProgram(files)),
      axes_(InOrderOfKeys(sweep.file().axes)) {}

const std::string& CaseMaker::HashOfRest(const Case& one) {
  constexpr std::size_t kMost = 10'000;
  std::vector<std::string> values = one.values;
  std::string key;
  for (std::string& value : values) {
    if (IsNumber(value)) value.clear();
    key += value + '\n';
  }
  if (const auto known = rest_.find(key); known != rest_.end()) return known->second;
  if (rest_.size() >= kMost) rest_.clear();
  ContentHash hash;
  hash.Add(robots_);
  try {
    const std::string text =
        scenario::WithChanges(sweep_.TextWith(values), sweep_.scenario_file(), "{seed: null}");
    hash.Add(text);
    AddScenario(scenario::Parse(text, sweep_.scenario_file()), files_, hash);
  } catch (const InputError&) {  // it needs the numbers, or is refused with them, too
    ContentHash whole;
    whole.Add(robots_);
    AddScenario(sweep_.ScenarioOf(one), files_, whole);
    return whole_ = whole.Hex();
  }
  return rest_[key] = hash.Hex();
}

std::string CaseMaker::AddressOf(const Case& one) {
  ContentHash hash;
  hash.Add(HashOfRest(one));
  for (const std::size_t axis : axes_) {
    if (!IsNumber(one.values[axis])) continue;
    hash.Add(sweep_.file().axes[axis].key);
    hash.Add(one.values[axis]);
  }
  hash.Add(fmt::format("{}", one.seed));
  return hash.Hex();
}

const PreparedCase& CaseMaker::Make(Case one, std::string address) {
  if (!last_ || last_->one.point != one.point || sweep_.draws()) {
    last_ = PreparedCase{.one = {}, .scenario = sweep_.ScenarioOf(one), .address = {}};
  }
  last_->scenario.seed = one.seed;
  last_->address = std::move(address);
  last_->one = std::move(one);
  return *last_;
}

const PreparedCase& CaseMaker::Make(std::uint64_t run) {
  const Case one = sweep_.CaseAt(run);
  return Make(one, AddressOf(one));
}

fs::path FileOf(const fs::path& out, const std::string& address) {
  return out / "runs" / address.substr(0, 2) / (address + ".json");
}

fs::path LogFolderOf(const fs::path& out, const std::string& address) {
  return out / "logs" / address.substr(0, 2) / address;
}

std::string ToJson(const Result& result, const Case& one,
                   const std::vector<scenario::SweepAxis>& axes) {
  Json values = Json::object();
  for (std::size_t i = 0; i < axes.size(); ++i) values[axes[i].key] = one.values[i];
  return run::TextOf({{"address", result.address},
                      {"point", one.point + 1},
                      {"seed", one.seed},
                      {"values", values},
                      {"outcome", result.outcome},
                      {"error", result.error},
                      {"cycles_served", result.served},
                      {"cycles_held", result.held},
                      {"final_error_rad", NumberJson(result.final_error_rad)},
                      {"deviation_rad", NumberJson(result.deviation_rad)},
                      {"deviation_m", NumberJson(result.deviation_m)},
                      {"duration_s", result.duration_s},
                      {"states_hash", result.states_hash},
                      {"version", result.version}});
}

std::optional<Result> ReadResult(const fs::path& file, const std::string& address) {
  const std::string text = BytesOf(file);
  if (text.empty()) return std::nullopt;
  try {
    const Json json = Json::parse(text);
    if (json.at("address") != address) return std::nullopt;
    return Result{.address = address,
                  .outcome = json.at("outcome"),
                  .error = json.at("error"),
                  .served = json.at("cycles_served"),
                  .held = json.at("cycles_held"),
                  .final_error_rad = NumberIn(json.at("final_error_rad")),
                  .deviation_rad = NumberIn(json.at("deviation_rad")),
                  .deviation_m = NumberIn(json.at("deviation_m")),
                  .duration_s = json.at("duration_s"),
                  .states_hash = json.at("states_hash"),
                  .version = json.at("version")};
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::optional<Result> RunCase(const PreparedCase& prepared, const run::Catalogue& catalogue,
                              const run::RunFiles& files, const volatile bool* interrupted) {
  const scenario::Scenario& scenario = prepared.scenario;
  Result result;
  try {
    const auto run = scenario.application ? &RunApplication : &RunMotion;
    result = run(scenario, catalogue, files, interrupted);
  } catch (const InputError&) {
    throw;
  } catch (const EnvironmentError&) {
    throw;
  } catch (const Error& error) {  // of the robot, or a planner that found no path
    result.outcome = "failed";
    result.error = error.what();
    result.states_hash = FormatHash(0);
    result.version = TWIN_VERSION;
  }
  if (interrupted != nullptr && *interrupted) return std::nullopt;
  result.address = prepared.address;
  return result;
}

}  // namespace twin::sweep
