#pragma once

#include <cstdint>

#include "planish/adaptive/adaptive_tessellation.h"
#include "planish/core/callbacks.h"
#include "planish/queries/limit_surface.h"

namespace planish {

/// How far decimate() goes: one of these; none: there is no target.
struct DecimationTarget {
  std::int64_t triangles = 0;  ///< at most so many
  /// At most as many triangles as there would be of equal sides of this length, in the model's
  /// unit.
  double edge_length = 0;
  /// As few as are within this distance of the surface, and it of them, a fraction of `diagonal`.
  double distance = 0;

  [[nodiscard]] bool any() const { return triangles > 0 || edge_length > 0 || distance > 0; }
  friend bool operator==(const DecimationTarget& a, const DecimationTarget& b) {
    return a.triangles == b.triangles && a.edge_length == b.edge_length && a.distance == b.distance;
  }
};

struct DecimateOptions {
  DecimationTarget target;
  double diagonal = 1;                   ///< in the model's unit
  std::uint64_t memory_limit_bytes = 0;  ///< 0: what the machine has free
  Callbacks callbacks;  ///< steps "evaluate" and "decimate", warning kTrianglesNotReached
};

/// The code of the warning that more triangles are left than were wanted.
inline constexpr const char* kTrianglesNotReached = "triangles-not-reached";

/// How far decimated triangles are from the surface, both ways, as fractions of the diagonal:
/// measured from vertices of level 3, or of the finest below it that has not too many, and back
/// from the middles of triangles and edges.
struct DecimationFigures {
  double max = 0, rms = 0;
  std::int64_t places = 0;      ///< that it was measured from
  std::int64_t finer = 0;       ///< triangles of that tessellation
  std::int64_t wanted = 0;      ///< triangles; 0: as few as there may be
  double mean_edge_length = 0;  ///< in the model's unit
};

struct DecimatedSurface {
  AdaptiveSurface surface;
  DecimationFigures figures;
};

/// Few triangles through samples of a limit surface: fewer than the mesh has faces, or more. Every
/// vertex is one of a fine tessellation's, with its normal, texture coordinates and attributes, so
/// that it lies on the surface; of the given vertices those that are left come first. Borders,
/// sharp edges, seams of texture coordinates and edges of groups are lines of vertices still, the
/// same from both sides, so that what was closed is closed. Attributes do not say which vertices
/// go. The same bits for every thread count.
/// Throws Error{InvalidArgument} for targets that are none, or that tessellate() refuses;
/// Error{OutOfMemory} before memory is taken; Error{Cancelled}.
[[nodiscard]] DecimatedSurface decimate(const LimitSurface& surface,
                                        const DecimateOptions& options);

}  // namespace planish
