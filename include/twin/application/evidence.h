#pragma once

#include <filesystem>

#include "twin/plant/contact_watch.h"
#include "twin/plant/truth_probe.h"
#include "twin/render/snapshots.h"
#include "twin/run/session.h"

namespace twin::application {

/// What a finished run left to judge it by, ground truth included: for Application::Evaluate, and
/// never for what it does.
struct Evidence {
  std::filesystem::path log;                 ///< empty: none was written
  const plant::TruthProbe* truth = nullptr;  ///< at rest; null: nobody here simulates it
  const plant::ContactWatch* contacts = nullptr;
  const render::Snapshots* snapshots = nullptr;  ///< null: it was not filmed
  run::SessionResult session{};
};

}  // namespace twin::application
