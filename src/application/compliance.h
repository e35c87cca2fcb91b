#pragma once

#include <memory>

#include "twin/application/application.h"
#include "twin/control/parameters.h"

namespace twin::application {

/// The paper's second application: the arm as a spring, by the controller `compliance` on the
/// torque interface; pushed at a standstill and on a trajectory, stiff and compliant.
///
/// Cases, each a motion, with a motion back to robot.q_start between two of them: A standstill,
/// stiff, pushed; B the same, compliant; C0 trajectory, stiff, untouched; C the same, pushed; D0
/// trajectory, compliant, untouched; D the same, pushed; N standstill, stiff, with a null space
/// that pulls the elbow elsewhere. C0 and C, D0 and D differ by the push alone, so that what it
/// does can be told from what else moves the arm.
///
/// The pushes are the scenario's perturbations, with `motion: N`: a robot on this side of a wire or
/// on the other is pushed in the same way, and the application knows of it only what a log says and
/// what the force was meant to be.
///
/// Parameters: compliance::Settings. Demanded: compliance::FindingsOf. It judges by the log's
/// states alone, so on any drive.
[[nodiscard]] std::unique_ptr<Application> MakeCompliance(control::ParameterReader& parameters);

}  // namespace twin::application
