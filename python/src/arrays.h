#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "bindings.h"
#include "twin/core/joint_vector.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

// Numbers between C++ and numpy. All functions: with the GIL.
namespace twin::python {

[[nodiscard]] inline bool IsObject(PyObject* object) noexcept {
  return object != nullptr;
}
/// An array, and what numpy makes one of; for signatures.
class Array : public nb::object {
 public:
  NB_OBJECT(Array, nb::object, "numpy.typing.NDArray[numpy.float64]", IsObject)
};
class ArrayLike : public nb::object {
 public:
  NB_OBJECT(ArrayLike, nb::object, "numpy.typing.ArrayLike", IsObject)
};

/// A fresh float64 array of numpy with these values, shape (N,). Three times as fast as
/// nb::ndarray: numpy itself copies an array of that shape.
template <std::size_t N>
[[nodiscard]] Array ArrayOf(const std::array<double, N>& values);
/// A pose, shape (4, 4): rows and columns as on paper.
template <>
[[nodiscard]] Array ArrayOf(const Transform& X);
/// Likewise, (3, 3).
template <>
[[nodiscard]] Array ArrayOf(const Matrix3& A);

extern template Array ArrayOf(const Elbow&);
extern template Array ArrayOf(const Vector3&);
extern template Array ArrayOf(const Vector6&);
extern template Array ArrayOf(const JointVector&);
extern template Array ArrayOf(const Accelerations&);

/// Reads numbers from an array, a list or whatever numpy makes an array of.
/// @param what  "Torques: tau_J, Nm", for messages. @param shape  for messages: "(7,)".
/// @throws nb::type_error when they are no numbers, nb::value_error for another shape, a NaN or an
/// infinity.
[[nodiscard]] JointVector JointsFrom(nb::handle from, std::string_view what);
[[nodiscard]] Vector6 Vector6From(nb::handle from, std::string_view what);
/// A rigid pose, shape (4, 4).
[[nodiscard]] Transform PoseFrom(nb::handle from, std::string_view what);
inline constexpr double kDay = 86400;  ///< longest duration, s
/// @throws InputError unless in [least, kDay], s.
[[nodiscard]] Duration SecondsFrom(double seconds, std::string_view what, double least = 0);

}  // namespace twin::python
