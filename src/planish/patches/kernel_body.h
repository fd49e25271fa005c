// The patch kernel at the width of kernel_lanes.h. Each lane computes what it would alone, by
// additions, multiplications, divisions and roots that are rounded one by one: the same bits at
// every width (the flags forbid fused ones).
#pragma once

#include "planish/patches/kernel_lanes.h"
#include "planish/patches/patch_kernel.h"

namespace planish {
namespace {

PLANISH_INLINE Vector dot(const Vector (&a)[3], const Vector (&b)[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Unit vectors along du x dv, zero where |du x dv| < 1e-6 |du||dv| (kDegenerateNormal): there the
// result is 0, elsewhere all bits are set.
PLANISH_INLINE Mask unit_normals(const Vector (&du)[3], const Vector (&dv)[3],
                                 Vector (&normal)[3]) {
  const Vector n[3] = {du[1] * dv[2] - du[2] * dv[1], du[2] * dv[0] - du[0] * dv[2],
                       du[0] * dv[1] - du[1] * dv[0]};
  const Vector square = dot(n, n), bound = 1e-12 * (dot(du, du) * dot(dv, dv));
  const Mask keep = (square >= bound) & (square > Vector{});
  const Vector inverse = (Vector)((Mask)(1.0 / square_root(square)) & keep);
  for (int d = 0; d < 3; ++d) normal[d] = n[d] * inverse;
  return keep;
}

// Column and sample counts above 0 are known when compiling.
template <int kColumns, int kSamples>
PLANISH_INLINE bool run_lanes(const PatchBatch& batch, const PatchOutput& output, int lane) {
  const int column_count = kColumns > 0 ? kColumns : batch.column_count;
  const int sample_count = kSamples > 0 ? kSamples : batch.sample_count;
  const std::int32_t* indices = batch.indices + lane;
  const std::int32_t* targets = batch.targets + lane;
  Vector own[3];
  load_points(batch.state, indices, own[0], own[1], own[2]);
  Vector* points = reinterpret_cast<Vector*>(batch.points);
  for (int k = 0; k < column_count; ++k) {
    Vector p[3];
    load_points(batch.state, indices + (k + 1) * kPatchLanes, p[0], p[1], p[2]);
    for (int d = 0; d < 3; ++d) points[d * column_count + k] = p[d] - own[d];
  }
  const double* weights = batch.weights;
  // Rows that nobody takes are not made.
  const bool takes_positions = output.positions != nullptr || output.stored != nullptr;
  const bool takes_normals = output.normals != nullptr;
  const bool wanted[3] = {takes_positions, takes_normals, takes_normals};
  Mask kept = ~Mask{};
  Vector sums[kSamples > 0 ? kSamples : 1][3][3];  // of a row, of a coordinate
  const auto add_up = [&](const double* rows, Vector(&sum)[3][3], const Vector* x, int d)
                          PLANISH_INLINE_LAMBDA {
#pragma GCC unroll 3
                            for (int r = 0; r < 3; ++r) {
                              if (!wanted[r]) continue;
                              Vector total{};
#pragma GCC unroll 12
                              for (int k = 0; k < column_count; ++k)
                                total += rows[r * column_count + k] * x[k];
                              sum[r][d] = total;
                            }
                          };
  if constexpr (kSamples > 0) {
    // A coordinate at a time: its points stay in registers.
#pragma GCC unroll 3
    for (int d = 0; d < 3; ++d) {
      Vector x[kColumns];
      for (int k = 0; k < kColumns; ++k) x[k] = points[d * column_count + k];
#pragma GCC unroll 3
      for (int s = 0; s < kSamples; ++s) add_up(weights + s * 3 * column_count, sums[s], x, d);
    }
  }
  for (int s = 0; s < sample_count; ++s, weights += 3 * column_count) {
    if constexpr (kSamples == 0) {
      for (int d = 0; d < 3; ++d) add_up(weights, sums[0], points + d * column_count, d);
    }
    const auto& sum = sums[kSamples > 0 ? s : 0];
    Vector position[3];
    const auto &du = sum[1], &dv = sum[2];
    for (int d = 0; wanted[0] && d < 3; ++d) {
      position[d] = output.centre[d] + output.diagonal * (sum[0][d] + own[d]);
    }
    if (output.positions) store_doubles(output.positions, targets, s, position);
    if (output.stored) {
      const Vector stored[3] = {position[0] - output.origin[0], position[1] - output.origin[1],
                                position[2] - output.origin[2]};
      store_floats(output.stored, targets, s, stored);
    }
    if (output.normals) {
      Vector normal[3];
      kept &= unit_normals(du, dv, normal);
      store_floats(output.normals, targets, s, normal);
    }
  }
  bool degenerate = false;
  for (int l = 0; l < kLanes; ++l) degenerate |= kept[l] == 0;
  return degenerate;
}

// The sizes that have code of their own: patches of 4 to 8 triangles around a vertex, or 4 quads;
// their own samples at level 2; limit points of 3 to 7 corners.
template <int kSamples, int kFirst, int... kMore>
PLANISH_INLINE bool run_known(const PatchBatch& batch, const PatchOutput& output, int lane) {
  if (batch.column_count == kFirst) return run_lanes<kFirst, kSamples>(batch, output, lane);
  if constexpr (sizeof...(kMore) > 0) {
    return run_known<kSamples, kMore...>(batch, output, lane);
  } else {
    return run_lanes<0, 0>(batch, output, lane);
  }
}

inline bool run_batch(const PatchBatch& batch, const PatchOutput& output) {
  bool degenerate = false;
  for (int lane = 0; lane < batch.lane_count; lane += kLanes) {
    if (batch.sample_count == 3) {
      degenerate |= run_known<3, 8, 9, 7, 10, 11>(batch, output, lane);
    } else if (batch.sample_count == 1) {
      degenerate |= run_known<1, 3, 5, 2, 4, 6>(batch, output, lane);
    } else {
      degenerate |= run_known<0, 8, 9, 7, 10>(batch, output, lane);
    }
  }
  return degenerate;
}

}  // namespace
}  // namespace planish
