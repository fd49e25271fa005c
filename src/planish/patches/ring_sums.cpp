// Rings by sums: the rules of sector_rules.cpp with sines and cosines of differences written out, a
// derivation of our own. Of a sector of k faces with curve points w0 and w1, Lc their mean, its odd
// part halves the sum of sin(a_j) (x_j - b_j), for
//   c_|i-j| - c_(2k-1-i-j) = delta_ij / 4 + sin(a_i) sin(a_j) / (2k).
#include "planish/patches/ring_sums.h"

#include <cmath>
#include <numbers>
#include <string>

#include "planish/core/assert.h"
#include "planish/core/error.h"

namespace planish {

namespace {

constexpr double kPi = std::numbers::pi;

bool is_fan(PatchKind kind) { return kind == PatchKind::Convex || kind == PatchKind::Reflex; }

// Of M, U, W, what a place turns them to.
glm::dvec3 turned(std::int32_t which, double cosine, double sine) {
  return which == 0   ? glm::dvec3(1, 0, 0)
         : which == 1 ? glm::dvec3(1, cosine, sine)
                      : glm::dvec3(1, -sine, cosine);
}

}  // namespace

RingColumns ring_columns(const MeshTopology& topology, Weights weights,
                         std::span<const std::int32_t> vertices) {
  if (weights == Weights::DooSabin) return RingColumns::Sums;
  const auto refuse = [](const std::string& what, std::int32_t number, std::int32_t size,
                         const char* parts) {
    throw Error(
        ErrorCode::UnusableMesh,
        formatted("{} {} has {} {}, averaged weights take {} at most; doo-sabin weights take more",
                  what, number, size, parts, kLargestByPoints),
        number);
  };
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
    const auto size = static_cast<std::int32_t>(topology.corners_at(v).size());
    if (size > kLargestByPoints)
      refuse("vertex", vertices.empty() ? v : vertices[v], size, "faces");
  }
  for (std::int32_t f = 0; f < topology.face_count(); ++f)
    if (topology.face_size(f) > kLargestByPoints)
      refuse("face", f, topology.face_size(f), "corners");
  return RingColumns::Points;
}

RingAngles ring_angles(PatchKind kind, std::int32_t size) {
  if (kind == PatchKind::Smooth || kind == PatchKind::Cone || kind == PatchKind::Dart)
    return {0, 2 * kPi / size};
  const double opening = kind == PatchKind::Convex   ? 0.5 * kPi
                         : kind == PatchKind::Reflex ? 1.5 * kPi
                                                     : kPi;
  return {opening / (2 * size), opening / size};
}

std::vector<glm::dvec3> ring_weights(const LargeRing& ring) {
  const auto size = static_cast<std::size_t>(ring.size);
  const auto [first, step] = ring_angles(ring.kind, ring.size);
  const double share = 1.0 / ring.size;
  std::vector<glm::dvec3> rows(size, glm::dvec3(0.0));
  if (is_fan(ring.kind)) {
    const double sign = ring.kind == PatchKind::Reflex ? -1 : 1, root = std::numbers::sqrt2;
    rows.insert(rows.end(), {{0, root, 0}, {0, 0, sign * root}, {1, -root, -sign * root}});
    return rows;
  }
  double sines = 0;
  for (std::size_t j = 0; j < size; ++j) {
    const double angle = first + step * static_cast<double>(j);
    rows[j].z = 2 * share * std::sin(angle);
    sines += rows[j].z;
    if (!ring.is_sector()) rows[j] = {share, 2 * share * std::cos(angle), rows[j].z};
  }
  if (!ring.is_sector()) return rows;
  // The curve's own shares in b_j have no sine sum.
  rows.emplace_back(0.5, 1 / std::numbers::sqrt2, -sines / 2);
  rows.emplace_back(0.5, -1 / std::numbers::sqrt2, -sines / 2);
  if (ring.kind == PatchKind::HalfPlane) rows.emplace_back(0, 0, 0);
  return rows;
}

void write_ring_sums(const LargeRing& ring, std::span<const glm::dvec3> points, glm::dvec3* sums) {
  const std::vector<glm::dvec3> rows = ring_weights(ring);
  PLANISH_ASSERT(rows.size() == points.size());
  // About one of the points: far from the origin sums would lose digits.
  const glm::dvec3 origin = points.front();
  glm::dvec3 mean(0.0), even(0.0), odd(0.0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const glm::dvec3 p = points[i] - origin;
    mean += rows[i].x * p;
    even += rows[i].y * p;
    odd += rows[i].z * p;
  }
  const auto [first, step] = ring_angles(ring.kind, ring.size);
  for (std::int32_t i = 0; i < ring.size; ++i) {
    const double c = std::cos(first + step * i), s = std::sin(first + step * i);
    for (std::int32_t which = 0; which < 3; ++which) {
      const glm::dvec3 share = turned(which, c, s);
      *sums++ = origin + (mean + (share.y * even + share.z * odd));
    }
  }
}

std::vector<double> sum_weights(const LargeRing& ring, std::int32_t sum) {
  const auto [first, step] = ring_angles(ring.kind, ring.size);
  const double angle = first + step * (sum / 3);
  const glm::dvec3 share = turned(sum % 3, std::cos(angle), std::sin(angle));
  std::vector<double> result;
  for (const glm::dvec3& row : ring_weights(ring))
    result.push_back(row.x + share.y * row.y + share.z * row.z);
  return result;
}

}  // namespace planish
