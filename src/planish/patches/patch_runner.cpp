#include "planish/patches/patch_runner.h"

#include <vector>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/patches/face_kernel.h"

namespace planish {

namespace {

using Part = PatchNumbering::Part;

struct OpenBatch {
  std::int32_t lane_count = 0;
  bool is_open = false;             // by this run
  RawVector<std::int32_t> indices;  // kPatchLanes a column
  std::int32_t targets[kPatchLanes];
};

// Of a thread; all batches are empty between runs.
struct OpenBatches {
  std::vector<OpenBatch> of_class;
  std::vector<std::int32_t> open;
  std::vector<double> points;
};

OpenBatches& open_batches() {
  thread_local OpenBatches instance;
  return instance;
}

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

// Whether the weights that the kernel leaves out are zero.
bool fits_face_kernel(const PatchTemplate& weights) {
  constexpr std::int32_t kColumns = 8;
  if (weights.column_count != kColumns || weights.sample_count != kFaceSamples) return false;
  for (std::int32_t s = 0; s < kFaceSamples; ++s) {
    const std::span<const double> rows = weights.rows(s);
    for (std::int32_t i = 0; i < 3 * kColumns; ++i) {
      if ((kFaceSampleColumns[s] >> i % kColumns & 1) == 0 &&
          rows[static_cast<std::size_t>(i)] != 0)
        return false;
    }
  }
  return true;
}

// Adds the four patches of a quad, whose first corner is named, if all are regular. Returns whether
// they are.
template <class Run>
bool add_face(const PatchMesh& mesh, std::int32_t first, std::int32_t target, Run& run) {
  const MeshTopology& topology = mesh.topology();
  const auto next = [](std::int32_t corner) { return (corner & ~3) | ((corner + 1) & 3); };
  std::int32_t ring[4];
  for (std::int32_t i = 0; i < 4; ++i) {
    const std::int32_t vertex = topology.vertex_of(first + i);
    if (mesh.features().vertex_kinds[static_cast<std::size_t>(vertex)] != VertexKind::Smooth ||
        topology.corners_at(vertex).size() != 4)
      return false;
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
  return true;
}

}  // namespace

// One call: what is evaluated of each patch, and to where.
class PatchRunner::Run {
 public:
  Run(const PatchRunner& runner, const PatchOutput& output, const double* state,
      std::int32_t sample_count)
      : classes_(runner.classes_),
        face_index_(runner.classes_.count()),
        kernel_(runner.kernel_),
        face_kernel_(face_kernel(runner.kernel_)),
        output_(output),
        batches_(open_batches()) {
    const auto count = static_cast<std::size_t>(classes_.count()) + 1;  // and faces
    if (batches_.of_class.size() < count) batches_.of_class.resize(count);
    // 64-byte aligned.
    const std::size_t size =
        static_cast<std::size_t>(classes_.max_column_count()) * 3 * kPatchLanes;
    if (batches_.points.size() < size + 8) batches_.points.resize(size + 8);
    void* place = batches_.points.data();
    std::size_t space = batches_.points.size() * sizeof(double);
    batch_.points = static_cast<double*>(std::align(64, size * sizeof(double), place, space));
    batch_.state = state;
    batch_.sample_count = sample_count;
    // The kernel for quads knows the samples of level 2.
    const std::int32_t regular = classes_.smooth_index(4, 4);
    if (runner.quads_ && regular >= 0 && (sample_count == 3 || sample_count == 9) &&
        fits_face_kernel(classes_.weights(regular)))
      regular_index_ = regular;
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// Where the indices of a patch go, kPatchLanes apart.
  std::int32_t* lane(std::int32_t class_index, std::int32_t target) {
    if (class_index != last_index_) take(class_index);
    if (last_->lane_count == kPatchLanes) run(class_index, *last_);
    const std::int32_t lane = last_->lane_count++;
    last_->targets[lane] = target;
    return last_indices_ + lane;
  }
  /// Whether quads of regular patches are evaluated at once.
  [[nodiscard]] bool takes_faces() const { return regular_index_ >= 0; }
  /// The same for the four patches of a quad, kFaceColumns points.
  std::int32_t* face_lane(std::int32_t target) { return lane(face_index_, target); }
  /// Has a control point fetched by the time its batch is full.
  void fetch(std::int32_t index) const {
    __builtin_prefetch(batch_.state + 3 * static_cast<std::ptrdiff_t>(index));
  }

  /// Runs what is left. Returns whether a normal came out zero.
  bool finish() {
    for (const std::int32_t index : batches_.open) {
      OpenBatch& batch = batches_.of_class[static_cast<std::size_t>(index)];
      if (batch.lane_count > 0) run(index, batch);
      batch.is_open = false;
    }
    batches_.open.clear();
    return degenerate_;
  }

 private:
  void take(std::int32_t class_index) {
    OpenBatch& batch = batches_.of_class[static_cast<std::size_t>(class_index)];
    if (!batch.is_open) {
      batches_.open.push_back(class_index);
      batch.is_open = true;
      const std::int32_t columns =
          class_index == face_index_ ? kFaceColumns : classes_.patch(class_index).column_count();
      batch.indices.resize(static_cast<std::size_t>(columns) * kPatchLanes);
    }
    last_ = &batch;
    last_index_ = class_index;
    last_indices_ = batch.indices.data();
  }
  void run(std::int32_t class_index, OpenBatch& batch) {
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
    batch_.weights = weights.rows(0).data();
    batch_.column_count = weights.column_count;
    degenerate_ |= (is_face ? face_kernel_ : kernel_)(batch_, output_);
    batch.lane_count = 0;
  }

  const PatchClasses& classes_;
  std::int32_t face_index_;          // the batch of quads: behind those of classes
  std::int32_t regular_index_ = -1;  // the class of their patches
  PatchKernel kernel_, face_kernel_;
  const PatchOutput& output_;
  OpenBatches& batches_;
  PatchBatch batch_{};
  OpenBatch* last_ = nullptr;
  std::int32_t last_index_ = -1;
  std::int32_t* last_indices_ = nullptr;
  bool degenerate_ = false;
};

PatchRunner::PatchRunner(const PatchMesh& mesh, const PatchNumbering& numbering,
                         const PatchClasses& classes, PatchKernel kernel)
    : mesh_(mesh),
      topology_(mesh.topology()),
      numbering_(numbering),
      classes_(classes),
      kernel_(kernel),
      quads_(are_quads(topology_)) {}

bool PatchRunner::runs(Part part) const {
  if (part == Part::Corners) return !numbering_.has_hidden();
  return part == Part::Vertices || part == Part::Faces || part == Part::Edges;
}

void PatchRunner::add_place(const PatchPlace& place, std::int32_t target, Run& run) const {
  mesh_.gather(place, run.lane(classes_.index_of(place.patch), target), kPatchLanes);
}

// As PatchMesh::gather() does it, which has the cases that are rare.
template <bool kQuads>
void PatchRunner::add_corner(std::int32_t corner, std::int32_t target, Run& run) const {
  const std::int32_t vertex = topology_.vertex_of(corner);
  const auto around = topology_.corners_at(vertex);
  const std::int32_t first =
      kQuads ? corner & ~3 : topology_.first_corner(topology_.face_of(corner));
  const std::int32_t face_size = kQuads ? 4 : topology_.face_size(topology_.face_of(corner));
  const std::int32_t known =
      mesh_.features().vertex_kinds[static_cast<std::size_t>(vertex)] == VertexKind::Smooth
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
void PatchRunner::add_point(Part part, std::int64_t item, std::int32_t target, Run& run) const {
  const std::int32_t corner = numbering_.item_corner(part, item);
  if (part == Part::Vertices) {
    const std::int32_t vertex = topology_.vertex_of(corner);
    const auto around = topology_.corners_at(vertex);
    const std::int32_t known =
        mesh_.features().vertex_kinds[static_cast<std::size_t>(vertex)] == VertexKind::Smooth &&
                around.front() == corner
            ? classes_.smooth_index(static_cast<std::int32_t>(around.size()), 0)
            : -1;
    if (known < 0) return add_place(mesh_.vertex_point(corner), target, run);
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
void PatchRunner::add_tile(const PatchTile& tile, Run& run) const {
  const std::int64_t end = tile.first_item + tile.item_count;
  const std::int32_t rows = tile.part == Part::Corners ? numbering_.samples().owned_count() : 1;
  std::int32_t row = 0;
  for (std::int64_t i = tile.first_item; i < end; ++i, row += rows) {
    if (tile.part == Part::Corners) {
      if (run.takes_faces() && i % 4 == 0 && i + 4 <= end &&
          add_face(mesh_, static_cast<std::int32_t>(i), row, run)) {
        i += 3, row += 3 * rows;
        continue;
      }
      add_corner<kQuads>(static_cast<std::int32_t>(i), row, run);
    } else {
      add_point<kQuads>(tile.part, i, row, run);
    }
  }
}

bool PatchRunner::run_tile(const PatchTile& tile, const PatchOutput& output,
                           const double* state) const {
  Run run(*this, output, state,
          tile.part == Part::Corners ? numbering_.samples().owned_count() : 1);
  quads_ ? add_tile<true>(tile, run) : add_tile<false>(tile, run);
  return run.finish();
}

bool PatchRunner::run_grids(std::span<const std::int32_t> corners, const PatchOutput& output,
                            const double* state) const {
  const std::int32_t count = numbering_.samples().count();
  Run run(*this, output, state, count);
  std::int32_t target = 0;
  const auto has_face_at = [&](std::size_t i) {
    if (corners[i] % 4 != 0 || i + 4 > corners.size()) return false;
    for (std::int32_t k = 1; k < 4; ++k)
      if (corners[i + static_cast<std::size_t>(k)] != corners[i] + k) return false;
    return true;
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::int32_t corner = corners[i];
    if (run.takes_faces() && has_face_at(i) && add_face(mesh_, corner, target, run)) {
      i += 3, target += 4 * count;
      continue;
    }
    quads_ ? add_corner<true>(corner, target, run) : add_corner<false>(corner, target, run);
    target += count;
  }
  return run.finish();
}

bool PatchRunner::run_points(std::span<const std::int32_t> rows, const PatchOutput& output,
                             const double* state) const {
  Run run(*this, output, state, 1);
  const std::int64_t faces = numbering_.first_row(Part::Faces),
                     edges = numbering_.first_row(Part::Edges),
                     corners = numbering_.first_row(Part::Corners),
                     further = numbering_.first_row(Part::Further);
  bool has_further = false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::int32_t row = rows[i];
    if (row >= corners) {
      has_further = true;
      continue;
    }
    const Part part = row < faces ? Part::Vertices : row < edges ? Part::Faces : Part::Edges;
    const auto target = static_cast<std::int32_t>(i);
    quads_ ? add_point<true>(part, row - numbering_.first_row(part), target, run)
           : add_point<false>(part, row - numbering_.first_row(part), target, run);
  }
  bool degenerate = run.finish();
  if (!has_further) return degenerate;
  // The further side of a cut has its normal, and the first side's position.
  for (const bool normals : {true, false}) {
    PatchOutput part = output;
    if (normals) part.positions = nullptr, part.stored = nullptr;
    if (!normals) part.normals = nullptr;
    Run side(*this, part, state, 1);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i] < corners) continue;
      const std::int64_t item = rows[i] - further;
      const std::int32_t corner =
          normals ? numbering_.item_corner(Part::Further, item) : numbering_.further_first(item);
      add_place(
          numbering_.is_further_edge(item) ? mesh_.edge_point(corner) : mesh_.vertex_point(corner),
          static_cast<std::int32_t>(i), side);
    }
    degenerate |= side.finish();
  }
  return degenerate;
}

}  // namespace planish
