#pragma once

#include "twin/fci/capture.h"

namespace twin::cli {

/// Completes what --capture keeps; a note when it lacks something. @pre nobody puts any more.
/// @throws EnvironmentError as fci::Capture::Finish.
void FinishCapture(fci::Capture& capture);

}  // namespace twin::cli
