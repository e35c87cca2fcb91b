#include "twin/plant/body_view.h"

#include <cstddef>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "twin/core/error.h"

namespace twin::plant {

BodyView::BodyView(const TruthProbe& truth, const std::string& body)
    : truth_(truth), body_(mj_name2id(&truth.model(), mjOBJ_BODY, body.c_str())) {
  if (body_ < 0) {
    throw InputError(fmt::format("no body of robot and scene is named \"{}\"; name one", body));
  }
}

Transform BodyView::Pose() const noexcept {
  const mjData& data = truth_.data();
  Transform X = kIdentityTransform;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) X[4 * c + r] = data.xmat[9 * body_ + 3 * r + c];
    X[12 + r] = data.xpos[3 * body_ + r];
  }
  return X;
}

}  // namespace twin::plant
