#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"

namespace planish {

/// What numbers of vertices are called, and how many each has.
struct AttributeName {
  std::string name;
  int width = 1;
};

struct NumberRun;

/// Numbers that each vertex has besides, as PLY's `quality`. On a surface they go smoothly from one
/// vertex to the next and never past the values around (linearly with other schemes than
/// Doo-Sabin); up to four that add up to a constant do so everywhere.
struct VertexAttribute {
  std::string name;  ///< letters, digits and '_', no digit first; no two differ by case alone
  std::vector<float> values;  ///< finite, `width` of each vertex, one vertex after another
  int width = 1;

  [[nodiscard]] std::size_t count() const {
    return width > 0 ? values.size() / static_cast<std::size_t>(width) : 0;
  }
  /// One value a vertex of a run.
  void set_run(std::size_t vertex, const NumberRun& run, const glm::vec4& four);
  /// Up to four numbers of a vertex, from the one of number `first` on; the rest is 0.
  [[nodiscard]] glm::vec4 four(std::size_t vertex, int first) const {
    glm::vec4 result(0.0f);
    for (int k = 0; k < std::min(width - first, 4); ++k)
      result[k] =
          values[static_cast<std::size_t>(width) * vertex + static_cast<std::size_t>(first + k)];
    return result;
  }
  void set_four(std::size_t vertex, int first, const glm::vec4& four) {
    for (int k = 0; k < std::min(width - first, 4); ++k)
      values[static_cast<std::size_t>(width) * vertex + static_cast<std::size_t>(first + k)] =
          four[k];
  }
};

/// Room for the same numbers of so many vertices.
[[nodiscard]] VertexAttribute attribute_of_size(const std::string& name, int width,
                                                std::size_t count);

/// Of each vertex, of all attributes.
[[nodiscard]] std::uint64_t numbers_of(std::span<const VertexAttribute> attributes);

/// Numbers of a vertex that stand together: of the attribute from `column` on, in a four from
/// `lane` on.
struct NumberRun {
  std::size_t four;
  int lane, column, count;
};

/// The numbers of all attributes, one after another, make fours; those of an attribute of up to
/// four stand in one. Where those of one attribute are.
[[nodiscard]] std::vector<NumberRun> runs_of(std::span<const VertexAttribute> attributes,
                                             std::size_t index);

/// That four of every vertex; 0 behind the last number.
[[nodiscard]] std::vector<glm::vec4> four_of(std::span<const VertexAttribute> attributes,
                                             std::size_t four);

/// Attributes of those vertices alone, in their order.
[[nodiscard]] std::vector<VertexAttribute> attributes_of(std::span<const VertexAttribute> given,
                                                         std::span<const std::int32_t> vertices);

/// Throws Error{InvalidArgument} for a name that files cannot hold or that is there twice, and for
/// the first value that is not finite.
void require_attributes(std::span<const VertexAttribute> attributes);

/// What an untagged open boundary is.
enum class BoundaryRule {
  Edge,           ///< creases throughout
  EdgeAndCorner,  ///< and boundary vertices with one face are corners
};

struct SharpFeatureOptions {
  BoundaryRule boundary = BoundaryRule::Edge;
  bool use_tags = true;  ///< false: only boundaries are sharp
};

/// Sharpness at and above which an edge or vertex is infinitely sharp, as in OpenSubdiv.
inline constexpr float kInfiniteSharpness = 10.0f;

/// A tagged edge between two adjacent vertices.
struct CreaseEdge {
  std::int32_t v0, v1;
  float sharpness = kInfiniteSharpness;
};

/// A tagged vertex.
struct CornerVertex {
  std::int32_t vertex;
  float sharpness = kInfiniteSharpness;
};

/// A part of the mesh that a file names.
struct FaceGroup {
  std::string name;      ///< of the group or object; may be empty
  std::string material;  ///< may be empty
};

/// Polygons of any size, counter-clockwise seen from outside.
struct PolygonMesh {
  std::vector<glm::dvec3> positions;
  /// face_count + 1; the corners of face f are [offsets[f], offsets[f+1]).
  std::vector<std::int32_t> face_offsets{0};
  std::vector<std::int32_t> face_vertices;  ///< vertex indices of all faces, one after another
  std::vector<CreaseEdge> creases;
  std::vector<CornerVertex> corners;

  // What rides on the mesh and is refined with it. Each may be empty: none.
  std::vector<glm::dvec2> uvs;         ///< texture coordinates, which face_uvs names
  std::vector<std::int32_t> face_uvs;  ///< one per corner, as face_vertices; -1: none there
  std::vector<glm::vec4> colors;       ///< linear RGBA, 0 to 1, one per vertex
  std::vector<VertexAttribute> attributes;
  std::vector<FaceGroup> groups;
  std::vector<std::int32_t> face_groups;  ///< one per face: its group
  std::vector<std::int32_t> hole_faces;   ///< faces that shape the surface but are no part of it

  [[nodiscard]] std::int32_t vertex_count() const {
    return static_cast<std::int32_t>(positions.size());
  }
  [[nodiscard]] std::int32_t face_count() const {
    return static_cast<std::int32_t>(face_offsets.size()) - 1;
  }
  [[nodiscard]] std::int32_t face_size(std::int32_t face) const {
    return face_offsets[face + 1] - face_offsets[face];
  }
  [[nodiscard]] std::span<const std::int32_t> face(std::int32_t index) const {
    return {face_vertices.data() + face_offsets[index], static_cast<std::size_t>(face_size(index))};
  }
  void add_face(std::span<const std::int32_t> vertices) {
    face_vertices.insert(face_vertices.end(), vertices.begin(), vertices.end());
    face_offsets.push_back(static_cast<std::int32_t>(face_vertices.size()));
  }
};

/// The similarity that centres a model and scales its bounding box to unit diagonal:
/// model = centre + diagonal * unit. All solving happens in unit coordinates.
struct Placement {
  glm::dvec3 centre{0.0};
  double diagonal = 1.0;

  [[nodiscard]] glm::dvec3 to_unit(const glm::dvec3& model) const {
    return (model - centre) / diagonal;
  }
  [[nodiscard]] glm::dvec3 to_model(const glm::dvec3& unit) const {
    return centre + diagonal * unit;
  }
};

/// The placement of the vertices that faces name; unused vertices do not count. A mesh whose used
/// vertices coincide gets diagonal 1.
[[nodiscard]] Placement placement_of(const PolygonMesh& mesh);

/// Whether two of the vertices that faces name differ; the bounding box of others has no diagonal.
[[nodiscard]] bool has_extent(const PolygonMesh& mesh);

/// The placement of all these positions.
[[nodiscard]] Placement placement_of(std::span<const glm::dvec3> positions);

/// Vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<std::int32_t, 3>;

/// Makes triangles whose corners are points of a cloud without duplicates. Each triangle names
/// three different points; their winding may differ from one to the next. Throws planish::Error.
using Mesher =
    std::function<std::vector<Triangle>(std::span<const glm::dvec3>, const Callbacks& callbacks)>;

/// Unorganised points. Point i lies at origin + points[i]; both the subtraction that made
/// points[i] and this sum are exact, so that the file's doubles come back bit by bit.
struct PointCloud {
  std::vector<glm::dvec3> points;
  /// Of any length, 0 or not finite for none; empty, or one per point.
  std::vector<glm::vec3> normals;
  std::vector<glm::vec4> colors;            ///< linear RGBA, 0 to 1; empty, or one per point
  std::vector<VertexAttribute> attributes;  ///< further numbers of each point, as intensity
  /// 0 on an axis where the cloud is not far from 0, see recentre().
  glm::dvec3 origin{0.0};
  /// Points of the file that are not finite, as depth cameras write where they saw nothing.
  std::int64_t missing_count = 0;
  std::vector<Warning> warnings;
};

/// Distance of a cloud's centre from 0, in diagonals, from which on it is moved to the origin.
inline constexpr double kFarDiagonals = 10.0;

/// Moves a cloud without origin near 0 on each axis where its centre is more than kFarDiagonals
/// bounding-box diagonals away.
void recentre(PointCloud& cloud);

/// The positions as a cloud near 0. Throws Error{UnreadableInput} for one that is not finite or
/// beyond kMaxCoordinate: `name: point 12 of 345: ...`.
[[nodiscard]] PointCloud cloud_of(std::vector<glm::dvec3> positions, std::string_view name);

/// Length of the bounding box's diagonal; 0 for no points.
[[nodiscard]] double diagonal_of(std::span<const glm::dvec3> points);

}  // namespace planish
