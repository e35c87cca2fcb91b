#include "twin/server/control_request.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/core/error.h"
#include "twin/core/integer.h"

namespace twin::server {
namespace {

using Json = nlohmann::json;

/// What a verb takes, as its key and as the words of a command line.
enum class Takes : std::uint8_t { kNothing, kCycles, kPress, kSwitch, kPose, kPlace, kName };

struct Entry {
  std::string_view name;
  ControlVerb verb;
  Takes takes;
};

constexpr std::array<Entry, 11> kVerbs = {{{"status", ControlVerb::kStatus, Takes::kNothing},
                                           {"pause", ControlVerb::kPause, Takes::kNothing},
                                           {"step", ControlVerb::kStep, Takes::kCycles},
                                           {"resume", ControlVerb::kResume, Takes::kNothing},
                                           {"user-stop", ControlVerb::kUserStop, Takes::kPress},
                                           {"guiding", ControlVerb::kGuiding, Takes::kSwitch},
                                           {"recover", ControlVerb::kRecover, Takes::kNothing},
                                           {"reset", ControlVerb::kReset, Takes::kPose},
                                           {"place", ControlVerb::kPlace, Takes::kPlace},
                                           {"snapshot", ControlVerb::kSnapshot, Takes::kName},
                                           {"restore", ControlVerb::kRestore, Takes::kName}}};

/// The pose in which Franka delivers the arm and its programs begin, rad.
constexpr double kPi = std::numbers::pi;
constexpr JointVector kReady{0, -kPi / 4, 0, -3 * kPi / 4, 0, kPi / 2, kPi / 4};

/// Of untrusted bytes, for messages.
std::string Quoted(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string quoted(text.substr(0, kMost));
  std::ranges::replace_if(
      quoted, [](char c) { return c < ' ' || c > '~'; }, '?');
  return fmt::format("\"{}\"", quoted);
}

const Entry& EntryNamed(std::string_view name) {
  const auto* const found = std::ranges::find(kVerbs, name, &Entry::name);
  if (found != kVerbs.end()) return *found;
  std::string known;
  for (const Entry& entry : kVerbs) {
    known += fmt::format("{}{}", known.empty() ? "" : ", ", entry.name);
  }
  throw InputError(fmt::format("there is no request {}; choose one of {}", Quoted(name), known));
}

const Entry& EntryOf(ControlVerb verb) {
  return *std::ranges::find(kVerbs, verb, &Entry::verb);
}

bool HasKey(Takes takes, std::string_view key) {
  switch (takes) {
    case Takes::kNothing: return false;
    case Takes::kCycles: return key == "cycles";
    case Takes::kPress:
    case Takes::kSwitch: return key == "on";
    case Takes::kPose: return key == "q";
    case Takes::kPlace: return key == "name" || key == "position" || key == "rpy";
    case Takes::kName: return key == "name";
  }
  return false;
}

/// The keys without which there is no such request.
std::vector<std::string_view> NeededOf(Takes takes) {
  if (takes == Takes::kPress || takes == Takes::kSwitch) return {"on"};
  if (takes == Takes::kPlace) return {"name", "position"};
  return {};
}

std::uint64_t CheckedCycles(std::optional<std::uint64_t> cycles) {
  const std::uint64_t count = cycles.value_or(0);
  if (count >= 1 && count <= ControlRequest::kMostCycles) return count;
  throw InputError(fmt::format("step: the number of cycles must be an integer in [1, {}]",
                               ControlRequest::kMostCycles));
}

/// @param on, off  the words that set and clear it.
bool FlagOf(std::string_view name, const std::string& word, std::string_view on,
            std::string_view off) {
  if (word == on || word == off) return word == on;
  throw InputError(fmt::format("{}: {} is neither {} nor {}", name, Quoted(word), on, off));
}

/// @param what  the error for all but a list of N numbers, each at most `most` from zero.
template <std::size_t N>
std::array<double, N> NumbersOf(const Json& list, double most, const char* what) {
  std::array<double, N> numbers{};
  bool is_good = list.is_array() && list.size() == N;
  for (std::size_t i = 0; i < N && is_good; ++i) {
    is_good = list[i].is_number();
    if (is_good) numbers[i] = list[i].get<double>();
    is_good = is_good && std::abs(numbers[i]) <= most;
  }
  if (!is_good) throw InputError(what);
  return numbers;
}

JointVector PoseOf(const Json& list) {
  return NumbersOf<kJoints>(list, std::numeric_limits<double>::max(),
                            "reset: a pose has seven finite angles in rad, of joints 1 to 7");
}

Vector3 PositionOf(const Json& list) {
  return NumbersOf<3>(list, ControlRequest::kFarthest,
                      "place: a position has three numbers in m, each in [-100, 100]");
}

Vector3 RpyOf(const Json& list) {
  return NumbersOf<3>(list, std::numeric_limits<double>::max(),
                      "place: roll, pitch and yaw are three finite angles in rad");
}

std::string NameOf(std::string_view verb, const std::string& text) {
  const bool is_good = !text.empty() && text.size() <= ControlRequest::kLongestName &&
                       std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
  if (is_good) return text;
  throw InputError(fmt::format("{}: a name has 1 to {} printable ASCII characters, unlike {}", verb,
                               ControlRequest::kLongestName, Quoted(text)));
}

Json NumbersIn(std::span<const std::string> words) {
  Json list = Json::array();
  for (const std::string& word : words) list.push_back(Json::parse(word, nullptr, false));
  return list;
}

/// @param words  behind "reset".
JointVector PoseOf(std::span<const std::string> words) {
  if (words.size() == 1 && words.front() == "ready") return kReady;
  return PoseOf(NumbersIn(words));
}

/// @param words  behind "place".
void ReadPlace(std::span<const std::string> words, ControlRequest& request) {
  if (words.size() != 4 && words.size() != 7) {
    throw InputError("place: say NAME X Y Z in m, and ROLL PITCH YAW in rad unless it is level");
  }
  request.name = NameOf("place", words[0]);
  request.position = PositionOf(NumbersIn(words.subspan(1, 3)));
  if (words.size() == 7) request.rpy = RpyOf(NumbersIn(words.subspan(4)));
}

void Read(std::string_view key, const Json& value, const Entry& entry, ControlRequest& request) {
  if (key == "q") {
    request.q = PoseOf(value);
  } else if (key == "position") {
    request.position = PositionOf(value);
  } else if (key == "rpy") {
    request.rpy = RpyOf(value);
  } else if (key == "cycles") {
    request.cycles = CheckedCycles(
        value.is_number_unsigned() ? std::optional(value.get<std::uint64_t>()) : std::nullopt);
  } else if (key == "name") {
    request.name = NameOf(entry.name, value.is_string() ? value.get<std::string>() : "");
  } else if (value.is_boolean()) {
    request.on = value.get<bool>();
  } else {
    throw InputError(fmt::format("{}: \"on\" must be true or false", entry.name));
  }
}

}  // namespace

bool TakesTime(ControlVerb verb) noexcept {
  return verb == ControlVerb::kStep || verb == ControlVerb::kRecover;
}

ControlRequest ParseControlRequest(std::string_view line) {
  const Json object = Json::parse(line, nullptr, false);
  if (!object.is_object()) {
    throw InputError(fmt::format(
        "{} is not a request; send a JSON object such as {{\"do\": \"status\"}}", Quoted(line)));
  }
  const auto name = object.find("do");
  if (name == object.end() || !name->is_string()) {
    throw InputError("the request has no \"do\" with the name of what to do");
  }
  const Entry& entry = EntryNamed(name->get_ref<const std::string&>());
  ControlRequest request{.verb = entry.verb};
  if (entry.takes == Takes::kName) request.name = ControlRequest::kSnapshot;
  for (const auto& [key, value] : object.items()) {
    if (key == "do") continue;
    if (!HasKey(entry.takes, key)) {
      throw InputError(
          fmt::format("{}: there is no key {} of this request", entry.name, Quoted(key)));
    }
    Read(key, value, entry, request);
  }
  for (const std::string_view key : NeededOf(entry.takes)) {
    if (object.contains(key)) continue;
    throw InputError(fmt::format("{}: \"{}\" is missing{}", entry.name, key,
                                 key == "on" ? "; say true or false" : ""));
  }
  return request;
}

ControlRequest ControlRequestOf(std::span<const std::string> words) {
  if (words.empty()) throw InputError("name a request, such as status");
  const Entry& entry = EntryNamed(words.front());
  ControlRequest request{.verb = entry.verb};
  if (entry.takes == Takes::kPose) {
    if (words.size() > 1) request.q = PoseOf(words.subspan(1));
    return request;
  }
  if (entry.takes == Takes::kPlace) {
    ReadPlace(words.subspan(1), request);
    return request;
  }
  if (entry.takes == Takes::kName) request.name = ControlRequest::kSnapshot;
  const std::size_t most = entry.takes == Takes::kNothing ? 1 : 2;
  const bool is_optional = entry.takes == Takes::kCycles || entry.takes == Takes::kName;
  const std::size_t least = is_optional ? 1 : most;
  if (words.size() > most) {
    throw InputError(fmt::format("{}: {} is too much", entry.name, Quoted(words[most])));
  }
  if (words.size() < least) {
    throw InputError(fmt::format("{}: say {}", entry.name,
                                 entry.takes == Takes::kPress ? "press or release" : "on or off"));
  }
  if (words.size() == 1) return request;
  switch (entry.takes) {
    case Takes::kNothing:
    case Takes::kPlace:
    case Takes::kPose: break;
    case Takes::kName: request.name = NameOf(entry.name, words[1]); break;
    case Takes::kCycles:
      request.cycles = CheckedCycles(ParseInteger<std::uint64_t>(words[1]));
      break;
    case Takes::kPress: request.on = FlagOf(entry.name, words[1], "press", "release"); break;
    case Takes::kSwitch: request.on = FlagOf(entry.name, words[1], "on", "off"); break;
  }
  return request;
}

std::string ToLine(const ControlRequest& request) {
  const Entry& entry = EntryOf(request.verb);
  Json object{{"do", entry.name}};
  if (entry.takes == Takes::kCycles) object["cycles"] = request.cycles;
  if (HasKey(entry.takes, "on")) object["on"] = request.on;
  if (request.q) object["q"] = *request.q;
  if (HasKey(entry.takes, "name")) object["name"] = request.name;
  if (entry.takes == Takes::kPlace) {
    object["position"] = request.position;
    object["rpy"] = request.rpy;
  }
  return object.dump();
}

}  // namespace twin::server
