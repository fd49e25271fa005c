#include <algorithm>
#include <bit>
#include <span>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/core/work.h"
#include "planish/patches/face_kernel.h"
#include "planish/patches/patch_batches.h"
#include "planish/patches/patch_kernel.h"
#include "planish/patches/patch_surface.h"

namespace planish {

bool can_run(PatchInstructions instructions) {
#ifdef PLANISH_X86_KERNELS
  if (instructions == PatchInstructions::Avx2) return __builtin_cpu_supports("avx2") != 0;
#endif
  return instructions == PatchInstructions::Baseline;
}

PatchKernel patch_kernel(PatchInstructions instructions) {
#ifdef PLANISH_X86_KERNELS
  if (instructions == PatchInstructions::Avx2) return run_patches_avx2;
#endif
  (void)instructions;
  return run_patches_baseline;
}

FaceKernel face_kernel(PatchKernel kernel) {
#ifdef PLANISH_X86_KERNELS
  if (kernel == run_patches_avx2) return run_faces_avx2;
#endif
  (void)kernel;
  return run_faces_baseline;
}

PatchInstructions best_instructions() {
  return can_run(PatchInstructions::Avx2) ? PatchInstructions::Avx2 : PatchInstructions::Baseline;
}

// Where the weights that the kernel leaves out are zero.
bool takes_whole_faces(const PatchClasses& classes, std::int32_t sample_count) {
  constexpr std::int32_t kColumns = 8, kOwnSamples = 3;
  const std::int32_t regular = classes.smooth_index(4, 4);
  if (regular < 0 || (sample_count != kOwnSamples && sample_count != kFaceSamples)) return false;
  const PatchTemplate& weights = classes.weights(regular);
  if (weights.column_count != kColumns || weights.sample_count != kFaceSamples) return false;
  for (std::int32_t s = 0; s < kFaceSamples; ++s) {
    const std::span<const double> rows = weights.rows(s);
    for (std::int32_t i = 0; i < 3 * kColumns; ++i) {
      if ((kFaceSampleColumns[s] >> i % kColumns & 1) == 0 && rows[i] != 0) return false;
    }
  }
  return true;
}

PatchBatches::Open& PatchBatches::open_of_thread() {
  thread_local Open instance;
  return instance;
}

PatchBatches::PatchBatches(const PatchClasses& classes, PatchKernel kernel, bool all_quads,
                           std::int32_t sample_count, const PatchOutput& output,
                           const double* state, PointRows* points, std::int32_t first_sample)
    : classes_(classes),
      face_index_(classes.count()),
      first_sample_(first_sample),
      kernel_(kernel),
      face_kernel_(face_kernel(kernel)),
      output_(output),
      points_(points),
      open_(open_of_thread()) {
  const auto count = static_cast<std::size_t>(classes_.count()) + 1;  // and faces
  if (open_.of_class.size() < count) open_.of_class.resize(count);
  // 64-byte aligned.
  const std::size_t size = static_cast<std::size_t>(classes_.max_column_count()) * 3 * kPatchLanes;
  if (open_.points.size() < size + 8) open_.points.resize(size + 8);
  void* place = open_.points.data();
  std::size_t space = open_.points.size() * sizeof(double);
  batch_.points = static_cast<double*>(std::align(64, size * sizeof(double), place, space));
  batch_.state = state;
  batch_.sample_count = sample_count;
  if (all_quads && takes_whole_faces(classes_, sample_count))
    regular_index_ = classes_.smooth_index(4, 4);
  if (points_ == nullptr) return;
  batch_.point_weights = classes_.weights(classes_.smooth_index(4, 0)).rows(0).data();
  batch_.point_positions = open_.point_positions;
  batch_.point_normals = open_.point_normals;
}

void PatchBatches::take(std::int32_t class_index) {
  OpenBatch& batch = open_.of_class[class_index];
  if (!batch.is_open) {
    const std::int32_t columns =
        class_index == face_index_ ? kFaceColumns : classes_.patch(class_index).column_count();
    batch.indices.resize(static_cast<std::size_t>(columns) * kPatchLanes);
    open_.open.push_back(class_index);
    batch.is_open = true;
  }
  last_ = &batch;
  last_index_ = class_index;
  last_indices_ = batch.indices.data();
}

void PatchBatches::run(std::int32_t class_index, OpenBatch& batch) {
  const bool is_face = class_index == face_index_;
  const PatchTemplate& weights = classes_.weights(is_face ? regular_index_ : class_index);
  // Idle lanes repeat the first.
  for (std::int32_t l = batch.lane_count; l < kPatchLanes; ++l) {
    for (std::size_t first = 0; first < batch.indices.size(); first += kPatchLanes)
      batch.indices[first + static_cast<std::size_t>(l)] = batch.indices[first];
    batch.targets[l] = batch.targets[0];
  }
  batch_.indices = batch.indices.data();
  batch_.targets = batch.targets;
  batch_.lane_count = batch.lane_count;
  batch_.weights = weights.rows(first_sample_).data();
  batch_.column_count = weights.column_count;
  products_ += std::int64_t{batch.lane_count} * weights.column_count * batch_.sample_count;
  degenerate_ |= is_face ? run_faces() : kernel_(batch_, output_);
  batch.lane_count = 0;
}

bool PatchBatches::run_faces() {
  batch_.wanted_points = 0;
  if (points_ == nullptr) return face_kernel_(batch_, output_);
  for (int l = 0; l < batch_.lane_count; ++l) batch_.wanted_points |= open_.wanted_points[l];
  const bool degenerate = face_kernel_(batch_, output_);
  for (int l = 0; l < batch_.lane_count; ++l) {
    for (unsigned left = open_.wanted_points[l]; left != 0; left &= left - 1) {
      const int at = std::countr_zero(left) * kPatchLanes + l;
      points_->add(open_.point_rows[at], open_.point_positions + 3 * at,
                   open_.point_normals + 3 * at);
    }
  }
  return degenerate;
}

bool PatchBatches::finish() {
  for (const std::int32_t index : open_.open) {
    OpenBatch& batch = open_.of_class[index];
    if (batch.lane_count > 0) run(index, batch);
  }
  open_.clear();
  count_work(Work::Products, products_);
  products_ = 0;
  return degenerate_;
}

void PatchBatches::Open::clear() {
  for (const std::int32_t index : open) {
    OpenBatch& batch = of_class[index];
    batch.is_open = false;
    batch.lane_count = 0;
  }
  open.clear();
}

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
