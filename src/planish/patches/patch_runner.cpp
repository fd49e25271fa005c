#include "planish/patches/patch_runner.h"

#include <algorithm>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/patches/patch_batches.h"

namespace planish {

namespace {

using Part = PatchNumbering::Part;

bool are_quads(const MeshTopology& topology) {
  const std::span<const std::int32_t> offsets = topology.face_offsets();
  for (std::size_t f = 0; f < offsets.size(); ++f)
    if (offsets[f] != static_cast<std::int32_t>(4 * f)) return false;
  return true;
}

template <bool kQuads>
std::int32_t next_of(const MeshTopology& topology, std::int32_t corner) {
  return kQuads ? (corner & ~3) | ((corner + 1) & 3) : topology.next(corner);
}

// The corners of a face behind one of its own.
void put_face(std::int32_t first, std::int32_t size, std::int32_t corner, std::int32_t*& to) {
  for (std::int32_t c = corner + 1; c < first + size; ++c, to += kPatchLanes) *to = c;
  for (std::int32_t c = first; c < corner; ++c, to += kPatchLanes) *to = c;
}

// Adds the four patches of a quad, whose first corner is named, if all are regular, and the limit
// points whose rows its corners stand for. Returns whether they are.
bool add_face(const PatchMesh& mesh, const PatchNumbering& numbering, std::int32_t first,
              std::int32_t target, PatchBatches& run) {
  const MeshTopology& topology = mesh.topology();
  const auto next = [](std::int32_t corner) { return (corner & ~3) | ((corner + 1) & 3); };
  std::int32_t ring[4];
  unsigned own_vertices = 0;
  for (std::int32_t i = 0; i < 4; ++i) {
    const std::int32_t vertex = topology.vertex_of(first + i);
    const auto around = topology.corners_at(vertex);
    if (mesh.features().vertex_kinds[vertex] != VertexKind::Smooth || around.size() != 4)
      return false;
    if (around.front() == first + i) own_vertices |= 1U << i;
    ring[i] = topology.twin(first + i);
    run.fetch(ring[i]);
  }
  std::int32_t* to = run.face_lane(target);
  for (std::int32_t i = 0; i < 4; ++i, to += kPatchLanes) {
    const std::int32_t behind = next(ring[i]), across = next(topology.twin(behind));
    run.fetch(across);
    to[0] = first + i;
    to[4 * kPatchLanes] = ring[i];
    to[8 * kPatchLanes] = behind;
    to[12 * kPatchLanes] = across;
  }
  if (!run.makes_points()) return true;
  for (std::int32_t i = 0; i < 4; ++i) {
    if ((own_vertices >> i & 1) != 0) run.face_point(i, numbering.vertex_row(first + i));
    if (first + i < ring[i]) run.face_point(4 + i, numbering.edge_row(first + i));
  }
  run.face_point(8, numbering.face_row(first / 4));
  return true;
}

// The same of a corner by itself: rows of which it is the item.
void list_points(const MeshTopology& topology, const PatchNumbering& numbering, std::int32_t corner,
                 RawVector<std::int32_t>& rows) {
  const auto stands_for = [&](Part part, std::int32_t row) {
    return row >= 0 && row < numbering.end_row(part) &&
           numbering.item_corner(part, row - numbering.first_row(part)) == corner;
  };
  const std::int32_t vertex = numbering.vertex_row(corner), edge = numbering.edge_row(corner);
  const std::int32_t face = topology.face_of(corner);
  if (stands_for(Part::Vertices, vertex)) rows.push_back(vertex);
  if (stands_for(Part::Edges, edge)) rows.push_back(edge);
  if (corner == topology.first_corner(face)) rows.push_back(numbering.face_row(face));
}

}  // namespace

PatchRunner::PatchRunner(const PatchMesh& mesh, const PatchNumbering& numbering,
                         const PatchClasses& classes, const PatchPlanner& planner,
                         PatchKernel kernel)
    : mesh_(mesh),
      topology_(mesh.topology()),
      numbering_(numbering),
      classes_(classes),
      planner_(planner),
      kernel_(kernel),
      quads_(are_quads(topology_)) {}

bool PatchRunner::runs_at_once(Part part) const {
  if (part == Part::Corners) return !numbering_.has_hidden();
  return part == Part::Vertices || part == Part::Faces || part == Part::Edges;
}

void PatchRunner::add_place(const PatchPlace& place, std::int32_t target, PatchBatches& run) const {
  mesh_.gather(place, run.lane(classes_.index_of(place.patch), target), kPatchLanes);
}

// As PatchMesh::gather() does it, which has the cases that are rare.
template <bool kQuads>
void PatchRunner::add_corner(std::int32_t corner, std::int32_t target, PatchBatches& run) const {
  const std::int32_t vertex = topology_.vertex_of(corner);
  const auto around = topology_.corners_at(vertex);
  const std::int32_t first =
      kQuads ? corner & ~3 : topology_.first_corner(topology_.face_of(corner));
  const std::int32_t face_size = kQuads ? 4 : topology_.face_size(topology_.face_of(corner));
  const std::int32_t known =
      mesh_.features().vertex_kinds[vertex] == VertexKind::Smooth
          ? classes_.smooth_index(static_cast<std::int32_t>(around.size()), face_size)
          : -1;
  if (known < 0) return add_place(mesh_.corner_patch(corner), target, run);
  std::int32_t* to = run.lane(known, target);
  const auto put = [&](std::int32_t index) {
    *to = index;
    to += kPatchLanes;
  };
  std::size_t place = 0;
  while (around[place] != corner) run.fetch(around[place++]);
  put(corner);
  for (std::size_t i = place + 1; i < around.size(); ++i) run.fetch(around[i]), put(around[i]);
  for (std::size_t i = 0; i < place; ++i) put(around[i]);
  put_face(first, face_size, corner, to);
  put(topology_.twin(corner));
  // The corner across the trailing edge is the next one around the vertex.
  put(next_of<kQuads>(topology_, around[place + 1 < around.size() ? place + 1 : 0]));
}

template <bool kQuads>
void PatchRunner::add_point(Part part, std::int64_t item, std::int32_t target,
                            PatchBatches& run) const {
  const std::int32_t corner = numbering_.item_corner(part, item);
  if (part == Part::Vertices) {
    const std::int32_t vertex = topology_.vertex_of(corner);
    const auto around = topology_.corners_at(vertex);
    const std::int32_t known =
        mesh_.features().vertex_kinds[vertex] == VertexKind::Smooth && around.front() == corner
            ? classes_.smooth_index(static_cast<std::int32_t>(around.size()), 0)
            : -1;
    if (known < 0) return add_place(mesh_.vertex_point(mesh_.sector_corner(corner)), target, run);
    std::int32_t* to = run.lane(known, target);
    for (const std::int32_t c : around) run.fetch(c), *to = c, to += kPatchLanes;
  } else if (part == Part::Faces) {
    const std::int32_t face = topology_.face_of(corner), size = topology_.face_size(face);
    const std::int32_t known = classes_.smooth_index(size, 0);
    if (known < 0) return add_place(mesh_.face_point(face), target, run);
    std::int32_t* to = run.lane(known, target);
    const std::int32_t first = topology_.first_corner(face);
    *to = first;
    put_face(first, size, first, to += kPatchLanes);
  } else {
    const std::int32_t known = mesh_.is_sharp(corner) ? -1 : classes_.smooth_index(4, 0);
    if (known < 0) return add_place(mesh_.edge_point(corner), target, run);
    std::int32_t* const to = run.lane(known, target);
    const std::int32_t other = topology_.twin(corner);
    run.fetch(corner);
    run.fetch(other);
    to[0] = next_of<kQuads>(topology_, corner);
    to[kPatchLanes] = corner;
    to[2 * kPatchLanes] = next_of<kQuads>(topology_, other);
    to[3 * kPatchLanes] = other;
  }
}

template <bool kQuads>
void PatchRunner::add_tile(const PatchTile& tile, PatchBatches& run) const {
  const std::int64_t end = tile.first_item + tile.item_count;
  const std::int32_t rows = tile.part == Part::Corners ? numbering_.samples().owned_count() : 1;
  std::int32_t row = 0;
  for (std::int64_t i = tile.first_item; i < end; ++i, row += rows) {
    if (tile.part == Part::Corners) {
      const auto corner = static_cast<std::int32_t>(i);
      if (run.takes_faces() && i % 4 == 0 && i + 4 <= end &&
          add_face(mesh_, numbering_, corner, row, run)) {
        i += 3, row += 3 * rows;
        continue;
      }
      add_corner<kQuads>(corner, row, run);
      if (run.makes_points()) list_points(topology_, numbering_, corner, further_points());
    } else {
      add_point<kQuads>(tile.part, i, row, run);
    }
  }
}

bool PatchRunner::run_tile(const PatchTile& tile, const PatchOutput& output, const double* state,
                           PointRows* points) const {
  if (!runs_at_once(tile.part)) {
    PatchPlan& plan = empty_plan();
    planner_.add(tile, 0, plan);
    return run_plan(plan, output, state);
  }
  begin_points(tile.item_count, points);
  PatchBatches run(classes_, kernel_, quads_,
                   tile.part == Part::Corners ? numbering_.samples().owned_count() : 1, output,
                   state, points);
  quads_ ? add_tile<true>(tile, run) : add_tile<false>(tile, run);
  const bool degenerate = run.finish();
  return finish_points(output, state, points) || degenerate;
}

bool PatchRunner::run_grids(std::span<const std::int32_t> corners, const PatchOutput& output,
                            const double* state, PointRows* points) const {
  const std::int32_t count = numbering_.samples().count();
  begin_points(std::ssize(corners), points);
  PatchBatches run(classes_, kernel_, quads_, count, output, state, points);
  std::int32_t target = 0;
  const auto has_face_at = [&](std::size_t i) {
    if (corners[i] % 4 != 0 || i + 4 > corners.size()) return false;
    for (std::int32_t k = 1; k < 4; ++k)
      if (corners[i + static_cast<std::size_t>(k)] != corners[i] + k) return false;
    return true;
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::int32_t corner = corners[i];
    if (run.takes_faces() && has_face_at(i) && add_face(mesh_, numbering_, corner, target, run)) {
      i += 3, target += 4 * count;
      continue;
    }
    quads_ ? add_corner<true>(corner, target, run) : add_corner<false>(corner, target, run);
    if (points != nullptr) list_points(topology_, numbering_, corner, further_points());
    target += count;
  }
  const bool degenerate = run.finish();
  return finish_points(output, state, points) || degenerate;
}

bool PatchRunner::makes_points() const {
  return quads_ && runs_at_once(Part::Corners) && classes_.smooth_index(4, 0) >= 0 &&
         takes_whole_faces(classes_, numbering_.samples().count());
}

// Of a thread: those of corners that are not evaluated by whole faces.
RawVector<std::int32_t>& PatchRunner::further_points() {
  thread_local RawVector<std::int32_t> rows;
  return rows;
}

void PatchRunner::begin_points(std::int64_t corner_count, PointRows* points) {
  if (points == nullptr) return;
  // A vertex and a midpoint a corner, a centre a face.
  points->reset(static_cast<std::size_t>(3 * corner_count));
  further_points().clear();
}

bool PatchRunner::finish_points(const PatchOutput& output, const double* state,
                                PointRows* points) const {
  if (points == nullptr || further_points().empty()) return false;
  const std::size_t first = points->size();
  for (const std::int32_t row : further_points()) points->add(row);
  PatchOutput further = output;
  further.positions = &points->positions()[first].x;
  further.normals = &points->normals()[first].x;
  further.stored = nullptr;
  return run_points(further_points(), further, state);
}

bool PatchRunner::run_points(std::span<const std::int32_t> rows, const PatchOutput& output,
                             const double* state) const {
  PatchBatches run(classes_, kernel_, quads_, 1, output, state);
  PatchPlan& further = empty_plan();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::int64_t row = rows[i];
    int number = 0;
    while (row >= numbering_.end_row(static_cast<Part>(number))) ++number;
    const auto part = static_cast<Part>(number);
    const std::int64_t item = row - numbering_.first_row(part);
    const auto target = static_cast<std::int32_t>(i);
    if (part == Part::Further) {
      planner_.add({part, item, 1, row, 1}, target, further);
    } else {
      quads_ ? add_point<true>(part, item, target, run) : add_point<false>(part, item, target, run);
    }
  }
  const bool degenerate = run.finish();
  return run_plan(further, output, state) || degenerate;
}

PatchPlan& PatchRunner::empty_plan() {
  thread_local PatchPlan plan;
  plan.clear();
  return plan;
}

bool PatchRunner::run_plan(const PatchPlan& plan, const PatchOutput& output,
                           const double* state) const {
  using Bucket = PatchPlan::Bucket;
  bool degenerate = false;
  for (auto bucket = plan.buckets.begin(); bucket != plan.buckets.end(); ++bucket) {
    const auto is_alike = [&](const Bucket& other) { return other.has_results_of(*bucket); };
    if (std::any_of(plan.buckets.begin(), bucket, is_alike)) continue;  // has run
    PatchOutput part = output;
    if (bucket->results == PatchPlan::Results::Normals)
      part.positions = nullptr, part.stored = nullptr;
    if (bucket->results == PatchPlan::Results::Positions) part.normals = nullptr;
    PatchBatches run(classes_, kernel_, false, bucket->sample_count, part, state, nullptr,
                     bucket->first_sample);
    for (const PatchPlan::Item& item : plan.items) {
      const Bucket& own = plan.buckets[item.bucket];
      if (!is_alike(own)) continue;
      mesh_.gather(item.place, run.lane(own.class_index, item.target), kPatchLanes);
    }
    degenerate |= run.finish();
  }
  return degenerate;
}

}  // namespace planish
