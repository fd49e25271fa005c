// Corner patches are local: that of corner c of face f takes control points of the faces around c's
// vertex alone (patches/README.md).
#include "planish/edit/edited_surface.h"

#include <algorithm>

#include "planish/core/parallel.h"
#include "planish/patches/first_step.h"

namespace planish {

namespace {

// Rows that a thread takes at least.
constexpr std::size_t kRowGrain = 1 << 13;

// `surface`, of which no row is numbered before it is known that there is such a level, and room.
const DooSabinSurface& required(const DooSabinSurface& surface, const EvaluateOptions& options) {
  surface.require_whole(options.level, options.memory_limit_bytes, nullptr);
  return surface;
}

}  // namespace

EditedSurface::EditedSurface(const PolygonMesh& mesh, const Placement& placement,
                             std::span<const glm::dvec3> cage, std::span<const glm::dvec3> state,
                             const EvaluateOptions& options)
    : surface_(std::make_shared<DooSabinSurface>(mesh, placement, cage, state, options)),
      patches_(required(*surface_, options).patches(),
               {options.level, options.weights, surface_->hidden()}),
      weights_(options.weights),
      touched_(surface_->topology().face_count()),
      around_(surface_->topology().face_count()) {
  const auto count = static_cast<std::size_t>(patches_.numbering().row_count());
  positions_.resize(count);
  normals_.resize(count);
  make_all_rows();
}

void EditedSurface::make_all_rows() {
  const std::span<const PatchTile> tiles = patches_.tiles();
  parallel_each(tiles.size(), 1, [&](std::size_t t) {
    const auto first = static_cast<std::size_t>(tiles[t].first_row);
    const auto count = static_cast<std::size_t>(tiles[t].row_count);
    PatchTarget target;
    target.positions = std::span(positions_).subspan(first, count);
    target.normals = std::span(normals_).subspan(first, count);
    (void)patches_.rows(surface_->state(), surface_->placement(),
                        {tiles[t].first_row, tiles[t].row_count}, target);
  });
  ranges_.assign(1, {0, static_cast<std::int64_t>(positions_.size())});
  corners_.clear();
  const std::int32_t count = surface_->topology().corner_count();
  for (std::int32_t c = 0; c < count; ++c) corners_.push_back(c);
}

void EditedSurface::touch_faces_at(std::int32_t vertex) {
  const MeshTopology& topology = surface_->topology();
  for (const std::int32_t corner : topology.corners_at(vertex))
    touched_.add(topology.face_of(corner));
}

void EditedSurface::list_faces_around() {
  const MeshTopology& topology = surface_->topology();
  around_.clear();
  for (const std::int32_t face : touched_.members()) {
    for (const std::int32_t vertex : topology.face(face))
      for (const std::int32_t corner : topology.corners_at(vertex))
        around_.add(topology.face_of(corner));
  }
  faces_.assign(around_.members().begin(), around_.members().end());
  std::ranges::sort(faces_);
  corners_.clear();
  for (const std::int32_t face : faces_) {
    if (patches_.numbering().is_hidden(face)) continue;
    for (std::int32_t c = topology.first_corner(face); c < topology.first_corner(face + 1); ++c)
      corners_.push_back(c);
  }
}

// Parts of the numbering follow one another; faces come in order, so only rows of vertices and
// edges are to be sorted, of which there are few.
void EditedSurface::list_rows() {
  const PatchNumbering& numbering = patches_.numbering();
  const MeshTopology& topology = surface_->topology();
  const PatchMesh& mesh = surface_->patches();
  rows_.clear();
  points_.clear();
  const bool has_level = numbering.level() > 0;
  const int side = numbering.samples().side();
  const bool has_cuts = mesh.features().sharp_edge_count > 0 || numbering.has_hidden();
  for (const std::int32_t c : corners_) {
    points_.push_back(numbering.vertex_row(c));
    if (!has_level) continue;
    points_.push_back(numbering.edge_row(c));
    // Those of its trailing edge are another corner's, but at a cut.
    for (int i = 1; i < side && has_cuts; ++i) points_.push_back(numbering.row(c, 0, i));
    if (topology.place_of(c) == 0) points_.push_back(numbering.face_row(topology.face_of(c)));
    const auto first = static_cast<std::int32_t>(numbering.corner_row(c));
    for (std::int32_t i = 0; i < numbering.corner_row_count(c); ++i) rows_.push_back(first + i);
  }
  std::ranges::sort(points_);
  points_.erase(std::ranges::unique(points_).begin(), points_.end());
  const std::size_t count = rows_.size();
  rows_.insert(rows_.end(), points_.begin(), points_.end());
  std::inplace_merge(rows_.begin(), rows_.begin() + static_cast<std::ptrdiff_t>(count),
                     rows_.end());
  if (has_cuts) rows_.erase(std::ranges::unique(rows_).begin(), rows_.end());
  ranges_.clear();
  for (const std::int32_t row : rows_) {
    if (ranges_.empty() || ranges_.back().first + ranges_.back().count != row)
      ranges_.push_back({row, 0});
    ++ranges_.back().count;
  }
}

void EditedSurface::make_rows() {
  parallel_for(rows_.size(), kRowGrain, [&](std::size_t begin, std::size_t end) {
    thread_local std::vector<glm::dvec3> positions;
    thread_local std::vector<glm::vec3> normals;
    const auto rows = std::span<const std::int32_t>(rows_).subspan(begin, end - begin);
    positions.resize(rows.size());
    normals.resize(rows.size());
    PatchTarget target;
    target.positions = positions;
    target.normals = normals;
    (void)patches_.rows_at(surface_->state(), surface_->placement(), rows, target);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      positions_[rows[i]] = positions[i];
      normals_[rows[i]] = normals[i];
    }
  });
}

// After touched_ has the faces whose points of level 1 are others.
void EditedSurface::follow_touched() {
  list_faces_around();
  surface_->patches().update_sums_at(corners_, surface_->own_state());
  list_rows();
  make_rows();
}

void EditedSurface::update(std::span<const std::int32_t> vertices,
                           std::span<const glm::dvec3> cage) {
  touched_.clear();
  for (const std::int32_t vertex : vertices) touch_faces_at(vertex);
  update_first_step(surface_->patches(), weights_, cage, touched_.members(), surface_->own_state());
  follow_touched();
}

void EditedSurface::update_all(std::span<const glm::dvec3> cage) {
  const RawVector<glm::dvec3> state = first_step(surface_->patches(), weights_.weights(), cage);
  std::ranges::copy(state, surface_->own_state().begin());
  make_all_rows();
}

void EditedSurface::add_to_state(std::span<const std::int32_t> places,
                                 std::span<const glm::dvec3> differences) {
  const MeshTopology& topology = surface_->topology();
  const std::int32_t corner_count = surface_->patches().first_sharp();
  touched_.clear();
  for (std::size_t i = 0; i < places.size(); ++i) {
    surface_->own_state()[places[i]] += differences[i];
    if (places[i] < corner_count) touched_.add(topology.face_of(places[i]));
  }
  follow_touched();
}

void EditedSurface::set_state_all(std::span<const glm::dvec3> state) {
  std::ranges::copy(state, surface_->own_state().begin());
  surface_->patches().update_sums(surface_->own_state());
  make_all_rows();
}

}  // namespace planish
