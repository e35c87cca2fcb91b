#include "page/message.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

namespace twin::page {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kLongestText = 256;
constexpr std::size_t kMostCameras = 64;

const Json* Find(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

std::optional<double> NumberAt(const Json& object, const char* key) {
  const Json* value = Find(object, key);
  if (value == nullptr || !value->is_number()) return {};
  const double number = value->get<double>();
  if (!std::isfinite(number)) return {};
  return number;
}

std::optional<bool> FlagAt(const Json& object, const char* key) {
  const Json* value = Find(object, key);
  if (value == nullptr || !value->is_boolean()) return {};
  return value->get<bool>();
}

std::optional<std::string> TextAt(const Json& object, const char* key) {
  const Json* value = Find(object, key);
  if (value == nullptr || !value->is_string()) return {};
  std::string text = value->get<std::string>();
  if (text.size() > kLongestText) return {};
  return text;
}

std::optional<message::Sight> SightAt(const Json& object) {
  const auto name = TextAt(object, "of");
  if (name == "pictures") return message::Sight::kPictures;
  if (name == "scene") return message::Sight::kScene;
  return {};
}

std::optional<Message> ReadHello(const Json& object) {
  std::optional<std::string> token = TextAt(object, "token");
  if (!token) return {};
  return message::Hello{std::move(*token), SightAt(object).value_or(message::Sight::kPictures)};
}

std::optional<Message> ReadSight(const Json& object) {
  const auto sight = SightAt(object);
  if (!sight) return {};
  return message::ChooseSight{*sight};
}

std::optional<Message> ReadHands(const Json& object) {
  const Json* axes = Find(object, "axes");
  const auto engaged = FlagAt(object, "engaged");
  const auto sent_ms = NumberAt(object, "sent_ms");
  message::Hands hands;
  if (axes == nullptr || !axes->is_array() || axes->size() != hands.axes.size()) return {};
  if (!engaged || !sent_ms) return {};
  for (std::size_t i = 0; i < hands.axes.size(); ++i) {
    const Json& axis = (*axes)[i];
    if (!axis.is_number() || !std::isfinite(axis.get<double>())) return {};
    hands.axes[i] = std::clamp(axis.get<double>(), -1.0, 1.0);
  }
  if (const Json* joint = Find(object, "joint")) {
    if (!joint->is_number_unsigned() || joint->get<std::uint64_t>() > kJoints) return {};
    hands.joint = joint->get<std::uint8_t>();
  }
  hands.engaged = *engaged;
  hands.sent_ms = *sent_ms;
  return hands;
}

std::optional<Message> ReadPress(const Json& object) {
  using message::Button;
  constexpr std::array<std::pair<std::string_view, Button>, 6> kButtons = {
      {{"mode", Button::kMode},
       {"gripper", Button::kGripper},
       {"frame", Button::kFrame},
       {"scale", Button::kScale},
       {"release", Button::kRelease},
       {"end", Button::kEnd}}};
  const auto name = TextAt(object, "button");
  if (!name) return {};
  const auto* const found =
      std::ranges::find(kButtons, *name, [](const auto& entry) { return entry.first; });
  if (found == kButtons.end()) return {};
  return message::Press{found->second};
}

std::optional<Message> ReadCamera(const Json& object) {
  const Json* number = Find(object, "number");
  if (number == nullptr || !number->is_number_unsigned()) return {};
  const auto camera = number->get<std::uint64_t>();
  if (camera >= kMostCameras) return {};
  return message::ChooseCamera{static_cast<std::size_t>(camera)};
}

std::optional<Message> ReadPing(const Json& object) {
  const auto sent_ms = NumberAt(object, "sent_ms");
  if (!sent_ms) return {};
  return message::Ping{*sent_ms};
}

template <typename Kind>
std::optional<Message> ReadSwitch(const Json& object) {
  const auto on = FlagAt(object, "on");
  if (!on) return {};
  return Kind{*on};
}

template <typename Kind>
std::optional<Message> ReadPlain(const Json& /*object*/) {
  return Kind{};
}

}  // namespace

std::optional<Message> ParseMessage(std::string_view text) {
  using Reader = std::optional<Message> (*)(const Json&);
  constexpr std::array<std::pair<std::string_view, Reader>, 14> kReaders = {
      {{"hands", &ReadHands},
       {"shown", &ReadPlain<message::PictureShown>},
       {"press", &ReadPress},
       {"stop", &ReadPlain<message::Stop>},
       {"ping", &ReadPing},
       {"hello", &ReadHello},
       {"take", &ReadPlain<message::TakeControl>},
       {"give_back", &ReadPlain<message::GiveControlBack>},
       {"camera", &ReadCamera},
       {"record", &ReadSwitch<message::Record>},
       {"pause", &ReadSwitch<message::Pause>},
       {"recover", &ReadPlain<message::Recover>},
       {"home", &ReadPlain<message::Home>},
       {"view", &ReadSight}}};
  const Json object = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) return {};
  const auto type = TextAt(object, "type");
  if (!type) return {};
  const auto* const found =
      std::ranges::find(kReaders, *type, [](const auto& entry) { return entry.first; });
  return found == kReaders.end() ? std::nullopt : found->second(object);
}

std::string Quoted(std::string_view text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace twin::page
