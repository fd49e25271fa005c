#include "planish/patches/patch_run.h"

#include <vector>

namespace planish {

namespace {

// Scratch of a batch, 64-byte aligned.
double* batch_points(std::int32_t column_count) {
  thread_local std::vector<double> points;
  const std::size_t size = static_cast<std::size_t>(column_count) * 3 * kPatchLanes + 8;
  if (points.size() < size) points.resize(size);
  void* place = points.data();
  std::size_t space = points.size() * sizeof(double);
  return static_cast<double*>(std::align(64, size * sizeof(double) - 64, place, space));
}

}  // namespace

void add_item(const PatchPlace& place, std::int32_t class_index, std::int32_t first_sample,
              std::int32_t sample_count, PatchPlan::Results results, std::int64_t target,
              PatchPlan& plan) {
  std::size_t b = plan.buckets.size();
  const auto matches = [&](const PatchPlan::Bucket& bucket) {
    return bucket.class_index == class_index && bucket.sample_count == sample_count &&
           bucket.first_sample == first_sample && bucket.results == results;
  };
  while (b > 0 && !matches(plan.buckets[b - 1])) --b;
  if (b == 0) {
    plan.buckets.push_back({class_index, first_sample, sample_count, results, 0, 0, 0});
    b = plan.buckets.size();
  }
  ++plan.buckets[b - 1].item_count;
  plan.items.push_back(
      {place, static_cast<std::int32_t>(b - 1), static_cast<std::int32_t>(target)});
}

void gather_items(const PatchMesh& mesh, const PatchClasses& classes, PatchPlan& plan) {
  std::size_t index = 0, target = 0;
  for (PatchPlan::Bucket& bucket : plan.buckets) {
    bucket.first_index = index;
    bucket.first_target = target;
    const auto batches =
        static_cast<std::size_t>((bucket.item_count + kPatchLanes - 1) / kPatchLanes);
    const auto columns = static_cast<std::size_t>(classes.patch(bucket.class_index).column_count());
    index += batches * kPatchLanes * columns;
    target += batches * kPatchLanes;
    bucket.item_count = 0;
  }
  plan.indices.resize(index);
  plan.targets.resize(target);
  for (const PatchPlan::Item& item : plan.items) {
    PatchPlan::Bucket& bucket = plan.buckets[item.bucket];
    const std::int32_t u = bucket.item_count++;
    const auto columns = static_cast<std::size_t>(classes.patch(bucket.class_index).column_count());
    const auto batch = static_cast<std::size_t>(u / kPatchLanes);
    std::int32_t* indices =
        plan.indices.data() + bucket.first_index + batch * columns * kPatchLanes + u % kPatchLanes;
    mesh.gather(item.place, indices, kPatchLanes);
    plan.targets[bucket.first_target + u] = item.target;
  }
  // The last batch's idle lanes repeat its first.
  for (const PatchPlan::Bucket& bucket : plan.buckets) {
    const std::int32_t used = bucket.item_count % kPatchLanes;
    if (used == 0) continue;
    const auto batch = static_cast<std::size_t>(bucket.item_count / kPatchLanes);
    const auto columns = static_cast<std::size_t>(classes.patch(bucket.class_index).column_count());
    std::int32_t* indices =
        plan.indices.data() + bucket.first_index + batch * columns * kPatchLanes;
    std::int32_t* targets = plan.targets.data() + bucket.first_target + batch * kPatchLanes;
    for (std::int32_t l = used; l < kPatchLanes; ++l) {
      for (std::size_t k = 0; k < columns; ++k) {
        indices[k * kPatchLanes + l] = indices[k * kPatchLanes];
      }
      targets[l] = targets[0];
    }
  }
}

PatchOutput output_at(const Placement& placement, const PatchTarget& target,
                      std::ptrdiff_t offset) {
  PatchOutput output;
  for (int d = 0; d < 3; ++d) {
    output.centre[d] = placement.centre[d];
    output.origin[d] = target.origin[d];
  }
  output.diagonal = placement.diagonal;
  if (!target.positions.empty()) output.positions = &target.positions[0].x + 3 * offset;
  if (!target.stored.empty()) output.stored = &target.stored[0].x + 3 * offset;
  if (!target.normals.empty()) output.normals = &target.normals[0].x + 3 * offset;
  return output;
}

bool run_plan(const PatchClasses& classes, PatchKernel kernel, const PatchPlan& plan,
              const PatchOutput& output, const double* state) {
  bool degenerate = false;
  for (const PatchPlan::Bucket& bucket : plan.buckets) {
    const PatchTemplate& weights = classes.weights(bucket.class_index);
    PatchOutput out = output;
    if (bucket.results == PatchPlan::Results::Normals)
      out.positions = nullptr, out.stored = nullptr;
    if (bucket.results == PatchPlan::Results::Positions) out.normals = nullptr;
    PatchBatch batch;
    batch.state = state;
    batch.weights = weights.rows(bucket.first_sample).data();
    batch.column_count = weights.column_count;
    batch.sample_count = bucket.sample_count;
    batch.points = batch_points(weights.column_count);
    batch.indices = plan.indices.data() + bucket.first_index;
    batch.targets = plan.targets.data() + bucket.first_target;
    for (std::int32_t first = 0; first < bucket.item_count; first += kPatchLanes) {
      batch.lane_count = std::min(bucket.item_count - first, kPatchLanes);
      degenerate |= kernel(batch, out);
      batch.indices += static_cast<std::ptrdiff_t>(weights.column_count + 1) * kPatchLanes;
      batch.targets += kPatchLanes;
    }
  }
  return degenerate;
}

}  // namespace planish
