#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_templates.h"

namespace planish {

/// The quads that tessellate a patch, in OpenSubdiv's order of the descendants of a face of Q_1:
/// four times the digits of their path, child j at corner j, which keeps the positions of its
/// vertices. A quad's corners are turned by their place in it, those of other faces begin at their
/// own V.
class PatchCells {
 public:
  explicit PatchCells(int level);

  /// 4^(level - 1) quads of a corner, as places b (N + 1) + a of samples.
  [[nodiscard]] std::span<const std::array<std::int32_t, 4>> of(const MeshTopology& topology,
                                                                std::int32_t corner) const {
    const bool quad = topology.face_size(topology.face_of(corner)) == 4;
    return cells_[quad ? topology.place_of(corner) : 0];
  }

 private:
  std::array<std::vector<std::array<std::int32_t, 4>>, 4> cells_;
};

/// Whether the faces on both sides of a corner's leading edge have other texture coordinates there,
/// or there is one side alone.
[[nodiscard]] bool is_uv_seam(const MeshTopology& topology,
                              std::span<const std::int32_t> corner_uvs, std::int32_t corner);

/// The rows of a tessellation and which of them its faces name.
///
/// Every sample has one row, that of the patch which owns it, but for cuts (sharp edges; seams of
/// texture coordinates), where each side has its own. In this order: one row per vertex of the
/// mesh, one per face (its centre), one per edge (its midpoint); per corner N^2 - 1, its owned
/// samples; N - 1 per corner whose trailing edge is cut; the further rows of vertices and
/// midpoints, vertices first. At level 0 there are those of vertices only. Without the rows that
/// only hidden faces name.
class PatchNumbering {
 public:
  enum class Part { Vertices, Faces, Edges, Corners, Trailing, Further };
  static constexpr int kPartCount = 6;

  /// The surface's own, cut at sharp edges. `hidden` holds one flag a face, or nothing; so does
  /// `corner_uvs` a texture coordinate a corner, at whose seams the rows are cut, too.
  PatchNumbering(const PatchMesh& mesh, int level, std::span<const std::uint8_t> hidden = {},
                 std::span<const std::int32_t> corner_uvs = {});
  /// That of texture coordinates: `corner_uvs` names one of `uv_count` at each corner. All of them
  /// keep their rows, hidden or not.
  PatchNumbering(const MeshTopology& topology, std::span<const std::int32_t> corner_uvs,
                 std::int32_t uv_count, int level, std::span<const std::uint8_t> hidden = {});

  [[nodiscard]] int level() const { return level_; }
  [[nodiscard]] const PatchSamples& samples() const { return samples_; }
  [[nodiscard]] std::int64_t row_count() const { return first_[kPartCount]; }
  [[nodiscard]] std::int64_t first_row(Part part) const { return first_[static_cast<int>(part)]; }
  [[nodiscard]] std::int64_t end_row(Part part) const { return first_[static_cast<int>(part) + 1]; }
  /// Vertices, faces, ... that have rows in a part: all corners in that of the corners.
  [[nodiscard]] std::int64_t item_count(Part part) const;

  /// What item i is: a corner at the vertex where its sector (or chart) begins; a corner of the
  /// face; the corner whose leading edge it is; a corner. Of Further one of the first or the third
  /// kind.
  [[nodiscard]] std::int32_t item_corner(Part part, std::int64_t item) const;
  /// Of Further: the corner whose row of an earlier part has the same position.
  [[nodiscard]] std::int32_t further_first(std::int64_t item) const { return further_first_[item]; }
  /// Of Further: whether it is an edge's midpoint.
  [[nodiscard]] bool is_further_edge(std::int64_t item) const { return item >= further_vertices_; }
  /// Of Corners: the first row of a corner, and how many rows it has: all of its owned samples,
  /// only those of its leading edge, or none.
  [[nodiscard]] std::int64_t corner_row(std::int32_t corner) const {
    return corner_rows_.empty() ? first_row(Part::Corners) + std::int64_t{corner} * owned_count_
                                : corner_rows_[corner];
  }
  /// The corner with a row of that part.
  [[nodiscard]] std::int32_t corner_of_row(std::int64_t row) const;
  [[nodiscard]] std::int32_t corner_row_count(std::int32_t corner) const {
    return corner_rows_.empty() ? owned_count_ : corner_rows_[corner + 1] - corner_rows_[corner];
  }

  [[nodiscard]] bool has_hidden() const { return !hidden_.empty(); }
  [[nodiscard]] bool is_hidden(std::int32_t face) const {
    return !hidden_.empty() && hidden_[face] != 0;
  }
  /// The row of a corner's sample, which must be visible.
  [[nodiscard]] std::int32_t row(std::int32_t corner, std::int32_t a, std::int32_t b) const;
  /// The rows of all samples of a visible corner, (a, b) at b (N + 1) + a.
  void grid(std::int32_t corner, std::int32_t* rows) const;
  [[nodiscard]] std::int32_t vertex_row(std::int32_t corner) const {
    return vertex_rows_.empty() ? topology_.vertex_of(corner) : vertex_rows_[corner];
  }
  [[nodiscard]] std::int32_t face_row(std::int32_t face) const {
    return static_cast<std::int32_t>(first_row(Part::Faces)) +
           (face_rows_.empty() ? face : face_rows_[face]);
  }
  /// Of the midpoint of a corner's leading edge.
  [[nodiscard]] std::int32_t edge_row(std::int32_t corner) const {
    return edge_rows_.empty()
               ? static_cast<std::int32_t>(first_row(Part::Edges)) + topology_.edge_of(corner)
               : edge_rows_[corner];
  }

 private:
  using IsCut = std::function<bool(std::int32_t corner)>;

  PatchNumbering(const MeshTopology& topology, int level, std::span<const std::uint8_t> hidden);
  void number_vertices(const PatchMesh& mesh, std::span<const std::int32_t> corner_uvs);
  void number_rest(bool has_cuts, const IsCut& is_cut);
  void number_edges(const IsCut& is_cut);
  void number_corners(const IsCut& is_cut);
  void place_further();
  [[nodiscard]] std::int32_t trailing_row(std::int32_t corner) const;
  [[nodiscard]] std::int32_t visible_side(std::int32_t edge) const;

  const MeshTopology& topology_;
  int level_;
  PatchSamples samples_;
  std::int32_t owned_count_;
  std::span<const std::uint8_t> hidden_;
  std::int64_t first_[kPartCount + 1] = {};

  // Empty where a row's number is its element's.
  RawVector<std::int32_t> vertex_rows_, edge_rows_;                   // per corner
  std::vector<std::int32_t> face_rows_;                               // per face, within its part
  std::vector<std::int32_t> corner_rows_;                             // corner_count + 1
  std::vector<std::int32_t> vertex_items_, face_items_, edge_items_;  // corners
  std::vector<std::int32_t> trailing_corners_;                        // ascending
  std::vector<std::int32_t> further_corners_, further_first_;
  std::int64_t further_vertices_ = 0;
  bool has_vertex_items_ = true;  // not for texture coordinates, whose rows are given
};

}  // namespace planish
