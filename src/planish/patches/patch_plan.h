#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/patches/patch_mesh.h"

namespace planish {

class PatchRings;

/// The samples (a, b), 0 <= a, b <= N = 2^(level - 1), of a patch at u = a/N, v = b/N. First those
/// that a corner owns, in the order of its rows: (1..N-1, 0), then for b = 1..N-1 (1..N, b). Then
/// (0, 1..N-1), which it owns where its trailing edge is sharp; then the rest.
class PatchSamples {
 public:
  explicit PatchSamples(int level) : n_(1 << (level - 1)) {}

  [[nodiscard]] std::int32_t side() const { return n_; }  ///< N
  [[nodiscard]] std::int32_t count() const { return (n_ + 1) * (n_ + 1); }
  [[nodiscard]] std::int32_t leading_count() const { return n_ - 1; }
  [[nodiscard]] std::int32_t owned_count() const { return n_ * n_ - 1; }
  [[nodiscard]] std::int32_t trailing_count() const { return n_ - 1; }
  [[nodiscard]] std::int32_t first_trailing() const { return owned_count(); }
  [[nodiscard]] std::int32_t index(std::int32_t a, std::int32_t b) const {
    const std::int32_t shared = owned_count() + trailing_count();
    if (b == n_) return shared + 2 + a;
    if (a == 0) return b == 0 ? shared : owned_count() + b - 1;
    if (b == 0) return a == n_ ? shared + 1 : a - 1;
    return n_ - 1 + (b - 1) * n_ + a - 1;
  }
  struct Place {
    std::int32_t a, b;
  };
  /// Of a sample that is owned, or of the trailing edge: what index() leads from.
  [[nodiscard]] Place place(std::int32_t index) const {
    if (index < leading_count()) return {index + 1, 0};
    if (index >= first_trailing()) return {0, index - first_trailing() + 1};
    const std::int32_t inner = index - leading_count();
    return {inner % n_ + 1, inner / n_ + 1};
  }

 private:
  std::int32_t n_;
};

/// What a class's patches are of their control points: rows of weights for all but the own point,
/// which is the origin of the others and of the result. Positions' rows sum to 1 with the own
/// point's weight, tangents' to 0.
struct PatchTemplate {
  std::int32_t column_count = 0;  ///< K - 1
  std::int32_t sample_count = 0;
  /// Per sample in the order of PatchSamples three rows: point, du, dv.
  std::vector<double> weights;

  [[nodiscard]] std::span<const double> rows(std::int32_t sample) const {
    const auto size = 3 * static_cast<std::size_t>(column_count);
    return {weights.data() + size * static_cast<std::size_t>(sample), size};
  }
};

/// Makes templates. A patch of level L is four of level L - 1 of a step's points, so each class's
/// template is those of its quarters times small matrices.
class PatchTemplates {
 public:
  explicit PatchTemplates(Weights weights) : weights_(weights) {}

  /// Of a limit point at any level: one sample.
  [[nodiscard]] PatchTemplate make(const PatchClass& patch, int level);

 private:
  // All samples, row b (N + 1) + a, three rows of K weights each.
  using Grid = std::vector<double>;
  const Grid& grid(const PatchClass& patch, int level);
  void add_quarter(const PatchRings& rings, int quarter, int level, std::size_t columns,
                   Grid& result);

  FaceWeights weights_;
  std::map<std::pair<PatchClass, int>, std::unique_ptr<Grid>> grids_;
};

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

/// Rows that follow one another, of one part.
struct PatchTile {
  PatchNumbering::Part part;
  std::int64_t first_item, item_count;
  std::int64_t first_row, row_count;
};

/// Which patches make which rows, by class and samples.
struct PatchPlan {
  /// Which results a bucket's rows take: at a cut the further side's rows take their positions from
  /// the first side's patch, so that both are equal to the last bit.
  enum class Results : std::uint8_t { All, Positions, Normals };

  struct Bucket {
    std::int32_t class_index;
    std::int32_t first_sample, sample_count;
    Results results;
    std::int32_t item_count;

    [[nodiscard]] bool has_results_of(const Bucket& other) const {
      return first_sample == other.first_sample && sample_count == other.sample_count &&
             results == other.results;
    }
  };
  std::vector<Bucket> buckets;

  struct Item {
    PatchPlace place;
    std::int32_t bucket;
    std::int32_t target;  ///< the row of the bucket's first sample
  };
  std::vector<Item> items;

  void clear() {
    buckets.clear();
    items.clear();
  }
};

/// The classes of a mesh's patches by number, with their templates at one level.
class PatchClasses {
 public:
  PatchClasses(const PatchNumbering& numbering, const PatchMesh& mesh, Weights weights);

  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(classes_.size()); }
  [[nodiscard]] const PatchClass& patch(std::int32_t index) const { return classes_[index]; }
  [[nodiscard]] const PatchTemplate& weights(std::int32_t index) const { return templates_[index]; }
  [[nodiscard]] std::int32_t index_of(const PatchClass& patch) const;
  /// Of the smooth class with a ring and a face of few corners; -1 where there is none of them.
  [[nodiscard]] std::int32_t smooth_index(std::int32_t ring_size, std::int32_t face_size) const {
    return ring_size < kTableSize && face_size < kTableSize
               ? table_[static_cast<std::size_t>(ring_size) * kTableSize + face_size]
               : -1;
  }
  /// The largest K.
  [[nodiscard]] std::int32_t max_column_count() const { return max_column_count_; }

 private:
  // Smooth classes of few faces are found in a table.
  static constexpr std::int32_t kTableSize = 32;

  std::vector<PatchClass> classes_;  // ascending
  std::vector<PatchTemplate> templates_;
  std::vector<std::int32_t> table_;
  std::int32_t max_column_count_ = 0;
};

/// Cuts rows into tiles and lists their patches. All of it must outlive the planner.
class PatchPlanner {
 public:
  PatchPlanner(const PatchMesh& mesh, const PatchNumbering& numbering, const PatchClasses& classes)
      : mesh_(mesh), numbering_(numbering), classes_(classes) {}

  /// All tiles, ascending by rows.
  [[nodiscard]] std::vector<PatchTile> tiles() const;
  /// Adds a tile's items to a plan; its first row is `target` there.
  void add(const PatchTile& tile, std::int64_t target, PatchPlan& plan) const;

 private:
  const PatchMesh& mesh_;
  const PatchNumbering& numbering_;
  const PatchClasses& classes_;
};

}  // namespace planish
