#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/texture_slide.h"

// What whoever gives a mesh should know of it, of its fit, its surface and its file, although all
// are made. Elements are counted as in the given mesh.
namespace planish {

/// "torn-vertices" of a mesh that is ready: see torn_vertices(). None where somebody has welded it,
/// or sheets of it were separated: whoever did knows of vertices at one place.
[[nodiscard]] std::optional<Warning> torn_warning(const FittedMesh& ready, std::string_view name);

/// "not-converged" of a fit that misses its tolerance, with what helps.
[[nodiscard]] std::optional<Warning> convergence_warning(const FittedMesh& fitted,
                                                         std::string_view name);

/// "not-converged" and "unused-vertices" of a fitted mesh; with `of_input`, where the faces are the
/// caller's own, "inside-out", too.
[[nodiscard]] std::vector<Warning> mesh_warnings(const FittedMesh& fitted, std::string_view name,
                                                 bool of_input);

/// "folded-area" of a surface of which more than 1e-4 is folded, with what helps. `against_source`:
/// it was measured against another surface, not against the mesh's faces.
[[nodiscard]] std::optional<Warning> fold_warning(const FittedMesh& fitted,
                                                  const SurfaceQuality& quality,
                                                  bool against_source = false);

/// "sliding-texture" of a surface whose texture lies farther from where the input has it than
/// anybody would have it, with what helps. Distances are fractions of the diagonal.
[[nodiscard]] std::optional<Warning> slide_warning(const FittedMesh& fitted,
                                                   const TextureSlide& slide);

/// "rounded-output" of a file whose numbers keep an error above the tolerance, of the diagonal,
/// that the fit keeps.
[[nodiscard]] std::optional<Warning> rounding_warning(std::string_view output, double error,
                                                      double tolerance);

/// "large-output" of a file of a level that nobody named which is large, and many times its input.
[[nodiscard]] std::optional<Warning> size_warning(std::string_view output, std::uint64_t bytes,
                                                  std::uint64_t input_bytes, int level);

}  // namespace planish
