#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "twin/core/time.h"
#include "twin_cell.h"

namespace twin::python {

void AddCell(nb::module_& module) {
  const nb::call_guard<GilReleased> released;
  nb::exception<Cancelled>(module, "Cancelled", PyExc_BaseException);
  nb::class_<TwinCell>(module, "TwinCell", "See panda_twin.Cell.")
      .def(
          "__init__",
          [](TwinCell* self, std::optional<std::string> text, std::filesystem::path file,
             std::optional<std::uint64_t> seed, std::optional<std::filesystem::path> log) {
            new (self) TwinCell({std::move(text), std::move(file), seed, std::move(log)});
          },
          nb::arg("text").none(), nb::arg("file"), nb::arg("seed").none(), nb::arg("log").none(),
          released)
      .def_prop_ro("name", &TwinCell::name)
      .def_prop_ro("names", &TwinCell::Names)
      .def("robot", &TwinCell::robot, nb::arg("robot"), nb::rv_policy::reference_internal)
      .def(
          "now", [](TwinCell& self) { return ToSeconds(self.clock().Now()); }, released)
      .def(
          "gather",
          [](TwinCell& self, const std::vector<std::size_t>& robots) {
            self.clock().Gather(robots);
          },
          nb::arg("robots"), released)
      .def(
          "enter", [](TwinCell& self, std::size_t function) { self.clock().Enter(function); },
          nb::arg("function"), released)
      .def(
          "leave", [](TwinCell& self, std::size_t function) { self.clock().Leave(function); },
          nb::arg("function"), released)
      .def("cancel", [](TwinCell& self) { self.clock().Cancel(); })
      .def("stop", [](TwinCell& self) { self.clock().Stop(); })
      .def("await_end", &TwinCell::AwaitEnd)
      .def("close", &TwinCell::Close, released)
      .def_prop_ro("closed", &TwinCell::is_closed);
}

}  // namespace twin::python
