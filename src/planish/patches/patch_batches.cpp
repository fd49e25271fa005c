#include "planish/patches/patch_batches.h"

#include <bit>
#include <span>

#include "planish/core/work.h"

namespace planish {

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

}  // namespace planish
