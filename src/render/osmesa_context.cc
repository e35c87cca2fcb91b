#include "render/osmesa_context.h"

#include <dlfcn.h>
#include <unistd.h>

#include <atomic>

#include <GL/osmesa.h>

#include "twin/core/error.h"

namespace twin::render {
namespace {

/// The process that made the first context. Mesa's threads do not live on in a fork of it, where
/// the first picture would wait for them for ever. One word, which needs no ordering.
std::atomic<pid_t> first_process{0};

/// Held while a context is made, current or destroyed.
std::mutex& MesaMutex() {
  static std::mutex mutex;
  return mutex;
}

void RequireNoFork() {
  pid_t first = 0;
  if (first_process.compare_exchange_strong(first, ::getpid()) || first == ::getpid()) return;
  throw EnvironmentError(
      "this process was forked from one that has drawn pictures, and Mesa's threads do not live on "
      "in a fork: start processes anew (in Python by multiprocessing's \"spawn\" or "
      "\"forkserver\"), or draw no pictures before the fork");
}

std::unique_lock<std::mutex> LockMesa() {
  RequireNoFork();  // a fork may have inherited the mutex locked
  return std::unique_lock(MesaMutex());
}

/// Lets MuJoCo find OSMesa, which it seeks by name in the global scope, else as libOSMesa.so.
/// A module of Python loads its libraries into a scope of its own, and a wheel renames them.
void MakeOsMesaGlobal() {
  void* const global = ::dlopen(nullptr, RTLD_NOW);  // RTLD_DEFAULT has the caller's scope, too
  if (::dlsym(global, "OSMesaGetProcAddress") != nullptr) return;
  Dl_info library;
  if (::dladdr(reinterpret_cast<void*>(&OSMesaCreateContextExt), &library) == 0) return;
  ::dlopen(library.dli_fname, RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD);  // stays loaded: we link it
}

}  // namespace

void OsMesaContext::Destroy::operator()(osmesa_context* context) const noexcept {
  if (!LivesHere()) return;
  const std::lock_guard lock(MesaMutex());
  OSMesaDestroyContext(context);
}

OsMesaContext::OsMesaContext() {
  const auto lock = LockMesa();
  context_.reset(OSMesaCreateContextExt(OSMESA_RGBA, /*depthBits=*/24, /*stencilBits=*/8,
                                        /*accumBits=*/0, /*sharelist=*/nullptr));
  if (!context_) {
    throw EnvironmentError(
        "OSMesa gives no OpenGL context (RGBA, 24-bit depth). Install Debian's libosmesa6 and "
        "libgl1-mesa-dri of the same version, and leave GALLIUM_DRIVER unset or llvmpipe");
  }
  MakeOsMesaGlobal();
}

bool OsMesaContext::LivesHere() noexcept {
  const pid_t first = first_process;
  return first == 0 || first == ::getpid();
}

OsMesaContext::Current::Current(OsMesaContext& gl) : lock_(LockMesa()) {
  if (OSMesaMakeCurrent(gl.context_.get(), gl.dummy_.data(), GL_UNSIGNED_BYTE,
                        static_cast<GLsizei>(kDummySize),
                        static_cast<GLsizei>(kDummySize)) == GL_FALSE) {
    throw EnvironmentError(
        "OSMesa cannot make its context current. Another OpenGL library (libGL, libEGL) in the "
        "process does this: run without it, and without LD_PRELOAD");
  }
}

OsMesaContext::Current::~Current() {
  glFinish();
  OSMesaMakeCurrent(nullptr, nullptr, 0, 0, 0);
}

}  // namespace twin::render
