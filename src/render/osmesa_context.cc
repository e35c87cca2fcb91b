#include "render/osmesa_context.h"

#include <GL/osmesa.h>

#include "twin/core/error.h"

namespace twin::render {

void OsMesaContext::Destroy::operator()(osmesa_context* context) const noexcept {
  OSMesaDestroyContext(context);
}

OsMesaContext::OsMesaContext()
    : context_(OSMesaCreateContextExt(OSMESA_RGBA, /*depthBits=*/24, /*stencilBits=*/8,
                                      /*accumBits=*/0, /*sharelist=*/nullptr)) {
  if (!context_) {
    throw EnvironmentError(
        "OSMesa gives no OpenGL context (RGBA, 24-bit depth). Install Debian's libosmesa6 and "
        "libgl1-mesa-dri of the same version, and leave GALLIUM_DRIVER unset or llvmpipe");
  }
}

void OsMesaContext::MakeCurrent() {
  if (OSMesaGetCurrentContext() == context_.get()) return;
  if (OSMesaMakeCurrent(context_.get(), dummy_.data(), GL_UNSIGNED_BYTE,
                        static_cast<GLsizei>(kDummySize),
                        static_cast<GLsizei>(kDummySize)) == GL_FALSE) {
    throw EnvironmentError(
        "OSMesa cannot make its context current. Another OpenGL library (libGL, libEGL) in the "
        "process does this: run without it, and without LD_PRELOAD");
  }
}

void OsMesaContext::ReleaseCurrent() noexcept {
  OSMesaMakeCurrent(nullptr, nullptr, 0, 0, 0);
}

}  // namespace twin::render
