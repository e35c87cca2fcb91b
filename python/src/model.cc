#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <tuple>

#include <fmt/format.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include "bindings.h"
#include "twin/core/error.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"
#include "twin/planning/arm_solutions.h"
#include "twin/scenario/robot_data.h"

// The rigid-body model over rows: each function reads arrays of n rows and fills `out`, which the
// Python layer allocates. Matrices are column-major in C++ and row-major in Python.
namespace twin::python {
namespace {

template <Py_ssize_t kColumns>
using Rows = nb::ndarray<const double, nb::shape<-1, kColumns>, nb::c_contig, nb::device::cpu>;
template <Py_ssize_t kColumns>
using Filled = nb::ndarray<double, nb::shape<-1, kColumns>, nb::c_contig, nb::device::cpu>;

/// Frames by name: joint1 to joint7, flange, EE.
model::Frame FrameOf(const std::string& name) {
  constexpr std::array<const char*, 9> kNames{"joint1", "joint2", "joint3", "joint4", "joint5",
                                              "joint6", "joint7", "flange", "EE"};
  const auto* const found = std::ranges::find(kNames, name);
  if (found != kNames.end()) return static_cast<model::Frame>(found - kNames.begin());
  throw InputError(fmt::format("frame: \"{}\" is none of joint1 to joint7, flange and EE", name));
}

const model::ArmModel& ModelOf(bool of_plant) noexcept {
  return of_plant ? model::ArmModel::PandaPlant() : model::ArmModel::Panda();
}

template <Py_ssize_t kColumns>
auto RowOf(const Rows<kColumns>& rows, std::size_t i) noexcept {
  std::array<double, static_cast<std::size_t>(kColumns)> row;
  std::copy_n(rows.data() + i * kColumns, kColumns, row.begin());
  return row;
}

/// Writes a column-major matrix of `height` rows row-major.
template <std::size_t kSize>
void PutTransposed(const std::array<double, kSize>& matrix, std::size_t height,
                   double* out) noexcept {
  const std::size_t width = kSize / height;
  for (std::size_t r = 0; r < height; ++r) {
    for (std::size_t c = 0; c < width; ++c) out[r * width + c] = matrix[c * height + r];
  }
}

/// What hangs on the flange: mass, centre and inertia, column-major.
using Load = std::array<double, 13>;

model::Payload PayloadOf(const Load& load) noexcept {
  model::Payload payload;
  payload.m = load[0];
  std::copy_n(load.begin() + 1, 3, payload.F_x_C.begin());
  std::copy_n(load.begin() + 4, 9, payload.I.begin());
  return payload;
}

void Gravity(const Rows<7>& q, const Load& load, const Vector3& g_earth, bool of_plant,
             const Filled<7>& out) {
  const GilReleased release;
  const model::Payload payload = PayloadOf(load);
  for (std::size_t i = 0; i < q.shape(0); ++i) {
    std::ranges::copy(ModelOf(of_plant).Gravity(RowOf(q, i), payload, g_earth), out.data() + 7 * i);
  }
}

void Coriolis(const Rows<7>& q, const Rows<7>& dq, const Load& load, bool of_plant,
              const Filled<7>& out) {
  const GilReleased release;
  const model::Payload payload = PayloadOf(load);
  for (std::size_t i = 0; i < q.shape(0); ++i) {
    std::ranges::copy(ModelOf(of_plant).Coriolis(RowOf(q, i), RowOf(dq, i), payload),
                      out.data() + 7 * i);
  }
}

void Mass(const Rows<7>& q, const Load& load, bool of_plant, const Filled<49>& out) {
  const GilReleased release;
  const model::Payload payload = PayloadOf(load);
  for (std::size_t i = 0; i < q.shape(0); ++i) {
    PutTransposed(ModelOf(of_plant).MassMatrix(RowOf(q, i), payload), 7, out.data() + 49 * i);
  }
}

constexpr Py_ssize_t kRegressorSize = std::tuple_size_v<model::Regressor>;

void RegressorOf(const Rows<7>& q, const Rows<7>& dq, const Rows<7>& ddq, const Vector3& g_earth,
                 const Filled<kRegressorSize>& out) {
  const GilReleased release;
  for (std::size_t i = 0; i < q.shape(0); ++i) {
    std::ranges::copy(
        model::ArmModel::RegressorOf(RowOf(q, i), RowOf(dq, i), RowOf(ddq, i), g_earth),
        out.data() + kRegressorSize * i);
  }
}

/// Parameters of the seven links, as model::Regressor has them.
std::array<double, kJoints * model::kBodyParameters> ParametersOf(bool of_plant) {
  std::array<double, kJoints * model::kBodyParameters> all;
  double* next = all.data();
  for (const auto& [m, h, I] : ModelOf(of_plant).links()) {
    next =
        std::ranges::copy(std::array{m, h[0], h[1], h[2], I.xx, I.xy, I.xz, I.yy, I.yz, I.zz}, next)
            .out;
  }
  return all;
}

void JacobianOf(const Rows<7>& q, const std::string& name, const Transform& F_T_EE, bool in_body,
                const Filled<42>& out) {
  const model::Frame frame = FrameOf(name);
  const GilReleased release;
  const model::ArmModel& arm = model::ArmModel::Panda();
  for (std::size_t i = 0; i < q.shape(0); ++i) {
    const JointVector row = RowOf(q, i);
    PutTransposed(
        in_body ? arm.BodyJacobian(frame, row, F_T_EE) : arm.ZeroJacobian(frame, row, F_T_EE), 6,
        out.data() + 42 * i);
  }
}

void ForwardKinematics(const Rows<7>& q, const std::string& name, const Transform& F_T_EE,
                       const Filled<16>& out) {
  const model::Frame frame = FrameOf(name);
  const GilReleased release;
  for (std::size_t i = 0; i < q.shape(0); ++i) {
    PutTransposed(model::ArmModel::Panda().Pose(frame, RowOf(q, i), F_T_EE), 4,
                  out.data() + 16 * i);
  }
}

constexpr std::size_t kMostSolutions = 8;

/// @param O_T_EE  column-major. @param out  a row of eight solutions each, those there are first;
/// the others NaN.
void InverseKinematics(const Rows<16>& O_T_EE, const Rows<1>& q7, const Transform& F_T_EE,
                       const JointVector& q_min, const JointVector& q_max,
                       const Filled<7 * kMostSolutions>& out) {
  const GilReleased release;
  const Transform EE_T_F = model::Inverse(F_T_EE);
  std::fill_n(out.data(), out.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < O_T_EE.shape(0); ++i) {
    const planning::ArmSolutions solutions(model::Multiply(RowOf(O_T_EE, i), EE_T_F), q7.data()[i]);
    double* next = out.data() + out.shape(1) * i;
    for (const JointVector& q : solutions.all()) {
      bool is_within = true;
      for (std::size_t j = 0; j < kJoints; ++j) is_within &= q_min[j] <= q[j] && q[j] <= q_max[j];
      if (is_within) next = std::ranges::copy(q, next).out;
    }
  }
}

/// q_min, q_max, F_T_NE, and mass, centre and inertia of the Franka Hand, from the models.
auto PandaData() {
  const scenario::RobotData data =
      scenario::LoadRobotData(Files().models, "panda", plant::HandKind::kFrankaHand);
  return std::make_tuple(data.limits.q_min, data.limits.q_max, data.F_T_NE, data.end_effector.m,
                         data.end_effector.F_x_C, data.end_effector.I);
}

}  // namespace

void AddModel(nb::module_& module) {
  module.def("model_gravity", &Gravity);
  module.def("model_coriolis", &Coriolis);
  module.def("model_mass", &Mass);
  module.def("model_regressor", &RegressorOf);
  module.def("model_parameters", &ParametersOf);
  module.def("model_jacobian", &JacobianOf);
  module.def("model_fk", &ForwardKinematics);
  module.def("model_ik", &InverseKinematics);
  module.def("model_panda", &PandaData);
}

}  // namespace twin::python
