#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "twin/backend/hand.h"
#include "twin/fci/hand_client.h"

namespace twin::plugins {

/// A remote hand behind the hand seam. Connects on first use, so that an arm runs without its hand
/// being reachable.
class FciHand final : public backend::Hand {
 public:
  /// @param capture, device  as fci::HandClient's.
  FciHand(std::string host, std::uint16_t port, fci::Capture* capture,
          HandDevice device = HandDevice::kFrankaHand)
      : host_(std::move(host)), port_(port), capture_(capture), device_(device) {}

  HandTicket Start(const HandCommand& command) override;
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket) const override;
  [[nodiscard]] HandState ReadState() const override;

 private:
  [[nodiscard]] fci::HandClient& Client() const;

  const std::string host_;
  const std::uint16_t port_;
  fci::Capture* const capture_;
  const HandDevice device_;
  mutable std::mutex mutex_;
  mutable std::optional<fci::HandClient> client_;  ///< guarded by mutex_ until it is set
};

}  // namespace twin::plugins
