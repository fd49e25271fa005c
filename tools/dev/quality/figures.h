#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "make_scenes/implicit.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/reconstruct/spatial_search.h"

namespace planish::quality {

/// A point of the true shape, with its outward unit normal.
struct Foot {
  glm::dvec3 point, normal;
};

/// The shape that a mesh's vertices were taken from: the foot of a point near it. May be called
/// from several threads.
using Truth = std::function<Foot(const glm::dvec3&)>;

/// About the origin.
[[nodiscard]] Truth true_sphere(double radius);
/// Around the z axis.
[[nodiscard]] Truth true_torus(double radius, double tube_radius);
/// The zero set of a field; the foot along its gradient.
[[nodiscard]] Truth true_zero_set(shapes::Field field);
/// A dense mesh; between its vertices' normals, by angle, the others are interpolated.
[[nodiscard]] Truth true_mesh(const PolygonMesh& mesh);

/// A dense shape, cut where it is sharp, and of each face of a coarse mesh of it the piece that the
/// face was taken from. Beside a sharp edge the nearest place of a shape is often behind the edge:
/// a wall that stands a hair inside its rim would be held against the lid.
class TruePieces {
 public:
  TruePieces(const PolygonMesh& shape, const PolygonMesh& coarse);

  /// Whether a sharp edge of the shape lies between two coarse faces.
  [[nodiscard]] bool are_apart(std::int32_t coarse_face, std::int32_t other) const {
    return of_face_[coarse_face] != of_face_[other];
  }
  /// The normal, of any length, at the nearest place of the piece of a coarse face.
  [[nodiscard]] glm::dvec3 normal(std::int32_t coarse_face, const glm::dvec3& place) const;
  /// To the nearest place of the piece of a coarse face.
  [[nodiscard]] double squared_distance(std::int32_t coarse_face, const glm::dvec3& place) const;

 private:
  struct Piece {
    std::vector<Triangle> triangles;
    TriangleTree tree;
    glm::dvec3 low, high;
  };
  [[nodiscard]] std::int32_t piece_of(std::span<const glm::dvec3> places,
                                      const glm::dvec3& area) const;
  [[nodiscard]] glm::dvec3 normal_at(const Piece& piece, const glm::dvec3& place) const;

  std::vector<glm::dvec3> positions_;
  std::vector<Piece> pieces_;
  std::vector<std::int32_t> of_face_;  // of the coarse mesh
};

/// A mesh with what its surface should be.
struct Case {
  std::string name;
  PolygonMesh mesh;
  /// Empty: normals are compared with those of the mesh's own faces (facets have no smooth truth,
  /// and the nearest face beside a crease may be the one behind it), distances with `source`.
  Truth truth;
  PolygonMesh source;              ///< without faces: the mesh itself
  bool has_smooth_source = false;  ///< fine enough for normals as well
  bool is_scan = false;
  bool is_held_out = false;  ///< of no part in choosing the method's constants
};

/// A way to a surface.
struct Method {
  std::string name;
  bool interpolates;
  FitOptions options;
};
/// None, progressive with either weights, fair without and with polish; in this order.
[[nodiscard]] const std::vector<Method>& methods();

/// Of one surface. Lengths are fractions of the mesh's diagonal, angles in degrees.
struct Figures {
  double folded_area = 0;  ///< a fraction
  double rms_normal = 0, max_normal = 0;
  double bending = 0;  ///< over the truth's; without a smooth truth over a sphere's, 8 pi
  double max_distance = 0, rms_distance = 0;
  double interpolation_error = 0;
};

/// Fits and measures at the limit points of a fine tessellation: level 3, or 2 for large meshes.
[[nodiscard]] Figures measure(const Case& what, const Method& method);
/// The same of a finished fit, at level 2; each face against the piece of the source between sharp
/// edges that it was taken from.
[[nodiscard]] Figures measure(const Case& what, const FittedMesh& fitted, Backend& backend);

/// A line of that.
[[nodiscard]] std::string shortfall(const Case& what, const char* figure, double value,
                                    double limit);

/// Where the polished fair surface falls short of what it is meant to reach, one line each: on
/// closed meshes at most 0.001 % folded; on any mesh normals no worse than those of the progressive
/// method with Doo and Sabin's weights, on simplified scans at most half as far off; interpolation
/// within 1e-6 of the diagonal. `figures` are those of methods().
[[nodiscard]] std::vector<std::string> shortfalls(const Case& what,
                                                  const std::vector<Figures>& figures);

}  // namespace planish::quality
