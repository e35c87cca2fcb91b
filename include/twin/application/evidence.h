#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/plant/contact_watch.h"
#include "twin/report/plot.h"
#include "twin/run/session.h"

namespace twin::application {

/// Records of a finished run, ground truth included: for Application::Evaluate, never for Perform.
struct Evidence {
  std::filesystem::path log;                      ///< empty: none
  const plant::ContactWatch* contacts = nullptr;  ///< null: this process simulates nothing
  run::SessionResult session{};

  /// The motion of a body; nullopt when it is not simulated or not watched.
  [[nodiscard]] std::optional<plant::ObjectTrack> TrackOf(std::string_view body) const;
};

/// A quantity measured over a run.
struct Finding {
  std::string quantity;
  double value = 0;
  std::string unit{};
  std::string demand{};       ///< in words: "at most 5 mm"; empty: none
  std::optional<bool> met{};  ///< nullopt: nothing is demanded
};

/// An application's judgement of the evidence.
struct Evaluation {
  std::vector<Finding> findings{};
  std::vector<report::Figure> figures{};  ///< drawn by templates/application/ID.gp

  /// Adds a quantity without a demand.
  void Report(std::string quantity, double value, std::string unit = {});
  void Demand(std::string quantity, double value, std::string unit, std::string demand, bool met);
  /// Demands value <= most; a `most` of 0 reads "none".
  void DemandAtMost(std::string quantity, double value, std::string unit, double most);
  /// Demands an empty list; its elements are appended to the quantity.
  void DemandNone(std::string quantity, const std::vector<std::string>& list);
};

}  // namespace twin::application
