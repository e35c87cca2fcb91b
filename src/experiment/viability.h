#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// What the viability filter and the generator before it do: the border of the set they keep to and
/// its price, how an offset is taken away, and whether a motion behind the asynchronous thread's
/// timing is smooth, not only legal.
[[nodiscard]] Findings RunViability(const Setting& setting);

}  // namespace twin::experiment
