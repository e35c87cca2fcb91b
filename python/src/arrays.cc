#include "arrays.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nanobind/stl/string.h>

#include "twin/core/error.h"
#include "twin/core/setting.h"

namespace twin::python {
namespace {

/// A view of an object's doubles.
class Doubles {
 public:
  explicit Doubles(nb::handle of)
      : is_there_(PyObject_GetBuffer(of.ptr(), &view_, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) == 0) {
    if (!is_there_) PyErr_Clear();
  }
  ~Doubles() {
    if (is_there_) PyBuffer_Release(&view_);
  }
  Doubles(const Doubles&) = delete;
  Doubles& operator=(const Doubles&) = delete;

  /// Whether it has `size` doubles in `dimensions` of equal length.
  [[nodiscard]] bool Fits(std::size_t size, int dimensions) const noexcept {
    if (!is_there_ || view_.format == nullptr || std::string_view(view_.format) != "d" ||
        view_.ndim != dimensions || view_.len != static_cast<Py_ssize_t>(size * sizeof(double))) {
      return false;
    }
    return dimensions == 1 || view_.shape[0] == view_.shape[1];
  }
  [[nodiscard]] const double* data() const noexcept {
    return static_cast<const double*>(view_.buf);
  }

 private:
  Py_buffer view_{};
  bool is_there_;
};

/// Makes arrays of one shape.
class Maker {
 public:
  explicit Maker(const nb::tuple& shape, const char* order) {
    array_ = nb::module_::import_("numpy").attr("zeros")(shape, nb::arg("order") = order);
    const nb::object flat = array_.attr("ravel")("K");
    address_ = nb::cast<std::uintptr_t>(flat.attr("ctypes").attr("data"));
    copy_ = array_.attr("copy");
  }
  [[nodiscard]] Array operator()(const double* values, std::size_t size) const {
    std::copy_n(values, size, reinterpret_cast<double*>(address_));
    return nb::steal<Array>(PyObject_CallNoArgs(copy_.ptr()));
  }

 private:
  nb::object array_;
  nb::object copy_;
  std::uintptr_t address_ = 0;
};

/// Made once, and never destroyed: the interpreter may be gone by then.
template <std::size_t N, std::size_t... Shape>
const Maker& MakerOf(const char* order) {
  static const Maker& maker = *new Maker(nb::make_tuple(Shape...), order);
  return maker;
}

std::string TextOf(nb::handle object) {
  return nb::cast<std::string>(object.attr("__str__")());
}

template <std::size_t N>
void Read(nb::handle from, int dimensions, std::string_view shape, std::string_view what,
          std::array<double, N>& out) {
  const auto take = [&out](const Doubles& doubles) { std::copy_n(doubles.data(), N, out.data()); };
  if (const Doubles doubles(from); doubles.Fits(N, dimensions)) {
    take(doubles);
  } else {
    nb::object array;
    try {
      array = nb::module_::import_("numpy").attr("ascontiguousarray")(from, "float64");
    } catch (nb::python_error& error) {
      const std::string why = TextOf(error.value());
      throw nb::type_error(
          fmt::format("{}: expected {} numbers of shape {}: {}", what, N, shape, why).c_str());
    }
    const Doubles converted(array);
    if (!converted.Fits(N, dimensions)) {
      const std::string its = TextOf(array.attr("shape"));
      throw nb::value_error(fmt::format("{}: has shape {}; give {}", what, its, shape).c_str());
    }
    take(converted);
  }
  if (!std::ranges::all_of(out, [](double x) { return std::isfinite(x); })) {
    throw nb::value_error(
        fmt::format("{}: [{:g}]; every number must be finite", what, fmt::join(out, ", ")).c_str());
  }
}

}  // namespace

template <std::size_t N>
Array ArrayOf(const std::array<double, N>& values) {
  return MakerOf<N, N>("C")(values.data(), N);
}
template Array ArrayOf(const Elbow&);
template Array ArrayOf(const Vector3&);
template Array ArrayOf(const Vector6&);
template Array ArrayOf(const JointVector&);
template Array ArrayOf(const Accelerations&);

template <>
Array ArrayOf(const Transform& X) {
  return MakerOf<16, 4, 4>("F")(X.data(), X.size());
}
template <>
Array ArrayOf(const Matrix3& A) {
  return MakerOf<9, 3, 3>("F")(A.data(), A.size());
}

JointVector JointsFrom(nb::handle from, std::string_view what) {
  JointVector joints{};
  Read(from, 1, "(7,)", what, joints);
  return joints;
}

Vector6 Vector6From(nb::handle from, std::string_view what) {
  Vector6 values{};
  Read(from, 1, "(6,)", what, values);
  return values;
}

Transform PoseFrom(nb::handle from, std::string_view what) {
  Transform rows{};
  Read(from, 2, "(4, 4)", what, rows);
  Transform X{};
  for (std::size_t r = 0; r < 4; ++r) {
    for (std::size_t c = 0; c < 4; ++c) X[4 * c + r] = rows[4 * r + c];
  }
  if (!IsRigid(X)) {
    throw nb::value_error(
        fmt::format("{}: not a rigid pose: its rotation must be orthonormal and right-handed, and "
                    "its last row 0 0 0 1",
                    what)
            .c_str());
  }
  return X;
}

Duration SecondsFrom(double seconds, std::string_view what, double least) {
  RequireInRange(what, seconds, least, kDay);
  return FromSeconds(seconds);
}

}  // namespace twin::python
