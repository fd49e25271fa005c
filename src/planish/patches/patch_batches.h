#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/patches/face_kernel.h"
#include "planish/patches/patch_kernel.h"
#include "planish/patches/patch_plan.h"
#include "planish/patches/patch_surface.h"

namespace planish {

/// Whether quads of four regular patches can be evaluated at once: the samples of level 2, own ones
/// (3) or all (9).
[[nodiscard]] bool takes_whole_faces(const PatchClasses& classes, std::int32_t sample_count);

/// Batches of patches by class that run as soon as they are full: what is evaluated of each patch,
/// and to where. One at a time on a thread.
class PatchBatches {
 public:
  /// `all_quads`: the mesh's faces are. With `points` whole faces make limit points along. All of
  /// it must outlive the batches.
  PatchBatches(const PatchClasses& classes, PatchKernel kernel, bool all_quads,
               std::int32_t sample_count, const PatchOutput& output, const double* state,
               PointRows* points = nullptr, std::int32_t first_sample = 0);
  /// What was not run is dropped: after an exception the next batches of the thread begin empty.
  ~PatchBatches() { open_.clear(); }
  PatchBatches(const PatchBatches&) = delete;
  PatchBatches& operator=(const PatchBatches&) = delete;

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
  std::int32_t* face_lane(std::int32_t target) {
    std::int32_t* const to = lane(face_index_, target);
    face_ = last_->lane_count - 1;
    open_.wanted_points[face_] = 0;
    return to;
  }
  [[nodiscard]] bool makes_points() const { return points_ != nullptr; }
  /// A limit point of the quad that was added last, see kFacePoints, and the row that it is.
  void face_point(int point, std::int32_t row) {
    open_.wanted_points[face_] |= 1U << point;
    open_.point_rows[point * kPatchLanes + face_] = row;
  }
  /// Has a control point fetched by the time its batch is full.
  void fetch(std::int32_t index) const {
    __builtin_prefetch(batch_.state + 3 * static_cast<std::ptrdiff_t>(index));
  }

  /// Runs what is left. Returns whether a normal came out zero.
  bool finish();

 private:
  struct OpenBatch {
    std::int32_t lane_count = 0;
    bool is_open = false;             // by these batches
    RawVector<std::int32_t> indices;  // kPatchLanes a column
    std::int32_t targets[kPatchLanes];
  };
  // Of a thread; all batches are empty between runs.
  struct Open {
    std::vector<OpenBatch> of_class;
    std::vector<std::int32_t> open;
    std::vector<double> points;
    unsigned wanted_points[kPatchLanes];  // of each quad, as in FaceBatch
    std::int32_t point_rows[kFacePoints * kPatchLanes];
    double point_positions[3 * kFacePoints * kPatchLanes];
    float point_normals[3 * kFacePoints * kPatchLanes];

    void clear();
  };
  static Open& open_of_thread();
  void take(std::int32_t class_index);
  void run(std::int32_t class_index, OpenBatch& batch);
  bool run_faces();

  const PatchClasses& classes_;
  std::int32_t face_index_;          // the batch of quads: behind those of classes
  std::int32_t regular_index_ = -1;  // the class of their patches
  std::int32_t first_sample_;
  PatchKernel kernel_;
  FaceKernel face_kernel_;
  const PatchOutput& output_;
  PointRows* points_;
  Open& open_;
  FaceBatch batch_{};
  OpenBatch* last_ = nullptr;
  std::int32_t last_index_ = -1;
  std::int32_t* last_indices_ = nullptr;
  std::int32_t face_ = 0;      // the last quad's lane
  std::int64_t products_ = 0;  // since the last finish()
  bool degenerate_ = false;
};

}  // namespace planish
