// Vectors of doubles as wide as the flags allow, with the moves between points in memory (xyz) and
// vectors of x, of y and of z. Included by one kernel source each; all of it is local to that.
#pragma once

#include <cstdint>

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

}  // namespace
}  // namespace planish
