// An OpenGL context through EGL's surfaceless platform, which Mesa has without a display.
#include "bench/gl_stencils.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <opensubdiv/osd/glComputeEvaluator.h>
#include <opensubdiv/osd/glVertexBuffer.h>

#include <stdexcept>

// Not declared by any installed header; must follow eglMakeCurrent.
namespace OpenSubdiv::internal::GLLoader {
bool libraryInitializeGL();
}

namespace planish::bench {

namespace {

using namespace OpenSubdiv;

const Osd::BufferDescriptor kTight(0, 3, 3);
constexpr unsigned kArrayBuffer = 0x8892;  // GL_ARRAY_BUFFER

template <class Function>
Function gl_function(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

/// Current on the calling thread while it lives.
class GlContext {
 public:
  GlContext() {
    const auto get_display =
        gl_function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    if (!get_display) return;
    display_ = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (!display_ || !eglInitialize(display_, nullptr, nullptr)) return;
    eglBindAPI(EGL_OPENGL_API);
    const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                             4,
                             EGL_CONTEXT_MINOR_VERSION,
                             3,
                             EGL_CONTEXT_OPENGL_PROFILE_MASK,
                             EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                             EGL_NONE};
    context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
    usable_ = context_ && eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) &&
              OpenSubdiv::internal::GLLoader::libraryInitializeGL();
  }
  ~GlContext() {
    if (context_) eglDestroyContext(display_, context_);
    if (display_) eglTerminate(display_);
  }
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  [[nodiscard]] bool usable() const { return usable_; }

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  bool usable_ = false;
};

class EglStencils final : public GlStencils {
 public:
  EglStencils(std::unique_ptr<GlContext> context, const Far::StencilTable& table,
              const std::vector<float>& source)
      : context_(std::move(context)),
        source_(Osd::GLVertexBuffer::Create(3, static_cast<int>(source.size() / 3))),
        target_(Osd::GLVertexBuffer::Create(3, table.GetNumStencils())),
        table_(Osd::GLStencilTableSSBO::Create(&table)),
        kernels_(Osd::GLComputeEvaluator::Create(kTight, kTight, {}, {})) {
    if (!kernels_) throw std::runtime_error("Osd::GLComputeEvaluator does not compile");
    source_->UpdateData(source.data(), 0, source_->GetNumVertices());
  }

  void run() override {
    kernels_->EvalStencils(source_.get(), kTight, target_.get(), kTight, table_.get());
    Osd::GLComputeEvaluator::Synchronize(nullptr);
  }
  [[nodiscard]] std::vector<float> result() override {
    std::vector<float> floats(3 * std::size_t(target_->GetNumVertices()));
    gl_function<void (*)(unsigned, unsigned)>("glBindBuffer")(kArrayBuffer, target_->BindVBO());
    gl_function<void (*)(unsigned, std::ptrdiff_t, std::ptrdiff_t, void*)>("glGetBufferSubData")(
        kArrayBuffer, 0, static_cast<std::ptrdiff_t>(floats.size() * sizeof(float)), floats.data());
    return floats;
  }
  [[nodiscard]] std::string renderer() const override {
    constexpr unsigned kRenderer = 0x1F01;  // GL_RENDERER
    const auto text = gl_function<const unsigned char* (*)(unsigned)>("glGetString")(kRenderer);
    return reinterpret_cast<const char*>(text);
  }

 private:
  std::unique_ptr<GlContext> context_;
  std::unique_ptr<Osd::GLVertexBuffer> source_, target_;
  std::unique_ptr<Osd::GLStencilTableSSBO> table_;
  std::unique_ptr<Osd::GLComputeEvaluator> kernels_;
};

}  // namespace

std::unique_ptr<GlStencils> make_gl_stencils(const Far::StencilTable& table,
                                             const std::vector<float>& source) {
  auto context = std::make_unique<GlContext>();
  if (!context->usable()) return nullptr;
  return std::make_unique<EglStencils>(std::move(context), table, source);
}

}  // namespace planish::bench
