#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Curvatures of a surface at each vertex of a tessellation, in one over the model's unit and its
/// square. Mean curvature is positive where the surface bends away from its normal: 1/R on a sphere
/// of radius R with outward normals.
struct Curvatures {
  std::vector<float> mean, gaussian;
};

/// The curvatures that the exact normals show across the tessellation's edges and diagonals: the
/// shape operator that fits their differences best in the least squares. Second order in the size
/// of the faces where they lie evenly. 0 where the faces around a vertex leave it open.
[[nodiscard]] Curvatures curvatures_of_normals(const SurfaceMesh& surface);

class DooSabinSurface;

/// Where curvatures come from.
enum class CurvatureSource {
  Normals,  ///< differences of the exact normals, see curvatures_of_normals()
  /// Second derivatives, see curvatures_of_derivatives(); normals where there are none.
  Derivatives,
};

/// "normals" or "second derivatives": a stable name for files.
[[nodiscard]] const char* name_of(CurvatureSource source);

/// Figures of each vertex of a tessellation, to look at or to hand on; one entry a position.
struct VertexFields {
  /// Distance from the given vertex, as a fraction of the diagonal. It is known at given vertices;
  /// between them stands what colours would: the mean over the edge or face that a vertex halves.
  std::vector<float> error;
  /// Largest angle between the normal and those of the mesh's faces that the vertex lies on, in
  /// degrees. Its largest value is SurfaceQuality::max_normal_deviation.
  std::vector<float> normal_deviation;
  /// Share of the area around the vertex that is turned by more than 90 degrees from the mesh's
  /// face, 0 to 1. By area it sums to SurfaceQuality::folded_area.
  std::vector<float> folded;
  Curvatures curvatures;
  CurvatureSource curvature_source = CurvatureSource::Normals;
};

/// The fields of a surface against the mesh that was fitted, the model's `diagonal` being the
/// unit of the error. Any level; the same bits for every thread count. Curvatures come from
/// `exact`, the surface that was tessellated, where it is given.
[[nodiscard]] VertexFields vertex_fields(const SurfaceMesh& surface, const PolygonMesh& mesh,
                                         double diagonal, const DooSabinSurface* exact = nullptr);

/// A field as files take it: a name of letters, digits and '_', and `width` values for each
/// position, one position after another.
struct NamedField {
  std::string name;
  std::span<const float> values;
  int width = 1;

  [[nodiscard]] NamedField part(RowRange rows) const {
    return {name,
            values.subspan(static_cast<std::size_t>(width * rows.first),
                           static_cast<std::size_t>(width * rows.count)),
            width};
  }
};

/// Which fields are wanted.
struct FieldChoice {
  bool error = false, deviation = false, fold = false, curvature = false;

  [[nodiscard]] bool any() const { return error || deviation || fold || curvature; }
};

/// "error", "deviation", "fold", "mean_curvature" and "gaussian_curvature" of those that are
/// chosen, in this order; `fields` must outlive them.
[[nodiscard]] std::vector<NamedField> named_fields(const VertexFields& fields,
                                                   const FieldChoice& choice);

/// A face of a tessellation that is turned over, wholly or in part.
struct FoldedFace {
  std::int64_t face = 0;      ///< of the surface
  std::int32_t ancestor = 0;  ///< the mesh's face
  double area = 0;            ///< of its folded part, in the model's unit
};

/// The faces with folded corners, as SurfaceQuality counts them: the largest area first, then by
/// number.
[[nodiscard]] std::vector<FoldedFace> folded_faces(const SurfaceMesh& surface,
                                                   const PolygonMesh& mesh);

/// How far the texture of a surface lies from where the mesh has it: at each place of the surface,
/// from the nearest place of the face that it descends from, whose texture coordinates are linear
/// on the triangles from its first corner. Weighted by area.
struct TextureSlide {
  double largest = 0, rms = 0;  ///< in parts of the texture, whose side is 1
  /// The same along the faces, in the model's unit; where a triangle has no area in the texture
  /// there is none.
  double largest_distance = 0, rms_distance = 0;
  std::int32_t face = -1;  ///< of the mesh, where the distance is largest; -1: nowhere
};

/// Of the corners of the surface's faces, on all threads; the same bits whatever their number. The
/// mesh is the fitted one, with texture coordinates. Throws Error{Cancelled}.
[[nodiscard]] TextureSlide texture_slide(const SurfaceBlocks& surface, const PolygonMesh& mesh,
                                         const Callbacks& callbacks = {});

}  // namespace planish
