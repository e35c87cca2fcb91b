#pragma once

#include <string>

#include "twin/core/joint_vector.h"

namespace twin::plant {

/// The engine rotates bodies about every axis, so it cannot simulate zero inertia about one.
/// @param body  for the message. @throws InputError for such an inertia.
void RequireThickness(const std::string& body, const Matrix3& inertia);

}  // namespace twin::plant
