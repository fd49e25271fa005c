#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/mesh_file.h"

namespace planish {

/// What rounding leaves of a zero, as in sines of whole turns, where a shape of revolution closes:
/// a number below this much of those beside it.
inline constexpr double kRemainder = 0x1p-48;

/// A position as it is welded: with 0 for a remainder of a zero beside its largest coordinate.
[[nodiscard]] glm::dvec3 without_remainders(const glm::dvec3& position);

/// Gives equal positions one index, in the order in which they first come; -0.0 equals 0.0, and so
/// do remainders of a zero.
class Welder {
 public:
  Welder();

  /// The index of `position`, which must be finite. Throws Error{UnreadableInput} past 2^31 - 1.
  std::int32_t insert(const glm::dvec3& position);
  /// A further index at a position that was inserted, which insert() does not give.
  std::int32_t insert_apart(const glm::dvec3& position);
  [[nodiscard]] std::vector<glm::dvec3> take_positions() { return std::move(positions_); }
  /// How many inserted positions were there already.
  [[nodiscard]] std::int64_t merged_count() const { return merged_count_; }
  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(positions_.size()); }

 private:
  void grow();

  std::vector<glm::dvec3> positions_;
  std::vector<std::int32_t> slots_;  // open addressing; -1 is free
  std::int64_t merged_count_ = 0;
};

/// The same for all positions at once, on all threads.
struct WeldedPositions {
  std::vector<glm::dvec3> positions;  ///< in the order in which they first come
  RawVector<std::int32_t> indices;    ///< of each given one
};
/// The positions must be finite and fewer than 2^31. A file's are its bytes once more.
[[nodiscard]] WeldedPositions weld(std::span<const glm::dvec3> positions,
                                   const FileBytes& file = {});

/// Collects triangles by welded vertices for the formats that know nothing else, and polygons that
/// are told by triangles. Triangles that name a vertex twice have no area and are left out.
class TriangleCollector {
 public:
  /// False for a triangle that was left out.
  bool add(std::int32_t v0, std::int32_t v1, std::int32_t v2);
  /// Whether a triangle is none to be left out; such a one is counted.
  bool has_area(std::int32_t v0, std::int32_t v1, std::int32_t v2);
  /// A face of distinct vertices.
  void add_polygon(std::span<const std::int32_t> vertices) { mesh_.add_face(vertices); }
  /// Without positions.
  [[nodiscard]] const PolygonMesh& mesh() const { return mesh_; }
  [[nodiscard]] std::size_t corner_count() const { return mesh_.face_vertices.size(); }
  /// Hands over the mesh with its counts, and a warning if triangles were left out.
  void finish(std::vector<glm::dvec3> positions, std::int64_t merged_count, MeshFile& file);
  void finish(Welder& welder, MeshFile& file) {
    finish(welder.take_positions(), welder.merged_count(), file);
  }

 private:
  PolygonMesh mesh_;
  std::int64_t degenerate_count_ = 0;
};

/// Normals as a file gives them to the corners of its faces.
struct CornerNormals {
  std::vector<glm::vec3> values;         ///< of any length; 0 or not finite: none
  std::vector<std::int32_t> of_corners;  ///< one per corner of the mesh, into values; -1: none
};

/// Normals that differ by more, in degrees, are split on purpose: in 8 bits they round by half a
/// degree.
inline constexpr double kSplitDegrees = 1;

/// Makes infinitely sharp creases of the edges where the normals of two faces differ at one of the
/// edge's vertices. Edges that the mesh has tagged keep their sharpness.
void mark_split_normals(PolygonMesh& mesh, const CornerNormals& normals);

/// Makes vertices at one place one vertex, since files repeat vertices to split normals at them.
/// The first one's colour stays.
void weld_repeated_vertices(MeshFile& file);

}  // namespace planish
