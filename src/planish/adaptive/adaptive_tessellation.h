#pragma once

#include <cstdint>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"
#include "planish/queries/limit_surface.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// A place on a corner's patch as CornerParameter has it, u and v in whole parts of kCellSide.
struct AdaptivePlace {
  std::int32_t corner = 0;
  std::uint16_t u = 0, v = 0;
};

/// How fine a tessellation is; at least one of both is wanted.
struct AdaptiveOptions {
  /// Largest distance between triangles and surface, both ways, as a fraction of `diagonal`; 0:
  /// any.
  double chord_error = 0;
  /// Most degrees that the surface's normal may turn beneath a triangle; 0: any. Where the surface
  /// folds it turns however small triangles are: there splitting ends at 2^-7 of half an edge, in
  /// needles at 2^-10, and a warning kAngleNotKept says how many triangles turn by more, by how
  /// much and where.
  double angle = 0;
  double diagonal = 1;                   ///< in the model's unit
  std::uint64_t memory_limit_bytes = 0;  ///< 0: what the machine has free
  Callbacks callbacks;                   ///< step "evaluate", warning kAngleNotKept
};

/// The code of the warning that an angle was not kept.
inline constexpr const char* kAngleNotKept = "angle-not-kept";

/// A tessellation, the mesh's face that each of its triangles lies on, and where its rows and
/// texture coordinates do.
struct AdaptiveSurface {
  SurfaceMesh mesh;  ///< of triangles; its level is 1 and means nothing
  RawVector<std::int32_t> ancestors;
  RawVector<AdaptivePlace> places, uv_places;
  /// The mesh's texture coordinate that each of the first ones is; tessellate() has all of them.
  std::vector<std::int32_t> base_uvs;
};

/// Triangles as fine as the surface asks for, place by place, by bounds from the patches' second
/// differences. Watertight: neighbours name the same vertices, but for copies at sharp edges and
/// seams of texture coordinates. The given vertices come first, as in levels, and attributes are
/// carried like theirs. The same bits for every thread count.
/// Throws Error{InvalidArgument} for errors and angles that are none, or that patches keep in no
/// 2^-13 of half an edge; Error{OutOfMemory} before memory is taken; Error{Cancelled}.
[[nodiscard]] AdaptiveSurface tessellate(const LimitSurface& surface,
                                         const AdaptiveOptions& options);

}  // namespace planish
