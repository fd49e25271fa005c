#pragma once

#include <cstdint>

#include "planish/patches/face_kernel.h"
#include "planish/patches/patch_kernel.h"

namespace planish {
namespace {

// Vectors of doubles as wide as the flags allow, with the moves between points in memory (xyz) and
// vectors of x, of y and of z. Included by one kernel source each; all of it is local to that.

}  // namespace
}  // namespace planish

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace planish {
namespace {

#if defined(__AVX2__)
constexpr int kLanes = 4;
#else
constexpr int kLanes = 2;
#endif

typedef double Vector __attribute__((vector_size(8 * kLanes)));
typedef std::int64_t Mask __attribute__((vector_size(8 * kLanes)));

#define PLANISH_INLINE [[gnu::always_inline]] inline
#define PLANISH_INLINE_LAMBDA __attribute__((always_inline))

// The points at indices[0..kLanes).
PLANISH_INLINE void load_points(const double* state, const std::int32_t* indices, Vector& x,
                                Vector& y, Vector& z) {
  const auto at = [&](int lane) { return state + 3 * static_cast<std::int64_t>(indices[lane]); };
#if defined(__AVX2__)
  // Three of four doubles, so that nothing past the last point is read.
  const auto point = [&](int lane) {
    return _mm256_maskload_pd(at(lane), _mm256_setr_epi64x(-1, -1, -1, 0));
  };
  const __m256d a = point(0), b = point(1), c = point(2), d = point(3);
  const __m256d ab = _mm256_unpacklo_pd(a, b), cd = _mm256_unpacklo_pd(c, d);
  x = _mm256_permute2f128_pd(ab, cd, 0x20);
  y = _mm256_permute2f128_pd(_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d), 0x20);
  z = _mm256_permute2f128_pd(ab, cd, 0x31);
#else
  x = Vector{at(0)[0], at(1)[0]};
  y = Vector{at(0)[1], at(1)[1]};
  z = Vector{at(0)[2], at(1)[2]};
#endif
}

// Row targets[lane] + sample of an array of rows of three, for each lane.
PLANISH_INLINE void store_doubles(double* rows, const std::int32_t* targets, std::int32_t sample,
                                  const Vector (&p)[3]) {
  const auto at = [&](int lane) {
    return rows + 3 * (static_cast<std::int64_t>(targets[lane]) + sample);
  };
#if defined(__SSE2__)
  const auto put = [&](int lane, __m128d even, __m128d odd, __m128d z) PLANISH_INLINE_LAMBDA {
    _mm_storeu_pd(at(lane), even);
    _mm_storel_pd(at(lane) + 2, z);
    _mm_storeu_pd(at(lane + 1), odd);
    _mm_storeh_pd(at(lane + 1) + 2, z);
  };
#if defined(__AVX2__)
  const __m256d even = _mm256_unpacklo_pd(p[0], p[1]), odd = _mm256_unpackhi_pd(p[0], p[1]);
  put(0, _mm256_castpd256_pd128(even), _mm256_castpd256_pd128(odd), _mm256_castpd256_pd128(p[2]));
  put(2, _mm256_extractf128_pd(even, 1), _mm256_extractf128_pd(odd, 1),
      _mm256_extractf128_pd(p[2], 1));
#else
  put(0, _mm_unpacklo_pd(p[0], p[1]), _mm_unpackhi_pd(p[0], p[1]), p[2]);
#endif
#else
  for (int l = 0; l < kLanes; ++l) {
    for (int d = 0; d < 3; ++d) at(l)[d] = p[d][l];
  }
#endif
}

// The same, rounded to float.
PLANISH_INLINE void store_floats(float* rows, const std::int32_t* targets, std::int32_t sample,
                                 const Vector (&p)[3]) {
  const auto at = [&](int lane) {
    return rows + 3 * (static_cast<std::int64_t>(targets[lane]) + sample);
  };
#if defined(__AVX2__)
  const auto put = [&](int lane, __m128 x, __m128 y, __m128 z) PLANISH_INLINE_LAMBDA {
    const __m128 low = _mm_unpacklo_ps(x, y), high = _mm_unpackhi_ps(x, y);
    _mm_storel_pi(reinterpret_cast<__m64*>(at(lane)), low);
    _mm_storeh_pi(reinterpret_cast<__m64*>(at(lane + 1)), low);
    _mm_storel_pi(reinterpret_cast<__m64*>(at(lane + 2)), high);
    _mm_storeh_pi(reinterpret_cast<__m64*>(at(lane + 3)), high);
    _mm_store_ss(at(lane) + 2, z);
    _MM_EXTRACT_FLOAT(at(lane + 1)[2], z, 1);
    _MM_EXTRACT_FLOAT(at(lane + 2)[2], z, 2);
    _MM_EXTRACT_FLOAT(at(lane + 3)[2], z, 3);
  };
  put(0, _mm256_cvtpd_ps(p[0]), _mm256_cvtpd_ps(p[1]), _mm256_cvtpd_ps(p[2]));
#else
  for (int l = 0; l < kLanes; ++l) {
    for (int d = 0; d < 3; ++d) at(l)[d] = static_cast<float>(p[d][l]);
  }
#endif
}

// As many numbers as a vector has, or two; to floats they are rounded.
#if defined(__AVX2__)
PLANISH_INLINE void put_numbers(double* to, __m256d v) { _mm256_storeu_pd(to, v); }
PLANISH_INLINE void put_numbers(float* to, __m256d v) { _mm_storeu_ps(to, _mm256_cvtpd_ps(v)); }
#elif defined(__SSE2__)
PLANISH_INLINE void put_numbers(double* to, __m128d v) { _mm_storeu_pd(to, v); }
PLANISH_INLINE void put_numbers(float* to, __m128d v) {
  _mm_storel_pi(reinterpret_cast<__m64*>(to), _mm_cvtpd_ps(v));
}
#endif

// kCount numbers of each lane, a multiple of four: to row targets[lane] and on from there.
template <int kCount, class Number>
PLANISH_INLINE void store_runs(Number* rows, const std::int32_t* targets, const Vector* v) {
  static_assert(kCount % 4 == 0);
  Number* to[kLanes];
  for (int l = 0; l < kLanes; ++l) to[l] = rows + 3 * static_cast<std::int64_t>(targets[l]);
#if defined(__AVX2__)
  for (int i = 0; i < kCount; i += 4) {
    const __m256d a = _mm256_unpacklo_pd(v[i], v[i + 1]), b = _mm256_unpackhi_pd(v[i], v[i + 1]),
                  c = _mm256_unpacklo_pd(v[i + 2], v[i + 3]),
                  d = _mm256_unpackhi_pd(v[i + 2], v[i + 3]);
    put_numbers(to[0] + i, _mm256_permute2f128_pd(a, c, 0x20));
    put_numbers(to[1] + i, _mm256_permute2f128_pd(b, d, 0x20));
    put_numbers(to[2] + i, _mm256_permute2f128_pd(a, c, 0x31));
    put_numbers(to[3] + i, _mm256_permute2f128_pd(b, d, 0x31));
  }
#elif defined(__SSE2__)
  for (int i = 0; i < kCount; i += 2) {
    put_numbers(to[0] + i, _mm_unpacklo_pd(v[i], v[i + 1]));
    put_numbers(to[1] + i, _mm_unpackhi_pd(v[i], v[i + 1]));
  }
#else
  for (int i = 0; i < kCount; ++i) {
    for (int l = 0; l < kLanes; ++l) to[l][i] = static_cast<Number>(v[i][l]);
  }
#endif
}

PLANISH_INLINE Vector square_root(Vector v) {
#if defined(__AVX2__)
  return _mm256_sqrt_pd(v);
#elif defined(__SSE2__)
  return _mm_sqrt_pd(v);
#else
  for (int l = 0; l < kLanes; ++l) v[l] = __builtin_sqrt(v[l]);
  return v;
#endif
}

// The patch kernel at the width of its lanes. Each lane computes what it would alone, by
// additions, multiplications, divisions and roots that are rounded one by one: the same bits at
// every width (the flags forbid fused ones).

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

// All samples of patches whose control points are given relative to their own points. Column and
// sample counts above 0 are known when compiling; with kSparse the columns that samples need are
// too. `put` takes each sample's rows.
template <int kColumns, int kSamples, bool kSparse, class Put>
PLANISH_INLINE Mask make_samples(const PatchBatch& batch, const PatchOutput& output,
                                 const Vector (&own)[3], const Vector* points, const Put& put) {
  const int column_count = kColumns > 0 ? kColumns : batch.column_count;
  const int sample_count = kSamples > 0 ? kSamples : batch.sample_count;
  const double* weights = batch.weights;
  // Rows that nobody takes are not made.
  const bool takes_positions = output.positions != nullptr || output.stored != nullptr;
  const bool takes_normals = output.normals != nullptr;
  const bool wanted[3] = {takes_positions, takes_normals, takes_normals};
  Mask kept = ~Mask{};
  constexpr int kSumCount = kSamples + (kSamples == 0);
  Vector sums[kSumCount][3][3];  // of a row, of a coordinate
  const auto add_up = [&](const double* rows, Vector(&sum)[3][3], const Vector* x, int d,
                          unsigned needed) PLANISH_INLINE_LAMBDA {
#pragma GCC unroll 3
    for (int r = 0; r < 3; ++r) {
      sum[r][d] = Vector{};
      if (!wanted[r]) continue;
      Vector total{};
#pragma GCC unroll 12
      for (int k = 0; k < column_count; ++k) {
        if (kSparse && (needed >> k & 1) == 0) continue;
        total += rows[r * column_count + k] * x[k];
      }
      sum[r][d] = total;
    }
  };
  if constexpr (kSamples > 0) {
    // A coordinate at a time: its points stay in registers.
#pragma GCC unroll 3
    for (int d = 0; d < 3; ++d) {
      Vector x[kColumns];
      for (int k = 0; k < kColumns; ++k) x[k] = points[d * column_count + k];
#pragma GCC unroll 9
      for (int s = 0; s < kSamples; ++s)
        add_up(weights + s * 3 * column_count, sums[s], x, d, kSparse ? kFaceSampleColumns[s] : 0);
    }
  }
  for (int s = 0; s < sample_count; ++s, weights += 3 * column_count) {
    if constexpr (kSamples == 0) {
      for (int d = 0; d < 3; ++d) add_up(weights, sums[0], points + d * column_count, d, 0);
    }
    const auto& sum = sums[kSamples > 0 ? s : 0];
    if (takes_positions) {
      const auto position = [&](int d) PLANISH_INLINE_LAMBDA {
        return output.centre[d] + output.diagonal * (sum[0][d] + own[d]);
      };
      const Vector positions[3] = {position(0), position(1), position(2)};
      if (output.positions) put.positions(s, positions);
      if (output.stored) {
        const Vector stored[3] = {positions[0] - output.origin[0], positions[1] - output.origin[1],
                                  positions[2] - output.origin[2]};
        put.stored(s, stored);
      }
    }
    if (takes_normals) {
      Vector normal[3];
      kept &= unit_normals(sum[1], sum[2], normal);
      put.normals(s, normal);
    }
  }
  return kept;
}

PLANISH_INLINE bool has_zero(const Mask& kept) {
  bool any = false;
  for (int l = 0; l < kLanes; ++l) any |= kept[l] == 0;
  return any;
}

// Rows of lanes that lie anywhere.
struct PutAnywhere {
  const PatchOutput& output;
  const std::int32_t* targets;

  PLANISH_INLINE void positions(int sample, const Vector (&p)[3]) const {
    store_doubles(output.positions, targets, sample, p);
  }
  PLANISH_INLINE void stored(int sample, const Vector (&p)[3]) const {
    store_floats(output.stored, targets, sample, p);
  }
  PLANISH_INLINE void normals(int sample, const Vector (&p)[3]) const {
    store_floats(output.normals, targets, sample, p);
  }
};

template <int kColumns, int kSamples>
PLANISH_INLINE bool run_lanes(const PatchBatch& batch, const PatchOutput& output, int lane) {
  const int column_count = kColumns > 0 ? kColumns : batch.column_count;
  const std::int32_t* indices = batch.indices + lane;
  Vector own[3];
  load_points(batch.state, indices, own[0], own[1], own[2]);
  Vector* points = reinterpret_cast<Vector*>(batch.points);
  for (int k = 0; k < column_count; ++k) {
    Vector p[3];
    load_points(batch.state, indices + (k + 1) * kPatchLanes, p[0], p[1], p[2]);
    for (int d = 0; d < 3; ++d) points[d * column_count + k] = p[d] - own[d];
  }
  return has_zero(make_samples<kColumns, kSamples, false>(
      batch, output, own, points, PutAnywhere{output, batch.targets + lane}));
}

// Where the four patches of a quad put their rows first.
template <int kSamples>
struct PutInFace {
  Vector* face;     // positions
  Vector* offsets;  // stored
  Vector* units;    // normals
  int corner;

  PLANISH_INLINE void put(Vector* to, int sample, const Vector (&p)[3]) const {
    for (int d = 0; d < 3; ++d) to[(corner * kSamples + sample) * 3 + d] = p[d];
  }
  PLANISH_INLINE void positions(int sample, const Vector (&p)[3]) const { put(face, sample, p); }
  PLANISH_INLINE void stored(int sample, const Vector (&p)[3]) const { put(offsets, sample, p); }
  PLANISH_INLINE void normals(int sample, const Vector (&p)[3]) const { put(units, sample, p); }
};

// Where a limit point of a quad is put.
struct PutPoint {
  const FaceBatch& batch;
  int point, lane;

  PLANISH_INLINE void positions(int, const Vector (&p)[3]) const {
    store_doubles(batch.point_positions, kPlaces + lane, point * kPatchLanes, p);
  }
  PLANISH_INLINE void stored(int, const Vector (&)[3]) const {}
  PLANISH_INLINE void normals(int, const Vector (&p)[3]) const {
    store_floats(batch.point_normals, kPlaces + lane, point * kPatchLanes, p);
  }
  static constexpr std::int32_t kPlaces[kPatchLanes] = {0, 1, 2, 3, 4, 5, 6, 7};
};

// The limit points that are wanted of each quad, in the order of their own class's columns.
PLANISH_INLINE Mask make_face_points(const FaceBatch& batch, const PatchOutput& output,
                                     const Vector (&points)[kFaceColumns][3], int lane) {
  constexpr int kColumns = 3, ring = 4, behind = 8, across = 12;
  PatchBatch limit = batch;
  limit.weights = batch.point_weights;
  Mask kept = ~Mask{};
  for (int point = 0; point < kFacePoints; ++point) {
    if ((batch.wanted_points >> point & 1) == 0) continue;
    const int i = point & 3;
    const int vertex[4] = {i, ring + ((i + 3) & 3), across + i, behind + i};
    const int midpoint[4] = {(i + 1) & 3, i, behind + i, ring + i};
    const int centre[4] = {0, 1, 2, 3};
    const int* const columns = point < 4 ? vertex : point < 8 ? midpoint : centre;
    Vector own[3], from_own[3 * kColumns];
    for (int d = 0; d < 3; ++d) {
      own[d] = points[columns[0]][d];
      for (int k = 0; k < kColumns; ++k)
        from_own[d * kColumns + k] = points[columns[k + 1]][d] - own[d];
    }
    kept &= make_samples<kColumns, 1, false>(limit, output, own, from_own,
                                             PutPoint{batch, point, lane});
  }
  return kept;
}

// The four patches of each quad: its 16 points are read once, its rows follow one another.
template <int kSamples>
PLANISH_INLINE bool run_face_lanes(const FaceBatch& batch, const PatchOutput& output, int lane) {
  constexpr int kRegular = 8, kNumbers = 4 * kSamples * 3;
  Vector points[kFaceColumns][3], face[kNumbers], offsets[kNumbers], units[kNumbers];
  for (int k = 0; k < kFaceColumns; ++k) {
    load_points(batch.state, batch.indices + lane + k * kPatchLanes, points[k][0], points[k][1],
                points[k][2]);
  }
  Mask kept = ~Mask{};
  for (int c = 0; c < 4; ++c) {
    const int before = (c + 3) & 3, ring = 4, behind = 8, across = 12;
    // In the order of the class's columns.
    const int columns[kRegular] = {ring + before, across + c,  behind + c, (c + 1) & 3,
                                   (c + 2) & 3,   (c + 3) & 3, ring + c,   behind + before};
    Vector own[3], from_own[3 * kRegular];
    for (int d = 0; d < 3; ++d) {
      own[d] = points[c][d];
      for (int k = 0; k < kRegular; ++k)
        from_own[d * kRegular + k] = points[columns[k]][d] - own[d];
    }
    kept &= make_samples<kRegular, kSamples, true>(batch, output, own, from_own,
                                                   PutInFace<kSamples>{face, offsets, units, c});
  }
  if (batch.wanted_points != 0) kept &= make_face_points(batch, output, points, lane);
  const std::int32_t* targets = batch.targets + lane;
  if (output.positions) store_runs<kNumbers>(output.positions, targets, face);
  if (output.stored) store_runs<kNumbers>(output.stored, targets, offsets);
  if (output.normals) store_runs<kNumbers>(output.normals, targets, units);
  return has_zero(kept);
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

inline bool run_face_batch(const FaceBatch& batch, const PatchOutput& output) {
  bool degenerate = false;
  for (int lane = 0; lane < batch.lane_count; lane += kLanes) {
    degenerate |= batch.sample_count == 3 ? run_face_lanes<3>(batch, output, lane)
                                          : run_face_lanes<9>(batch, output, lane);
  }
  return degenerate;
}

}  // namespace
}  // namespace planish
