#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/ordered_pipeline.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/patch_surface.h"

namespace planish {

/// A tessellation whose every vertex lies on the limit surface, in model coordinates. At level 0
/// its faces are the input's polygons, from level 1 on all quads, or triangles with Loop. Rows and
/// faces of Doo-Sabin surfaces are numbered as PatchNumbering says; vertices that only holes name
/// are left out.
struct SurfaceMesh {
  int level = 0;
  RawVector<glm::dvec3> positions;
  RawVector<glm::vec3> normals;            ///< unit, finite, one per position
  std::vector<std::int32_t> face_offsets;  ///< face_count + 1; empty where all faces are quads
  RawVector<std::int32_t> face_vertices;   ///< all corners
  /// The first positions are the limit points of the input's vertices, in its order: entry i is
  /// the input's index of position i (unused vertices are left out). Vertices of several normals
  /// (creases) have their further copies at the end.
  std::vector<std::int32_t> base_vertices;

  // The mesh's attributes, refined with it; empty where it has none.
  RawVector<glm::dvec2> uvs;         ///< texture coordinates, which face_uvs names
  RawVector<std::int32_t> face_uvs;  ///< one per corner, as face_vertices
  RawVector<glm::vec4> colors;       ///< linear RGBA, one per position
  std::vector<VertexAttribute> attributes;
  std::vector<FaceGroup> groups;
  RawVector<std::int32_t> face_groups;  ///< one per face: its group

  [[nodiscard]] std::int64_t face_count() const {
    return face_offsets.empty() ? static_cast<std::int64_t>(face_vertices.size()) / 4
                                : static_cast<std::int64_t>(face_offsets.size()) - 1;
  }
  /// Of a level from 1 on: Loop's.
  [[nodiscard]] bool is_triangles() const { return level > 0 && !face_offsets.empty(); }
  [[nodiscard]] std::span<const std::int32_t> face(std::int64_t index) const {
    const std::int64_t first = face_offsets.empty() ? 4 * index : face_offsets[index];
    const std::int64_t size = face_offsets.empty() ? 4 : face_offsets[index + 1] - first;
    return {face_vertices.data() + first, static_cast<std::size_t>(size)};
  }
};

/// What is known of a surface before any of it is made.
struct SurfaceInfo {
  int level = 0;
  std::int64_t row_count = 0;  ///< vertices, those of several normals as often
  std::int64_t face_count = 0;
  std::int64_t corner_count = 0;  ///< of all faces
  std::int64_t uv_count = 0;      ///< 0: no texture coordinates
  bool has_colors = false;
  bool has_groups = false;  ///< each face has one of `groups`
  std::vector<AttributeName> attributes;
  std::vector<FaceGroup> groups;
  std::vector<std::int32_t> base_vertices;  ///< as SurfaceMesh has them
  /// face_count + 1, where each face's corners begin; empty where all faces are alike.
  std::vector<std::int32_t> face_offsets;
  int corners_per_face = 4;  ///< of alike faces

  [[nodiscard]] std::int64_t first_corner(std::int64_t face) const {
    return face_offsets.empty() ? corners_per_face * face : face_offsets[face];
  }
};

/// Where rows are written: each array as long as the range of rows, or empty.
struct RowTarget : PatchTarget {
  std::span<glm::vec4> colors;
};

/// Where rows are written that faces make along with them, of all rows of the surface in pieces of
/// kPieceRows, or nowhere.
struct FaceRows {
  static constexpr std::int64_t kPieceRows = std::int64_t{1} << 17;

  std::span<glm::vec3*const> stored, normals;
  glm::dvec3 origin{0.0};  ///< of `stored`

  [[nodiscard]] static glm::vec3& at(std::span<glm::vec3* const> pieces, std::int64_t row) {
    return pieces[row / kPieceRows][row % kPieceRows];
  }
};

/// A tessellation that is made piece by piece, as SurfaceMesh holds it whole: any range of its rows
/// (vertices) or faces, at any time, as often as wanted, from any number of threads at once.
/// Results do not depend on ranges or threads. Nobody holds the surface but who keeps what it gets.
class SurfaceBlocks {
 public:
  virtual ~SurfaceBlocks() = default;
  [[nodiscard]] const SurfaceInfo& info() const { return info_; }

  /// Ranges of about `row_count` rows that are cheap to make, which cover all. They are not
  /// ascending: rows made from the same control points come near each other. sorted() puts them in
  /// order.
  [[nodiscard]] virtual std::vector<RowRange> row_blocks(std::int64_t row_count) const = 0;
  /// Returns the rows whose normals are those of facets, for want of tangents.
  virtual DegenerateRows rows(RowRange rows, const RowTarget& target) const = 0;
  /// The same of rows that are named in ascending order, none twice.
  virtual DegenerateRows rows_at(std::span<const std::int32_t> rows, const RowTarget& target) const;

  /// Positions about `origin` as files have them, and normals, of rows in any order, where these
  /// are kept: about another point, or of rows that would have to be made, false, and nothing is
  /// written.
  virtual bool kept_rows_at([[maybe_unused]] std::span<const std::int32_t> rows,
                            [[maybe_unused]] const glm::dvec3& origin,
                            [[maybe_unused]] std::span<glm::vec3> stored,
                            [[maybe_unused]] std::span<glm::vec3> normals) const {
    return false;
  }

  /// The rows at the corners of faces, in order: from first_corner() of the first to that behind
  /// the last. Texture coordinates likewise.
  virtual void face_vertices(RowRange faces, std::span<std::int32_t> rows) const = 0;
  virtual void face_uvs(RowRange faces, std::span<std::int32_t> uvs) const = 0;
  virtual void face_groups(RowRange faces, std::span<std::int32_t> groups) const = 0;
  /// The face of the mesh that each one descends from.
  virtual void ancestors(RowRange faces, std::span<std::int32_t> mesh_faces) const = 0;
  virtual void uvs(RowRange uvs, std::span<glm::dvec2> values) const = 0;
  /// Numbers of rows of the attribute of that index, one row after another.
  virtual void attribute(std::size_t index, RowRange rows, std::span<float> values) const = 0;
  /// All texture coordinates of other values in the place of the mesh's texture coordinates, as
  /// many. False, and nothing is written, where nobody knows the mesh any more.
  virtual bool uvs_of([[maybe_unused]] std::span<const glm::dvec2> given,
                      [[maybe_unused]] std::span<glm::dvec2> values) const {
    return false;
  }
  /// The same of other values in their place, which go as colours do.
  virtual bool corners_of([[maybe_unused]] std::span<const glm::vec4> given,
                          [[maybe_unused]] std::span<glm::vec4> values) const {
    return false;
  }
  /// All rows of what is given to each vertex of the mesh, as those of colours. False as above.
  virtual bool rows_of([[maybe_unused]] std::span<const glm::vec4> given,
                       [[maybe_unused]] std::span<glm::vec4> values) const {
    return false;
  }

  /// Positions and normals at the corners of faces, without the rows: for figures that need no
  /// neighbours. Ranges are cheapest that begin and end at first faces of mesh faces.
  virtual void corners(RowRange faces, std::span<glm::dvec3> positions,
                       std::span<glm::vec3> normals) const = 0;
  /// Rows that corners_and_rows() makes, of level 2 or more.
  [[nodiscard]] virtual RowRange rows_of_faces() const { return {0, 0}; }
  /// corners() and, at little further cost, those of rows_of_faces() that lie on these faces. Faces
  /// of one patch must come together.
  virtual DegenerateRows corners_and_rows(RowRange faces, std::span<glm::dvec3> positions,
                                          std::span<glm::vec3> normals,
                                          [[maybe_unused]] const FaceRows& along) const {
    corners(faces, positions, normals);
    return {};
  }
  /// Which quads are cut from corner 1 to 3: see is_cut_from_1(). Of surfaces of quads alone.
  virtual void cuts(RowRange faces, std::span<std::uint8_t> from_1) const;
  /// Whether face_rows() is cheaper than rows() of rows_of_faces().
  [[nodiscard]] virtual bool makes_face_rows() const { return false; }
  /// Those of rows_of_faces() that lie on these faces. Faces of one patch must come together.
  /// `all`: positions and normals of all rows of the surface.
  virtual DegenerateRows face_rows([[maybe_unused]] RowRange faces,
                                   [[maybe_unused]] const PatchTarget& all) const {
    return {};
  }

 protected:
  SurfaceInfo info_;
};

/// [0, count) in pieces of `size`.
[[nodiscard]] std::vector<RowRange> ranges_of(std::int64_t count, std::int64_t size);
[[nodiscard]] std::vector<RowRange> sorted(std::vector<RowRange> ranges);

/// A surface that stands in memory, as blocks. It must outlive them. `mesh` is what it was made
/// from.
[[nodiscard]] std::unique_ptr<SurfaceBlocks> blocks_of(const SurfaceMesh& surface,
                                                       const PolygonMesh& mesh);

/// All rows of an attribute, made on all threads.
[[nodiscard]] VertexAttribute all_rows(const SurfaceBlocks& blocks, std::size_t attribute);

/// All rows of a surface, into arrays of all of them. Callbacks: step "evaluate" to 0.8, but for no
/// warning. Throws Error{Cancelled}.
DegenerateRows make_all_rows(const SurfaceBlocks& blocks, const RowTarget& all,
                             const Callbacks& callbacks);

/// The whole surface. Callbacks: step "evaluate", warning "degenerate-normals". Throws
/// Error{Cancelled}.
[[nodiscard]] SurfaceMesh collect(const SurfaceBlocks& blocks, const Callbacks& callbacks);

/// Warns "degenerate-normals" if there are any.
void warn_of(const DegenerateRows& rows, const Callbacks& callbacks);

/// Makes pieces on all threads and hands them over one at a time, in their order, on one thread at
/// a time: for writing what has no fixed size. `make(range, piece)` fills a Piece, which is used
/// again; `take(range, piece)` has it. As many pieces as threads exist at once.
template <class Piece, class Make, class Take>
void in_order(std::span<const RowRange> ranges, const Make& make, const Take& take) {
  // Two pieces a thread, so that none waits while one is taken.
  std::vector<Piece> pieces(2 * pipeline_threads());
  const PieceStep taker = [&](std::size_t i, std::size_t slot) { take(ranges[i], pieces[slot]); };
  ordered_pipeline(ranges.size(), pieces.size(),
                   [&](std::size_t i, std::size_t slot) { make(ranges[i], pieces[slot]); },
                   {&taker, 1});
}

}  // namespace planish
