#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "twin/core/joint_vector.h"

// What a browser may say over the WebSocket, a JSON object each; src/page/README.md has the table.
// It comes from the network: whatever is not exactly one of these is none.
namespace twin::page::message {

/// Must come first.
struct Hello {
  std::string token;
};

struct TakeControl {};
struct GiveControlBack {};

/// What the operator's hands do, some thirty times a second; also the heartbeat.
struct Hands {
  Vector6 axes{};       ///< in [-1, 1], as teleop::OperatorSample
  bool engaged = true;  ///< clutch
  double sent_ms = 0;   ///< on the browser's clock; given back, so that it knows the round trip
};

enum class Button : std::uint8_t { kMode, kGripper, kFrame, kScale, kRelease, kEnd };

struct Press {
  Button button = Button::kMode;
};

/// Emergency stop; anybody's to say.
struct Stop {};

struct ChooseCamera {
  std::size_t number = 0;
};

/// The last picture has been shown: the next may come.
struct PictureShown {};

struct Ping {
  double sent_ms = 0;
};

struct Record {
  bool on = false;
};

}  // namespace twin::page::message

namespace twin::page {

using Message = std::variant<message::Hello, message::TakeControl, message::GiveControlBack,
                             message::Hands, message::Press, message::Stop, message::ChooseCamera,
                             message::PictureShown, message::Ping, message::Record>;

/// @returns nothing when the text is no message. Axes beyond [-1, 1] are cut to it; a number that
/// is not finite makes it no message.
[[nodiscard]] std::optional<Message> ParseMessage(std::string_view text);

/// `text` in JSON's quotes; bytes that are no UTF-8 are replaced.
[[nodiscard]] std::string Quoted(std::string_view text);

}  // namespace twin::page
