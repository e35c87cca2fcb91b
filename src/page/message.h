#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "twin/core/joint_vector.h"

// Messages from a browser over the WebSocket, one JSON object each; src/page/README.md has the
// table. The source is untrusted: anything else is rejected.
namespace twin::page::message {

/// What a client shows: pictures of the camera, or the scene, which it draws itself.
enum class Sight : std::uint8_t { kPictures, kScene };

/// Must be the first message.
struct Hello {
  std::string token;
  Sight sight = Sight::kPictures;
};

struct ChooseSight {
  Sight sight = Sight::kPictures;
};

struct TakeControl {};
struct GiveControlBack {};

/// The operator's input, about thirty times per second; also the heartbeat.
struct Hands {
  Vector6 axes{};          ///< in [-1, 1], as teleop::OperatorSample
  std::uint8_t joint = 0;  ///< as teleop::OperatorSample
  bool engaged = true;     ///< clutch
  double sent_ms = 0;  ///< on the browser's clock; echoed, so that it can measure the round trip
};

enum class Button : std::uint8_t { kMode, kGripper, kFrame, kScale, kRelease, kEnd };

struct Press {
  Button button = Button::kMode;
};

/// Emergency stop; any client may send it.
struct Stop {};

/// Clear the robot's errors, and lead it on.
struct Recover {};

/// Let the run's clock stand, or go on.
struct Pause {
  bool on = false;
};

/// Move the arm to its start.
struct Home {};

struct ChooseCamera {
  std::size_t number = 0;
};

/// The last picture has been displayed: the next may be sent.
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
                             message::PictureShown, message::Ping, message::Record,
                             message::Recover, message::Home, message::ChooseSight, message::Pause>;

/// @returns nullopt if the text is not a message, or a number is not finite. Axes are clamped to
/// [-1, 1].
[[nodiscard]] std::optional<Message> ParseMessage(std::string_view text);

/// `text` as a JSON string; invalid UTF-8 is replaced.
[[nodiscard]] std::string Quoted(std::string_view text);

}  // namespace twin::page
