#pragma once

#include <nanobind/nanobind.h>

#include "twin/record/columns.h"

namespace twin::python {

/// @returns a table as a capsule `arrow_array_stream` of one batch, for pyarrow, polars and others.
/// Values are not copied, except bool, of which Arrow has bits; vectors are fixed-size lists, texts
/// dictionaries. Source: https://arrow.apache.org/docs/format/CStreamInterface.html. The structs
/// are plain C; no Arrow library is needed.
[[nodiscard]] nanobind::capsule ArrowStreamOf(const record::Table& table);

}  // namespace twin::python
