#include "planish/surface/doo_sabin_surface.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/patches/doo_sabin_step.h"
#include "planish/surface/doo_sabin_blocks.h"
#include "planish/surface/level_one_mesh.h"

namespace planish {

// A face has at least three corners: a row for each vertex and midpoint, and one for the centre.
SharedPoints::SharedPoints(const MeshTopology& topology, const PatchNumbering& numbering,
                           std::int64_t corner_count)
    : topology_(topology),
      numbering_(numbering),
      rows_(static_cast<std::size_t>(2 * corner_count + corner_count / 3 + 1)),
      vertices_(static_cast<std::size_t>(corner_count)),
      midpoints_(static_cast<std::size_t>(corner_count)) {}

void SharedPoints::add_face(std::int32_t face) {
  const std::int32_t first = topology_.first_corner(face);
  if (first != end_) begin_ = first;
  end_ = first + topology_.face_size(face);
  centre_ = add(numbering_.face_row(face));
  const std::int32_t begin = begin_;
  const auto is_known = [begin, first](std::int32_t corner) {
    return corner >= begin && corner < first;
  };
  std::int32_t across_trailing = topology_.twin(end_ - 1);
  for (std::int32_t corner = first; corner < end_; ++corner) {
    const std::int32_t across = topology_.twin(corner);
    // Corners at the same vertex: the one across the trailing edge, else that across the leading.
    std::int32_t place = -1;
    if (is_known(across_trailing)) {
      place = vertex(across_trailing);
    } else if (is_known(across)) {
      const std::int32_t other = topology_.next(across);
      place = vertex(other);
    }
    vertices_[corner - begin] = find_or_add(numbering_.vertex_row(corner), place);
    midpoints_[corner - begin] =
        find_or_add(numbering_.edge_row(corner), is_known(across) ? midpoint(across) : -1);
    across_trailing = across;
  }
}

namespace {

constexpr std::size_t kFieldRows = std::size_t{1} << 14;

// of(range) of all rows, on all threads.
template <class Of>
void for_row_ranges(std::int64_t count, const Of& of) {
  parallel_for(
      static_cast<std::size_t>(count), kFieldRows, [&](std::size_t begin, std::size_t end) {
        of(RowRange{static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end - begin)});
      });
}

template <class T>
std::span<T> rows_in(std::span<T> values, RowRange range) {
  return values.subspan(static_cast<std::size_t>(range.first),
                        static_cast<std::size_t>(range.count));
}

}  // namespace

void DooSabinBlocks::take_base_vertices() {
  const PatchNumbering& numbering = surface_.numbering();
  const auto count = static_cast<std::size_t>(numbering.item_count(PatchNumbering::Part::Vertices));
  info_.base_vertices.resize(count);
  parallel_each(count, 1 << 14, [&](std::size_t i) {
    const std::int32_t vertex = topology_.vertex_of(
        numbering.item_corner(PatchNumbering::Part::Vertices, static_cast<std::int64_t>(i)));
    info_.base_vertices[i] = base_.used().vertices[vertex];
  });
}

void DooSabinBlocks::count_faces() {
  const auto hidden = base_.hidden();
  if (level() == 0 && hidden.empty()) {
    const auto offsets = topology_.face_offsets();
    info_.face_offsets.assign(offsets.begin(), offsets.end());
  } else if (level() == 0) {
    info_.face_offsets.push_back(0);
    for (std::int32_t f = 0; f < topology_.face_count(); ++f) {
      if (hidden[f] != 0) continue;
      visible_.push_back(f);
      info_.face_offsets.push_back(info_.face_offsets.back() + topology_.face_size(f));
    }
  }
  if (level() == 0) {
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
  if (!target.colors.empty()) write_values(base_.color_field(), range, target.colors);
  return degenerate;
}

bool DooSabinBlocks::rows_of(std::span<const glm::vec4> given, std::span<glm::vec4> values) const {
  std::vector<glm::vec4> used;
  for (const std::int32_t vertex : base_.used().vertices) used.push_back(given[vertex]);
  const ChartField<glm::dvec4> field = base_.vertex_field_of(used);
  for_row_ranges(info_.row_count,
                 [&](RowRange range) { write_values(field, range, rows_in(values, range)); });
  return true;
}

void DooSabinBlocks::attribute(std::size_t index, RowRange range, std::span<float> values) const {
  const auto width = static_cast<std::size_t>(base_.mesh().attributes[index].width);
  std::vector<glm::vec4> four(static_cast<std::size_t>(range.count));
  for (const NumberRun& run : runs_of(base_.mesh().attributes, index)) {
    write_values(base_.number_field(run.four), range, four);
    for (std::size_t i = 0; i < four.size(); ++i)
      for (int k = 0; k < run.count; ++k)
        values[width * i + static_cast<std::size_t>(run.column + k)] = four[i][run.lane + k];
  }
}

void DooSabinBlocks::write_values(const ChartField<glm::dvec4>& field, RowRange range,
                                  std::span<glm::vec4> values) const {
  const PatchNumbering& numbering = surface_.numbering();
  const std::int64_t vertices = numbering.end_row(PatchNumbering::Part::Vertices);
  for (std::int64_t row = range.first; row < std::min(range.first + range.count, vertices); ++row)
    values[row - range.first] =
        field.given(numbering.item_corner(PatchNumbering::Part::Vertices, row));
  ChartRows<glm::dvec4>(field, numbering, surface_.classes())
      .write(range, [&](std::int64_t row, const glm::dvec4& value) {
        values[row - range.first] = glm::vec4(value);
      });
}

DegenerateRows DooSabinBlocks::rows_at(std::span<const std::int32_t> rows,
                                       const RowTarget& target) const {
  if (!device_rows_.empty()) return SurfaceBlocks::rows_at(rows, target);
  const DegenerateRows degenerate =
      surface_.rows_at(base_.state(), base_.placement(), rows, target);
  for (std::size_t i = 0; i < rows.size() && !target.colors.empty();) {
    std::size_t end = i + 1;
    while (end < rows.size() && rows[end] == rows[end - 1] + 1) ++end;
    RowTarget colors;
    colors.colors = target.colors.subspan(i, end - i);
    (void)this->rows({rows[i], static_cast<std::int64_t>(end - i)}, colors);
    i = end;
  }
  return degenerate;
}

RowRange DooSabinBlocks::faces_of(std::int32_t face) const {
  const auto hidden = base_.hidden();
  if (!hidden.empty() && hidden[face] != 0) return {0, 0};
  const std::int32_t first = level() == 0 ? face : topology_.first_corner(face);
  const auto place = visible_.empty()
                         ? std::int64_t{first}
                         : std::ranges::lower_bound(visible_, first) - visible_.begin();
  if (level() == 0) return {place, 1};
  return {place * cell_count(), topology_.face_size(face) * cell_count()};
}

std::int64_t DooSabinBlocks::rows_of(std::span<const std::uint8_t> is_of) const {
  using Part = PatchNumbering::Part;
  const PatchNumbering& numbering = surface_.numbering();
  std::int64_t count = 0;
  const auto is_own = [&](std::int32_t corner) { return is_of[topology_.face_of(corner)] != 0; };
  for (const Part part :
       {Part::Vertices, Part::Faces, Part::Edges, Part::Trailing, Part::Further}) {
    const std::int64_t rows =
        part == Part::Trailing ? numbering.samples().trailing_count() : std::int64_t{1};
    for (std::int64_t item = 0; item < numbering.item_count(part); ++item)
      if (is_own(numbering.item_corner(part, item))) count += rows;
  }
  for (std::int32_t corner = 0; corner < topology_.corner_count(); ++corner)
    if (is_own(corner)) count += numbering.corner_row_count(corner);
  return count;
}

void DooSabinBlocks::edge_rows(std::int32_t corner, std::vector<std::int32_t>& rows) const {
  write_edge(surface_.numbering(), corner, rows);
}

void DooSabinBlocks::edge_uvs(std::int32_t corner, std::vector<std::int32_t>& uvs) const {
  write_edge(*uv_numbering_, corner, uvs);
}

// Half of it lies on the patch of the corner, half on that of the next one.
void DooSabinBlocks::write_edge(const PatchNumbering& numbering, std::int32_t corner,
                                std::vector<std::int32_t>& rows) const {
  const std::int32_t n = numbering.samples().side(), next = topology_.next(corner);
  rows.clear();
  for (std::int32_t a = 0; a <= n; ++a) rows.push_back(numbering.row(corner, a, 0));
  for (std::int32_t b = n; b-- > 0;) rows.push_back(numbering.row(next, 0, b));
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

template <class Vector, class Stored, class Field>
void DooSabinBlocks::write_corner_rows(std::span<const Stored> given, RowRange range,
                                       std::span<Stored> values, const Field& field) const {
  const std::int64_t count = base_.corner_uvs().count, last = range.first + range.count;
  for (std::int64_t row = range.first; row < std::min(last, count); ++row) {
    const auto at = static_cast<std::size_t>(row);
    values[row - range.first] = at < given.size() ? given[at] : Stored(0.0);
  }
  if (last <= count) return;
  ChartRows<Vector>(field(), *uv_numbering_, surface_.classes())
      .write(range, [&](std::int64_t row, const Vector& value) {
        values[row - range.first] = Stored(value);
      });
}

template <class Vector, class Stored, class Field>
void DooSabinBlocks::write_all_corner_rows(std::span<const Stored> given, std::span<Stored> values,
                                           const Field& make_field) const {
  const ChartField<Vector> field = make_field();
  for_row_ranges(info_.uv_count, [&](RowRange range) {
    write_corner_rows<Vector>(given, range, rows_in(values, range),
                              [&]() -> const ChartField<Vector>& { return field; });
  });
}

void DooSabinBlocks::uvs(RowRange range, std::span<glm::dvec2> values) const {
  write_corner_rows<glm::dvec2>(
      std::span<const glm::dvec2>(base_.mesh().uvs), range, values,
      [&]() -> const ChartField<glm::dvec2>& { return base_.uv_field(); });
}

bool DooSabinBlocks::uvs_of(std::span<const glm::dvec2> given, std::span<glm::dvec2> values) const {
  write_all_corner_rows<glm::dvec2>(given, values, [&] { return base_.uv_field_of(given); });
  return true;
}

bool DooSabinBlocks::corners_of(std::span<const glm::vec4> given,
                                std::span<glm::vec4> values) const {
  write_all_corner_rows<glm::dvec4>(given, values, [&] { return base_.corner_field_of(given); });
  return true;
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
  thread_local PointRows points;
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
  const bool makes_points = !along.stored.empty() && surface_.makes_points();
  const DegenerateRows owned = surface_.grids(base_.state(), base_.placement(), of, target,
                                              makes_points ? &points : nullptr);
  for (std::size_t i = 0; makes_points && i < points.size(); ++i) {
    const std::int32_t row = points.rows()[i];
    FaceRows::at(along.stored, row) = glm::vec3(points.positions()[i] - along.origin);
    FaceRows::at(along.normals, row) = points.normals()[i];
  }
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

DegenerateRows DooSabinBlocks::face_rows(RowRange faces, const PatchTarget& all) const {
  thread_local PointRows points;
  const std::int64_t cells = cell_count(), first = faces.first / cells,
                     last = (faces.first + faces.count + cells - 1) / cells;
  const auto corner = static_cast<std::int32_t>(first);
  const std::int64_t row = surface_.numbering().corner_row(corner);
  PatchTarget target;
  target.positions = all.positions.subspan(static_cast<std::size_t>(row));
  target.normals = all.normals.subspan(static_cast<std::size_t>(row));
  const DegenerateRows found =
      surface_.owned(base_.state(), base_.placement(), corner,
                     static_cast<std::int32_t>(last - first), target, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = static_cast<std::size_t>(points.rows()[i]);
    all.positions[at] = points.positions()[i];
    all.normals[at] = points.normals()[i];
  }
  return found;
}

// At levels 0 and 1 every corner is a row of a vertex, a face or an edge.
void DooSabinBlocks::point_corners(RowRange faces, std::span<glm::dvec3> positions,
                                   std::span<glm::vec3> normals) const {
  if (faces.count == 0) return;
  PatchTarget target;
  if (level() == 0) {
    thread_local RawVector<std::int32_t> rows;
    rows.resize(positions.size());
    face_vertices(faces, rows);
    target.positions = positions;
    target.normals = normals;
    (void)surface_.points(base_.state(), base_.placement(), rows, target);
    return;
  }
  thread_local RawVector<std::int32_t> of_corner;
  thread_local RawVector<glm::dvec3> made_positions;
  thread_local RawVector<glm::vec3> made_normals;
  of_corner.resize(positions.size());
  // Of the mesh's faces at both ends all corners count.
  const auto corner_count_of = [&](std::int64_t quad) {
    return topology_.face_size(topology_.face_of(visible_corner(quad)));
  };
  SharedPoints points(
      topology_, surface_.numbering(),
      faces.count + corner_count_of(faces.first) + corner_count_of(faces.first + faces.count - 1));
  std::int32_t mesh_face = -1;
  std::int32_t* to = of_corner.data();
  for (std::int64_t i = 0; i < faces.count; ++i, to += 4) {
    const std::int32_t corner = visible_corner(faces.first + i);
    const std::int32_t face = topology_.face_of(corner);
    if (face != mesh_face) points.add_face(mesh_face = face);
    // By places: (0, 0), (1, 0), (0, 1), (1, 1).
    const std::int32_t made[4] = {points.vertex(corner), points.midpoint(corner),
                                  points.midpoint(topology_.prev(corner)), points.centre()};
    const auto& cell = cells_.of(topology_, corner).front();
    for (std::size_t k = 0; k < 4; ++k) to[k] = made[cell[k]];
  }
  made_positions.resize(points.rows().size());
  made_normals.resize(points.rows().size());
  target.positions = made_positions;
  target.normals = made_normals;
  (void)surface_.points(base_.state(), base_.placement(), points.rows(), target);
  for (std::size_t i = 0; i < of_corner.size(); ++i) {
    positions[i] = made_positions[of_corner[i]];
    normals[i] = made_normals[of_corner[i]];
  }
}

namespace {

std::shared_ptr<const SharpFeatures> sharp_features(const UsedPart& used,
                                                    const EvaluateOptions& options) {
  if (options.features) return options.features;
  const auto of_pose = [&](std::span<const glm::dvec3> pose) {
    return std::make_shared<const SharpFeatures>(
        find_sharp_features(used.mesh, *used.prepared->topology, pose, options.sharp));
  };
  if (options.rest_positions.empty()) return of_pose(used.mesh.positions);
  if (used.prepared->uses_all()) return of_pose(options.rest_positions);
  std::vector<glm::dvec3> rest(used.vertices.size());
  for (std::size_t v = 0; v < rest.size(); ++v) rest[v] = options.rest_positions[used.vertices[v]];
  return of_pose(rest);
}

}  // namespace

DooSabinSurface::DooSabinSurface(const PolygonMesh& mesh, const EvaluateOptions& options, Begin)
    : used_(usable_part(mesh, options.prepared)),
      features_(sharp_features(used_, options)),
      patches_(topology(), *features_, ring_columns(topology(), options.weights, used_.vertices)),
      weights_(options.weights) {
  if (used_.mesh.hole_faces.empty()) return;
  hidden_ = hole_flags(used_.mesh);
}

DooSabinSurface::DooSabinSurface(const PolygonMesh& cage, const EvaluateOptions& options)
    : DooSabinSurface(cage, options, Begin{}) {
  take_cage(placement_of(used_.mesh));
}

DooSabinSurface::DooSabinSurface(const PolygonMesh& cage, const Placement& placement,
                                 const EvaluateOptions& options)
    : DooSabinSurface(cage, options, Begin{}) {
  take_cage(placement);
}

void DooSabinSurface::take_cage(const Placement& placement) {
  placement_ = placement;
  RawVector<glm::dvec3> unit(used_.mesh.positions.size());
  parallel_each(unit.size(), 1 << 14,
                [&](std::size_t v) { unit[v] = placement_.to_unit(used_.mesh.positions[v]); });
  own_state_ = first_step(patches_, weights_, unit);
  state_ = own_state_;
}

DooSabinSurface::DooSabinSurface(const PolygonMesh& mesh, const LevelOne& level_one,
                                 const EvaluateOptions& options)
    : DooSabinSurface(mesh, options, Begin{}) {
  require_state_size(patches_.state_size(), level_one);
  placement_ = level_one.placement;
  if (patches_.has_sums()) own_state_ = patches_.with_sums(level_one.state);
  state_ = patches_.has_sums() ? std::span<const glm::dvec3>(own_state_) : level_one.state;
}

DooSabinSurface::DooSabinSurface(const PolygonMesh& mesh, const Placement& placement,
                                 std::span<const glm::dvec3> unit_cage,
                                 std::span<const glm::dvec3> state, const EvaluateOptions& options)
    : DooSabinSurface(mesh, options, Begin{}) {
  placement_ = placement;
  own_state_ =
      state.empty() ? first_step(patches_, weights_, unit_cage) : patches_.with_sums(state);
  state_ = own_state_;
}

const CornerUvs& DooSabinSurface::corner_uvs() const {
  std::call_once(has_corner_uvs_,
                 [&] { corner_uvs_ = std::make_unique<const CornerUvs>(used_.mesh); });
  return *corner_uvs_;
}

ChartField<glm::dvec2> DooSabinSurface::uv_field_of(std::span<const glm::dvec2> values) const {
  return {patches_, state_, corner_uvs().indices, values, vertex_limits_};
}

template <class Field, class Make>
const Field& DooSabinSurface::made_once(std::unique_ptr<const Field>& field,
                                        const Make& make) const {
  // A thread that waits in here must not begin other work, which may ask for the field.
  if (!field) {
    oneapi::tbb::this_task_arena::isolate([&] { field = std::make_unique<const Field>(make()); });
  }
  return *field;
}

const ChartField<glm::dvec2>& DooSabinSurface::uv_field() const {
  const std::lock_guard lock(field_mutex_);
  return made_once(uv_field_, [&] { return uv_field_of(used_.mesh.uvs); });
}

const ChartField<glm::dvec4>& DooSabinSurface::color_field() const {
  const std::lock_guard lock(field_mutex_);
  return made_once(color_field_, [&] {
    return ChartField<glm::dvec4>(patches_, state_, used_.mesh.face_vertices, used_.mesh.colors,
                                  vertex_limits_, {}, colors_of_whole_);
  });
}

const ChartField<glm::dvec4>& DooSabinSurface::number_field(std::size_t four) const {
  const std::lock_guard lock(field_mutex_);
  NumberField& made = number_fields_[four];
  return made_once(made.field, [&] {
    const std::span<const VertexAttribute> all = used_.mesh.attributes;
    made.values = four_of(all, four);
    std::array<int, 4> attributes{};
    for (std::size_t index = 0; index < all.size(); ++index)
      for (const NumberRun& run : runs_of(all, index))
        if (run.four == four)
          std::fill_n(attributes.begin() + run.lane, run.count, static_cast<int>(index));
    return ChartField<glm::dvec4>(patches_, state_, used_.mesh.face_vertices, made.values,
                                  vertex_limits_, attributes);
  });
}

void DooSabinSurface::require(LastLevel what, int level, std::uint64_t limit_bytes,
                              bool has_evaluator) const {
  require_level(level);
  const std::vector<LevelCounts> counts =
      split_counts({topology().vertex_count(), topology().edge_count(), topology().face_count()},
                   topology().corner_count(), level);
  RefinedAttributes attributes = RefinedAttributes::of(used_.mesh);
  attributes.device_rows = has_evaluator;
  require_memory(counts, what, attributes, limit_bytes);
}

void DooSabinSurface::require_whole(int level, std::uint64_t memory_limit_bytes,
                                    const PatchEvaluator* evaluator) const {
  require(LastLevel::None, level, memory_limit_bytes, evaluator != nullptr);
}

std::unique_ptr<SurfaceBlocks> DooSabinSurface::level(int level, std::uint64_t memory_limit_bytes,
                                                      PatchEvaluator* evaluator) const {
  require(LastLevel::Blocks, level, memory_limit_bytes, evaluator != nullptr);
  return std::make_unique<DooSabinBlocks>(*this, level, evaluator);
}

}  // namespace planish
