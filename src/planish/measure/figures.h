#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "planish/measure/vertex_fields.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/queries/limit_surface.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/folded_places.h"
#include "planish/surface/quality_sum.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// What the figures of a surface are made of; those of its parts add up, always in the same order
/// for the same bits.
struct QualitySums {
  double area = 0, folded = 0, folded_elsewhere = 0;
  double squares = 0;  ///< of angles, in radians, times areas
  double largest = 0;  ///< angle
  double bending = 0;
  FoldedPlaces places;

  void add(const QualitySums& later);
  [[nodiscard]] SurfaceQuality quality() const;
};

/// Of a part of a surface: its area, what of it is folded and the input is not to blame for, and
/// its bending.
struct PartSums {
  double area = 0, folded_elsewhere = 0, bending = 0;
};

/// Of a whole surface, and of each of its parts.
struct PartQuality {
  SurfaceQuality whole;
  std::vector<PartSums> parts;
};

/// Which part a face of the input belongs to, 0 to `count` less one; none: it is one part.
struct PartOfFaces {
  std::span<const std::int32_t> of_face;
  std::int32_t count = 1;
};

/// Those of some ranges of faces, which follow one another, as surface_quality() has them.
[[nodiscard]] QualitySums quality_sums(const SurfaceBlocks& surface,
                                       std::span<const RowRange> ranges, const PolygonMesh& input,
                                       std::span<const std::uint8_t> is_beside_folds);

/// surface_quality() of a surface that passes by once, for whatever else it is made: add() is a
/// QuadVisit. All of it must outlive the figures.
class BlockQuality {
 public:
  BlockQuality(const SurfaceBlocks& surface, const PolygonMesh& input,
               std::span<const std::uint8_t> is_beside_folds, const PartOfFaces& parts = {});
  BlockQuality(const BlockQuality&) = delete;
  BlockQuality& operator=(const BlockQuality&) = delete;

  /// One of swept_pieces(), on any thread.
  void add(RowRange piece, std::span<const glm::dvec3> positions,
           std::span<const glm::vec3> normals);
  /// Of all pieces that were added, whatever their order.
  [[nodiscard]] SurfaceQuality result() const;
  /// The same of each part.
  [[nodiscard]] std::vector<PartSums> parts() const;

 private:
  // Consecutive quads of one part.
  struct Run {
    std::int32_t part;
    PartSums sums;
  };
  friend class QuadMeter;

  const SurfaceBlocks& surface_;
  const PolygonMesh& input_;
  std::span<const std::uint8_t> is_beside_folds_;
  ApexNormals apexes_;
  std::int64_t piece_size_ = 1;
  PartOfFaces parts_;
  std::vector<QualitySums> of_pieces_;
  std::vector<std::vector<Run>> runs_of_pieces_;
};

/// surface_quality() against the faces of the mesh that was fitted, of a surface of level 1 or more
/// that is made piece by piece on all threads; the same bits whatever their number. Angles are
/// within 1e-6 of a degree; see quality_sum.h of apexes. `is_beside_folds`: one per face of the
/// input, as FoldedEdges has it, or nothing. Throws Error{Cancelled}.
[[nodiscard]] SurfaceQuality surface_quality(const SurfaceBlocks& surface, const PolygonMesh& input,
                                             std::span<const std::uint8_t> is_beside_folds,
                                             const Callbacks& callbacks);
/// The same, and of each part.
[[nodiscard]] PartQuality quality_of_parts(const SurfaceBlocks& surface, const PolygonMesh& input,
                                           std::span<const std::uint8_t> is_beside_folds,
                                           const PartOfFaces& parts, const Callbacks& callbacks);

/// How far sheets that repair() separated along edges of three or more faces are from each other
/// there: of every such edge the boundary curves over it, one of each sheet, the largest distance
/// from the first to a place on any other or back, in model coordinates. Sampled at 17 places a
/// curve, against the lines between the other's. `source_vertices`: for each vertex of the mesh the
/// one that it is or copies; `edges`: pairs of these, the lower one first, ascending, as
/// RepairedMesh has them. 0 where no sheets meet.
[[nodiscard]] double sheet_gap(const LimitSurface& surface,
                               std::span<const std::int32_t> source_vertices,
                               std::span<const std::pair<std::int32_t, std::int32_t>> edges);

/// The curvatures of a Doo-Sabin surface at the vertices of a tessellation of it, from its second
/// derivatives. The surface is biquadratic piece by piece, and they jump from piece to piece: at a
/// vertex where several meet stands the mean of theirs. Those of `elsewhere` stay at vertices in no
/// piece, those of valence or face size other than 4 of the mesh, where second derivatives have no
/// limit. Units and signs as Curvatures has them; the same bits for every thread count.
[[nodiscard]] Curvatures curvatures_of_derivatives(const DooSabinSurface& surface,
                                                   const SurfaceMesh& tessellation,
                                                   Curvatures elsewhere);

}  // namespace planish
