// Based on: Doo & Sabin 1978. Their weights are 1/4 at the vertex, 3/4 for the mean and a first
// Fourier term: X_i = P_i / 4 + 3/4 mean + (cos_i C + sin_i S) / (2 m), C = sum cos_j P_j.
#include "planish/fair/corner_offsets.h"

#include "planish/core/parallel.h"
#include "planish/core/work.h"

namespace planish {

namespace {

using glm::dvec3;

constexpr std::size_t kOffsetGrain = 8192;

struct FaceStep {
  const FairTopology& topology;
  std::span<const dvec3> given, points;
  std::span<dvec3> offsets;

  void triangle(std::int32_t first) const {
    const std::int32_t* v = &topology.corner_vertices[first];
    for (int i = 0; i < 3; ++i) {
      const dvec3& own = points[v[i]];
      offsets[first + i] = (own - given[v[i]]) + (points[v[(i + 1) % 3]] - own) / 6.0 +
                           (points[v[(i + 2) % 3]] - own) / 6.0;
    }
  }

  void quad(std::int32_t first) const {
    const std::int32_t* v = &topology.corner_vertices[first];
    for (int i = 0; i < 4; ++i) {
      const dvec3& own = points[v[i]];
      offsets[first + i] = (own - given[v[i]]) +
                           (3.0 * (points[v[(i + 1) % 4]] - own) +
                            3.0 * (points[v[(i + 3) % 4]] - own) + (points[v[(i + 2) % 4]] - own)) /
                               16.0;
    }
  }

  // From the place `to` of the offsets on.
  void polygon(std::int32_t first, std::int32_t to, std::int32_t m) const {
    const std::int32_t* v = &topology.corner_vertices[first];
    const auto circle = topology.unit_circle.of(m);
    const dvec3 origin = points[v[0]];
    dvec3 mean(0.0), cosine_sum(0.0), sine_sum(0.0);
    for (std::int32_t i = 0; i < m; ++i) {
      const dvec3 p = points[v[i]] - origin;
      mean += p;
      cosine_sum += circle[i].x * p;
      sine_sum += circle[i].y * p;
    }
    mean /= m;
    for (std::int32_t i = 0; i < m; ++i) {
      const dvec3 p = points[v[i]] - origin;
      offsets[to + i] = (origin - given[v[i]]) + 0.25 * p + 0.75 * mean +
                        (circle[i].x * cosine_sum + circle[i].y * sine_sum) / (2.0 * m);
    }
  }
};

}  // namespace

void corner_offsets(const FairTopology& topology, std::span<const dvec3> given,
                    std::span<const dvec3> points, std::span<dvec3> offsets) {
  const FaceStep step{topology, given, points, offsets};
  parallel_for(static_cast<std::size_t>(topology.face_count), kOffsetGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (auto f = static_cast<std::int32_t>(begin); f < static_cast<std::int32_t>(end);
                      ++f) {
                   const std::int32_t first = topology.face_offsets[f];
                   const std::int32_t m = topology.face_size(f);
                   if (m == 3) {
                     step.triangle(first);
                   } else if (m == 4) {
                     step.quad(first);
                   } else {
                     step.polygon(first, first, m);
                   }
                 }
               });
}

GivenStep::GivenStep(const FairTopology& topology, std::span<const dvec3> given)
    : topology_(topology), given_(given) {
  for (const std::int32_t face : topology.large_faces) {
    std::vector<dvec3>& offsets = of_large_.emplace_back();
    offsets.resize(static_cast<std::size_t>(topology.face_size(face)));
    FaceStep{topology, given, given, offsets}.polygon(topology.face_offsets[face], 0,
                                                      topology.face_size(face));
  }
}

dvec3 GivenStep::offset(std::int32_t corner) const {
  const std::int32_t face = topology_.corner_faces[corner];
  const std::int32_t first = topology_.face_offsets[face], m = topology_.face_size(face);
  if (const std::int32_t large = topology_.large_face(face); large >= 0)
    return of_large_[large][corner - first];
  count_work(Work::Points, m);
  const auto circle = topology_.unit_circle.of(m);
  const dvec3& own = given_[topology_.corner_vertices[corner]];
  dvec3 sum(0.0);
  for (std::int32_t i = 0; i < m; ++i) {
    const std::int32_t place = corner - first + i;
    sum += (3 + 2 * circle[i].x) * (given_[topology_.corner_vertices[first + place % m]] - own);
  }
  return sum / (4.0 * m);
}

}  // namespace planish
