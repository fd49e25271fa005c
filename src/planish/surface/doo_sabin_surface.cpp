#include "planish/surface/doo_sabin_surface.h"

#include <algorithm>
#include <mutex>
#include <optional>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/patches/first_step.h"
#include "planish/surface/memory_need.h"
#include "planish/surface/patch_attributes.h"
#include "planish/surface/subdivided_mesh.h"

namespace planish {

namespace {

SharpFeatures sharp_features(const UsedPart& used, const EvaluateOptions& options) {
  const MeshTopology& topology = *used.prepared->topology;
  if (options.rest_positions.empty())
    return find_sharp_features(used.mesh, topology, used.mesh.positions, options.sharp);
  if (used.prepared->uses_all())
    return find_sharp_features(used.mesh, topology, options.rest_positions, options.sharp);
  std::vector<glm::dvec3> rest(used.vertices.size());
  for (std::size_t v = 0; v < rest.size(); ++v) rest[v] = options.rest_positions[used.vertices[v]];
  return find_sharp_features(used.mesh, topology, rest, options.sharp);
}

// Corners name values one past the given ones where the mesh has none.
struct CornerUvs {
  explicit CornerUvs(const PolygonMesh& mesh)
      : indices(mesh.face_uvs), count(static_cast<std::int32_t>(mesh.uvs.size())) {
    bool missing = false;
    for (std::int32_t& uv : indices) {
      if (uv < 0) uv = static_cast<std::int32_t>(mesh.uvs.size()), missing = true;
    }
    if (missing) ++count;
  }
  std::vector<std::int32_t> indices;
  std::int32_t count;
};

class DooSabinBlocks final : public SurfaceBlocks {
 public:
  DooSabinBlocks(const DooSabinSurface& base, int level, PatchEvaluator* evaluator)
      : base_(base),
        topology_(base.topology()),
        surface_(base.patches(),
                 {.level = level, .weights = base.weights(), .hidden = base.hidden()}),
        cells_(std::max(level, 1)) {
    const PatchSamples& samples = surface_.numbering().samples();
    for (std::int32_t b = 0; b <= samples.side(); ++b) {
      for (std::int32_t a = 0; a <= samples.side(); ++a) {
        sample_of_place_.push_back(samples.index(a, b));
      }
    }
    const PolygonMesh& mesh = base.mesh();
    info_.level = level;
    info_.row_count = surface_.numbering().row_count();
    info_.has_colors = !mesh.colors.empty();
    info_.has_groups = !mesh.face_groups.empty();
    if (info_.has_groups) info_.groups = mesh.groups;
    take_base_vertices();
    count_faces();
    if (evaluator != nullptr) {
      device_rows_.resize(static_cast<std::size_t>(info_.row_count));
      evaluator->evaluate_patches(surface_, base.state(), device_rows_);
    }
    if (mesh.face_uvs.empty()) return;
    uvs_.emplace(mesh);
    uv_numbering_.emplace(topology_, uvs_->indices, uvs_->count, level, base.hidden());
    info_.uv_count = uv_numbering_->row_count();
  }

  [[nodiscard]] std::vector<RowRange> row_blocks(std::int64_t row_count) const override;
  DegenerateRows rows(RowRange range, const RowTarget& target) const override;
  void face_vertices(RowRange faces, std::span<std::int32_t> rows) const override {
    write_faces(surface_.numbering(), faces, rows);
  }
  void face_uvs(RowRange faces, std::span<std::int32_t> uvs) const override {
    write_faces(*uv_numbering_, faces, uvs);
  }
  void face_groups(RowRange faces, std::span<std::int32_t> groups) const override {
    for (std::int64_t i = 0; i < faces.count; ++i) {
      groups[i] = base_.mesh().face_groups[mesh_face(faces.first + i)];
    }
  }
  void ancestors(RowRange faces, std::span<std::int32_t> mesh_faces) const override {
    for (std::int64_t i = 0; i < faces.count; ++i) mesh_faces[i] = mesh_face(faces.first + i);
  }
  void uvs(RowRange range, std::span<glm::dvec2> values) const override;
  void corners(RowRange faces, std::span<glm::dvec3> positions,
               std::span<glm::vec3> normals) const override {
    if (!device_rows_.empty()) return corners_from_device(faces, positions, normals);
    if (level() == 0) return polygon_corners(faces, positions, normals);
    (void)quad_corners(faces, positions, normals, {});
  }
  [[nodiscard]] RowRange rows_of_faces() const override {
    const PatchNumbering& numbering = surface_.numbering();
    // Beside hidden faces there are rows that no visible one makes; a device has made them all.
    if (level() < 2 || numbering.has_hidden() || !device_rows_.empty()) return {0, 0};
    const std::int64_t first = numbering.first_row(PatchNumbering::Part::Corners);
    return {first, numbering.end_row(PatchNumbering::Part::Corners) - first};
  }
  DegenerateRows corners_and_rows(RowRange faces, std::span<glm::dvec3> positions,
                                  std::span<glm::vec3> normals,
                                  const FaceRows& along) const override {
    return quad_corners(faces, positions, normals, along);
  }

 private:
  void polygon_corners(RowRange faces, std::span<glm::dvec3> positions,
                       std::span<glm::vec3> normals) const;
  DegenerateRows quad_corners(RowRange faces, std::span<glm::dvec3> positions,
                              std::span<glm::vec3> normals, const FaceRows& along) const;
  void take_base_vertices();
  void count_faces();
  DegenerateRows rows_from_device(RowRange range, const PatchTarget& target) const;
  void corners_from_device(RowRange faces, std::span<glm::dvec3> positions,
                           std::span<glm::vec3> normals) const;
  [[nodiscard]] int level() const { return info_.level; }
  // Cells of a corner's patch.
  [[nodiscard]] std::int64_t cell_count() const {
    const std::int64_t n = surface_.numbering().samples().side();
    return n * n;
  }
  [[nodiscard]] std::int32_t visible_corner(std::int64_t i) const {
    return visible_.empty() ? static_cast<std::int32_t>(i) : visible_[i];
  }
  [[nodiscard]] std::int32_t mesh_face(std::int64_t face) const {
    if (level() == 0) return visible_corner(face);
    return topology_.face_of(visible_corner(face / cell_count()));
  }
  void write_faces(const PatchNumbering& numbering, RowRange faces,
                   std::span<std::int32_t> rows) const;

  const DooSabinSurface& base_;
  const MeshTopology& topology_;
  PatchSurface surface_;
  PatchCells cells_;
  std::vector<std::int32_t> sample_of_place_;
  std::vector<std::int32_t> visible_;  // level 0: faces, else corners; empty: all
  std::optional<CornerUvs> uvs_;
  std::optional<PatchNumbering> uv_numbering_;
  RawVector<PatchEvaluator::Row> device_rows_;  // all of them, or none
  // Of level 0, once corners() was asked for.
  mutable std::once_flag all_made_;
  mutable std::vector<glm::dvec3> all_positions_;
  mutable std::vector<glm::vec3> all_normals_;
};

void DooSabinBlocks::take_base_vertices() {
  const PatchNumbering& numbering = surface_.numbering();
  const auto count = static_cast<std::size_t>(numbering.item_count(PatchNumbering::Part::Vertices));
  info_.base_vertices.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t vertex = topology_.vertex_of(
        numbering.item_corner(PatchNumbering::Part::Vertices, static_cast<std::int64_t>(i)));
    info_.base_vertices[i] = base_.used().vertices[vertex];
  }
}

void DooSabinBlocks::count_faces() {
  const auto hidden = base_.hidden();
  if (level() == 0) {
    info_.face_offsets.push_back(0);
    for (std::int32_t f = 0; f < topology_.face_count(); ++f) {
      if (!hidden.empty() && hidden[f] != 0) continue;
      if (!hidden.empty()) visible_.push_back(f);
      info_.face_offsets.push_back(info_.face_offsets.back() + topology_.face_size(f));
    }
    info_.face_count = static_cast<std::int64_t>(info_.face_offsets.size()) - 1;
    info_.corner_count = info_.face_offsets.back();
    return;
  }
  std::int64_t corners = topology_.corner_count();
  if (!hidden.empty()) {
    for (std::int32_t c = 0; c < topology_.corner_count(); ++c) {
      if (hidden[topology_.face_of(c)] == 0) visible_.push_back(c);
    }
    corners = static_cast<std::int64_t>(visible_.size());
  }
  info_.face_count = corners * cell_count();
  info_.corner_count = 4 * info_.face_count;
}

// Tiles joined up to the wanted size, those of all parts side by side: rows of neighbours read the
// same control points.
std::vector<RowRange> DooSabinBlocks::row_blocks(std::int64_t row_count) const {
  struct Block {
    RowRange rows;
    PatchNumbering::Part part;
    double place;  // in its part, 0 to 1
  };
  std::vector<Block> blocks;
  for (const PatchTile& tile : surface_.tiles()) {
    if (!blocks.empty() && blocks.back().part == tile.part &&
        blocks.back().rows.count + tile.row_count <= row_count) {
      blocks.back().rows.count += tile.row_count;
      continue;
    }
    const PatchNumbering& numbering = surface_.numbering();
    const double place =
        static_cast<double>(tile.first_row - numbering.first_row(tile.part)) /
        static_cast<double>(numbering.end_row(tile.part) - numbering.first_row(tile.part));
    blocks.push_back({{tile.first_row, tile.row_count}, tile.part, place});
  }
  std::stable_sort(blocks.begin(), blocks.end(),
                   [](const Block& a, const Block& b) { return a.place < b.place; });
  std::vector<RowRange> ranges;
  ranges.reserve(blocks.size());
  for (const Block& block : blocks) ranges.push_back(block.rows);
  return ranges;
}

DegenerateRows DooSabinBlocks::rows(RowRange range, const RowTarget& target) const {
  DegenerateRows degenerate;
  if (!target.positions.empty() || !target.stored.empty() || !target.normals.empty()) {
    degenerate = device_rows_.empty()
                     ? surface_.rows(base_.state(), base_.placement(), range, target)
                     : rows_from_device(range, target);
  }
  if (target.colors.empty()) return degenerate;
  const PatchNumbering& numbering = surface_.numbering();
  const PolygonMesh& mesh = base_.mesh();
  const auto at = [&](std::int32_t corner) {
    return glm::dvec4(mesh.colors[topology_.vertex_of(corner)]);
  };
  const std::int64_t vertices = numbering.end_row(PatchNumbering::Part::Vertices);
  for (std::int64_t row = range.first; row < std::min(range.first + range.count, vertices); ++row) {
    const std::int32_t corner = numbering.item_corner(PatchNumbering::Part::Vertices, row);
    target.colors[row - range.first] = mesh.colors[topology_.vertex_of(corner)];
  }
  BilinearRows<glm::dvec4, decltype(at)>(topology_, numbering, at)
      .write(range, [&](std::int64_t row, const glm::dvec4& color) {
        target.colors[row - range.first] = glm::vec4(color);
      });
  return degenerate;
}

DegenerateRows DooSabinBlocks::rows_from_device(RowRange range, const PatchTarget& target) const {
  DegenerateRows degenerate;
  for (std::int64_t i = 0; i < range.count; ++i) {
    const PatchEvaluator::Row& row = device_rows_[range.first + i];
    const glm::dvec3 position = base_.placement().to_model(row.position);
    if (!target.positions.empty()) target.positions[i] = position;
    if (!target.stored.empty()) target.stored[i] = glm::vec3(position - target.origin);
    if (target.normals.empty()) continue;
    target.normals[i] = row.normal;
    if (row.normal != glm::vec3(0.0f)) continue;
    // The host knows the facets around it.
    PatchTarget one;
    one.normals = target.normals.subspan(static_cast<std::size_t>(i), 1);
    (void)surface_.rows(base_.state(), base_.placement(), {range.first + i, 1}, one);
    degenerate.add({1, range.first + i});
  }
  return degenerate;
}

void DooSabinBlocks::corners_from_device(RowRange faces, std::span<glm::dvec3> positions,
                                         std::span<glm::vec3> normals) const {
  std::vector<std::int32_t> vertices(positions.size());
  face_vertices(faces, vertices);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    PatchTarget one;
    one.positions = positions.subspan(i, 1);
    one.normals = normals.subspan(i, 1);
    (void)rows_from_device({vertices[i], 1}, one);
  }
}

void DooSabinBlocks::uvs(RowRange range, std::span<glm::dvec2> values) const {
  const PolygonMesh& mesh = base_.mesh();
  const auto value = [&](std::size_t uv) {
    return uv < mesh.uvs.size() ? mesh.uvs[uv] : glm::dvec2(0.0);
  };
  const auto at = [&](std::int32_t corner) {
    return value(static_cast<std::size_t>(uvs_->indices[corner]));
  };
  for (std::int64_t row = range.first;
       row < std::min(range.first + range.count, std::int64_t{uvs_->count}); ++row) {
    values[row - range.first] = value(static_cast<std::size_t>(row));
  }
  BilinearRows<glm::dvec2, decltype(at)>(topology_, *uv_numbering_, at)
      .write(range,
             [&](std::int64_t row, const glm::dvec2& uv) { values[row - range.first] = uv; });
}

void DooSabinBlocks::write_faces(const PatchNumbering& numbering, RowRange faces,
                                 std::span<std::int32_t> rows) const {
  std::int32_t* to = rows.data();
  if (level() == 0) {
    for (std::int64_t f = faces.first; f < faces.first + faces.count; ++f) {
      const std::int32_t face = visible_corner(f), first = topology_.first_corner(face);
      for (std::int32_t i = 0; i < topology_.face_size(face); ++i) {
        *to++ = numbering.vertex_row(first + i);
      }
    }
    return;
  }
  const std::int64_t per_corner = cell_count();
  const std::int32_t side = numbering.samples().side() + 1;
  std::vector<std::int32_t> grid(static_cast<std::size_t>(side * side));
  const std::int64_t end = faces.first + faces.count;
  for (std::int64_t face = faces.first; face < end;) {
    const std::int32_t corner = visible_corner(face / per_corner);
    const std::int64_t first = face % per_corner;
    const std::int64_t count = std::min(per_corner - first, end - face);
    numbering.grid(corner, grid.data());
    const auto cells = cells_.of(topology_, corner);
    for (std::int64_t i = first; i < first + count; ++i, to += 4) {
      for (int k = 0; k < 4; ++k) to[k] = grid[cells[i][k]];
    }
    face += count;
  }
}

DegenerateRows DooSabinBlocks::quad_corners(RowRange faces, std::span<glm::dvec3> positions,
                                            std::span<glm::vec3> normals,
                                            const FaceRows& along) const {
  thread_local std::vector<std::int32_t> of;
  thread_local RawVector<glm::dvec3> grid_positions;
  thread_local RawVector<glm::vec3> grid_normals;
  const std::int64_t cells = cell_count(), first = faces.first / cells,
                     last = (faces.first + faces.count + cells - 1) / cells;
  const PatchNumbering& numbering = surface_.numbering();
  const auto count = static_cast<std::size_t>(numbering.samples().count());
  of.resize(static_cast<std::size_t>(last - first));
  for (std::int64_t i = first; i < last; ++i) of[i - first] = visible_corner(i);
  grid_positions.resize(of.size() * count);
  grid_normals.resize(grid_positions.size());
  PatchTarget target;
  target.positions = grid_positions;
  target.normals = grid_normals;
  const DegenerateRows owned = surface_.grids(base_.state(), base_.placement(), of, target);
  std::size_t to = 0;
  for (std::size_t i = 0; i < of.size(); ++i) {
    const glm::dvec3* p = grid_positions.data() + i * count;
    const glm::vec3* n = grid_normals.data() + i * count;
    const std::int64_t before = (first + static_cast<std::int64_t>(i)) * cells;
    const auto begin = static_cast<std::size_t>(std::max(faces.first - before, std::int64_t{0}));
    const auto end = static_cast<std::size_t>(std::min(faces.first + faces.count - before, cells));
    for (const auto& cell : cells_.of(topology_, of[i]).subspan(begin, end - begin)) {
      for (const std::int32_t place : cell) {
        const std::int32_t sample = sample_of_place_[place];
        positions[to] = p[sample];
        normals[to++] = n[sample];
      }
    }
    if (along.stored.empty()) continue;
    const std::int64_t row = numbering.corner_row(of[i]);
    for (std::int32_t s = 0; s < numbering.samples().owned_count(); ++s) {
      FaceRows::at(along.stored, row + s) = glm::vec3(p[s] - along.origin);
      FaceRows::at(along.normals, row + s) = n[s];
    }
  }
  return owned;
}

void DooSabinBlocks::polygon_corners(RowRange faces, std::span<glm::dvec3> positions,
                                     std::span<glm::vec3> normals) const {
  // Polygons name rows from all over.
  std::call_once(all_made_, [&] {
    all_positions_.resize(static_cast<std::size_t>(info_.row_count));
    all_normals_.resize(all_positions_.size());
    RowTarget target;
    target.positions = all_positions_;
    target.normals = all_normals_;
    (void)this->rows({0, info_.row_count}, target);
  });
  std::vector<std::int32_t> rows(positions.size());
  face_vertices(faces, rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    positions[i] = all_positions_[rows[i]];
    normals[i] = all_normals_[rows[i]];
  }
}

}  // namespace

DooSabinSurface::DooSabinSurface(const PolygonMesh& mesh, const EvaluateOptions& options, Begin)
    : used_(usable_part(mesh, options.prepared)),
      features_(sharp_features(used_, options)),
      patches_(topology(), features_),
      weights_(options.weights) {
  if (used_.mesh.hole_faces.empty()) return;
  hidden_.assign(static_cast<std::size_t>(topology().face_count()), 0);
  for (const std::int32_t face : used_.mesh.hole_faces) hidden_[face] = 1;
}

DooSabinSurface::DooSabinSurface(const PolygonMesh& cage, const EvaluateOptions& options)
    : DooSabinSurface(cage, options, Begin{}) {
  placement_ = placement_of(used_.mesh);
  RawVector<glm::dvec3> unit(used_.mesh.positions.size());
  parallel_for(unit.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      unit[v] = placement_.to_unit(used_.mesh.positions[v]);
    }
  });
  own_state_ = first_step(patches_, weights_, unit);
  state_ = own_state_;
}

DooSabinSurface::DooSabinSurface(const PolygonMesh& mesh, const LevelOne& level_one,
                                 const EvaluateOptions& options)
    : DooSabinSurface(mesh, options, Begin{}) {
  require_state_size(patches_.state_size(), level_one);
  placement_ = level_one.placement;
  state_ = level_one.state;
}

std::unique_ptr<SurfaceBlocks> DooSabinSurface::level(int level, std::uint64_t memory_limit_bytes,
                                                      PatchEvaluator* evaluator) const {
  require_level(level);
  const std::vector<LevelCounts> counts =
      split_counts({topology().vertex_count(), topology().edge_count(), topology().face_count()},
                   topology().corner_count(), level);
  RefinedAttributes attributes = RefinedAttributes::of(used_.mesh);
  attributes.device_rows = evaluator != nullptr;
  require_memory(counts, LastLevel::None, attributes, memory_limit_bytes);
  return std::make_unique<DooSabinBlocks>(*this, level, evaluator);
}

}  // namespace planish
