#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include "bindings.h"
#include "twin/render/frame_painter.h"
#include "twin/replay/recording.h"
#include "twin/run/film.h"

namespace twin::python {
namespace {

using Picture = nb::ndarray<nb::numpy, nb::ro, const std::uint8_t, nb::ndim<3>>;

/// Draws pictures of a log, in the film settings of its scenario.
///
/// Threads: any; one picture at a time.
class LogPictures {
 public:
  /// @param camera  as run::ViewFromText(). @param size  width and height, pixels.
  LogPictures(const std::filesystem::path& log, const std::optional<std::string>& camera,
              const std::optional<std::tuple<int, int>>& size)
      : recording_(log, Files()), settings_(run::FilmOf(recording_.scenario().render)) {
    if (camera) settings_.view = run::ViewFromText(*camera, settings_.view);
    if (size) std::tie(settings_.render.width, settings_.render.height) = *size;
    painter_.emplace(recording_.Film(), settings_);
  }

  [[nodiscard]] std::int64_t first_ns() const { return At(0); }
  [[nodiscard]] std::int64_t last_ns() const { return At(recording_.snapshots().size() - 1); }

  /// @returns the first recorded scene at or after the instant, or the last.
  Picture Draw(std::int64_t ns) {
    auto image = std::make_unique<render::Image>([&] {
      const GilReleased release;
      const std::scoped_lock lock(mutex_);
      return painter_->Paint(FrameAt(ns));
    }());
    const std::size_t shape[] = {static_cast<std::size_t>(image->height),
                                 static_cast<std::size_t>(image->width), 3};
    const std::uint8_t* const rgb = image->rgb.data();
    const nb::capsule owner(image.release(), [](void* pointer) noexcept {
      delete static_cast<render::Image*>(pointer);
    });
    return {rgb, 3, shape, owner};
  }

 private:
  [[nodiscard]] std::int64_t At(std::size_t frame) const {
    return recording_.snapshots().time(frame).time_since_epoch().count();
  }

  [[nodiscard]] std::size_t FrameAt(std::int64_t ns) const {
    std::size_t low = 0;
    std::size_t high = recording_.snapshots().size() - 1;
    while (low < high) {
      const std::size_t middle = low + (high - low) / 2;
      if (At(middle) < ns) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  }

  replay::Recording recording_;
  render::FilmSettings settings_;
  std::mutex mutex_;
  std::optional<render::FramePainter> painter_;  ///< always there
};

}  // namespace

void AddLogPictures(nb::module_& module) {
  nb::class_<LogPictures>(module, "LogPictures")
      .def(nb::init<const std::filesystem::path&, const std::optional<std::string>&,
                    const std::optional<std::tuple<int, int>>&>(),
           nb::arg("log"), nb::arg("camera").none(), nb::arg("size").none(),
           nb::call_guard<GilReleased>())
      .def_prop_ro("first_ns", &LogPictures::first_ns)
      .def_prop_ro("last_ns", &LogPictures::last_ns)
      .def("draw", &LogPictures::Draw, nb::arg("ns"));
}

}  // namespace twin::python
