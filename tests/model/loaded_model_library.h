#pragma once

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "twin/model/arm_model.h"

namespace twin::model {

/// A model library as a client has it: loaded from a file, every function sought by its name. The
/// calls are those of ArmModel, so that both can stand in one comparison. Each checks that the
/// function has written all of its result and nothing behind it.
class LoadedModelLibrary {
 public:
  /// @throws std::runtime_error when the file does not load.
  explicit LoadedModelLibrary(const std::filesystem::path& file, int mode = RTLD_NOW | RTLD_LOCAL)
      : handle_(dlopen(file.c_str(), mode)) {
    if (handle_ == nullptr) throw std::runtime_error(dlerror());
  }
  LoadedModelLibrary(const LoadedModelLibrary&) = delete;
  LoadedModelLibrary& operator=(const LoadedModelLibrary&) = delete;
  ~LoadedModelLibrary() { dlclose(handle_); }

  [[nodiscard]] Transform Pose(Frame frame, const JointVector& q,
                               const Transform& F_T_EE = kIdentityTransform) const {
    if (frame == Frame::kEndEffector) return Call<Transform>("O_T_J9", q.data(), F_T_EE.data());
    return Call<Transform>(Name("O_T_J", frame), q.data());
  }

  [[nodiscard]] Jacobian ZeroJacobian(Frame frame, const JointVector& q,
                                      const Transform& F_T_EE = kIdentityTransform) const {
    return AnyJacobian("O_J_J", frame, q, F_T_EE);
  }

  [[nodiscard]] Jacobian BodyJacobian(Frame frame, const JointVector& q,
                                      const Transform& F_T_EE = kIdentityTransform) const {
    return AnyJacobian("Ji_J_J", frame, q, F_T_EE);
  }

  [[nodiscard]] JointMatrix MassMatrix(const JointVector& q, const Payload& payload) const {
    return Call<JointMatrix>("M_NE", q.data(), payload.I.data(), payload.m, payload.F_x_C.data());
  }

  [[nodiscard]] JointVector Coriolis(const JointVector& q, const JointVector& dq,
                                     const Payload& payload) const {
    return Call<JointVector>("c_NE", q.data(), dq.data(), payload.I.data(), payload.m,
                             payload.F_x_C.data());
  }

  [[nodiscard]] JointVector Gravity(const JointVector& q, const Payload& payload,
                                    const Vector3& g_earth = {0, 0, -9.81}) const {
    return Call<JointVector>("g_NE", q.data(), g_earth.data(), payload.m, payload.F_x_C.data());
  }

 private:
  static std::string Name(const std::string& stem, Frame frame) {
    return stem + std::to_string(static_cast<int>(frame) + 1);
  }

  [[nodiscard]] Jacobian AnyJacobian(const std::string& stem, Frame frame, const JointVector& q,
                                     const Transform& F_T_EE) const {
    const std::string name = Name(stem, frame);
    if (frame == Frame::kJoint1) return Call<Jacobian>(name);
    if (frame == Frame::kEndEffector) return Call<Jacobian>(name, q.data(), F_T_EE.data());
    return Call<Jacobian>(name, q.data());
  }

  template <typename Result, typename... Arguments>
  Result Call(const std::string& name, Arguments... arguments) const {
    using Function = void (*)(Arguments..., double*);
    const auto function = reinterpret_cast<Function>(dlsym(handle_, name.c_str()));
    if (function == nullptr) throw std::runtime_error("no " + name);
    constexpr double kUntouched = 12345.678;  // nothing the arm would answer
    struct {
      Result result;
      double behind = kUntouched;
    } written;
    written.result.fill(kUntouched);
    function(arguments..., written.result.data());
    EXPECT_EQ(written.behind, kUntouched) << name << " writes behind its result";
    EXPECT_THAT(written.result, testing::Each(testing::Ne(kUntouched)))
        << name << " leaves a part of its result unwritten";
    return written.result;
  }

  void* handle_;
};

}  // namespace twin::model
