#pragma once

#include <opensubdiv/far/stencilTable.h>

#include <memory>
#include <string>
#include <vector>

namespace planish::bench {

/// Osd::GLComputeEvaluator with a table and a source of 3 floats a vertex, in an OpenGL context
/// without a window.
class GlStencils {
 public:
  virtual ~GlStencils() = default;
  /// Applies the table; the evaluator waits for its end. On the thread that made it.
  virtual void run() = 0;
  [[nodiscard]] virtual std::vector<float> result() = 0;
  [[nodiscard]] virtual std::string renderer() const = 0;
};

/// Null where this program was built without EGL, or no context with compute shaders can be had.
[[nodiscard]] std::unique_ptr<GlStencils> make_gl_stencils(
    const OpenSubdiv::Far::StencilTable& table, const std::vector<float>& source);

}  // namespace planish::bench
