// Based on: C. Ericson, "Real-Time Collision Detection", Morgan Kaufmann 2005, section 5.1.5: the
// place of a triangle that is nearest to a point.
#include "planish/surface/texture_slide.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"

namespace planish {
namespace {

constexpr std::int64_t kSlideFaces = 1 << 12;
// Of a triangle, of the squares of its sides in the texture, below which no way across it is known.
constexpr double kLeastTextureArea = 1e-9;

// Of b and c in the nearest place of a triangle with corners 0, b and c.
glm::dvec2 nearest_weights(const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& p) {
  const double d1 = glm::dot(b, p), d2 = glm::dot(c, p);
  if (d1 <= 0 && d2 <= 0) return {0, 0};
  const double bb = glm::dot(b, b), bc = glm::dot(b, c), cc = glm::dot(c, c);
  const double d3 = d1 - bb, d4 = d2 - bc;
  if (d3 >= 0 && d4 <= d3) return {1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {d1 / bb, 0};
  const double d5 = d1 - bc, d6 = d2 - cc;
  if (d6 >= 0 && d5 <= d6) return {0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {0, d2 / cc};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {1 - w, w};
  }
  const double sum = va + vb + vc;
  return {vb / sum, vc / sum};
}

double texture_cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

// A triangle of a face, from its first corner.
struct FaceTriangle {
  glm::dvec3 at, b, c;
  glm::dvec2 uv, uv_b, uv_c;

  // How far a step in the texture leads on the triangle; below 0: nobody knows.
  [[nodiscard]] double length_of(const glm::dvec2& step) const {
    const double area = texture_cross(uv_b, uv_c);
    if (std::abs(area) <= kLeastTextureArea * (glm::dot(uv_b, uv_b) + glm::dot(uv_c, uv_c)))
      return -1;
    return glm::length((texture_cross(step, uv_c) * b + texture_cross(uv_b, step) * c) / area);
  }
};

struct SlideSums {
  double area = 0, squares = 0, largest = 0;
  double known_area = 0, distance_squares = 0, largest_distance = 0;
  std::int32_t face = -1;

  void add(const SlideSums& later) {
    area += later.area, squares += later.squares;
    largest = std::max(largest, later.largest);
    known_area += later.known_area, distance_squares += later.distance_squares;
    if (later.largest_distance > largest_distance)
      largest_distance = later.largest_distance, face = later.face;
  }
};

class SlideMeter {
 public:
  SlideMeter(const SurfaceBlocks& surface, const PolygonMesh& mesh)
      : surface_(surface), mesh_(mesh) {
    uvs_.resize(static_cast<std::size_t>(surface.info().uv_count));
    parallel_for(uvs_.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
      surface.uvs({static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end - begin)},
                  std::span(uvs_).subspan(begin, end - begin));
    });
  }

  [[nodiscard]] SlideSums operator()(RowRange faces) const {
    const SurfaceInfo& info = surface_.info();
    const std::int64_t first = info.first_corner(faces.first);
    const auto count =
        static_cast<std::size_t>(info.first_corner(faces.first + faces.count) - first);
    RawVector<glm::dvec3> positions(count);
    RawVector<glm::vec3> normals(count);
    RawVector<std::int32_t> uvs(count), ancestors(static_cast<std::size_t>(faces.count));
    surface_.corners(faces, positions, normals);
    surface_.face_uvs(faces, uvs);
    surface_.ancestors(faces, ancestors);
    std::vector<FaceTriangle> triangles;
    std::int32_t ancestor = -1;
    SlideSums sums;
    for (std::int64_t f = 0; f < faces.count; ++f) {
      if (ancestors[f] != ancestor) cut(ancestor = ancestors[f], triangles);
      if (triangles.empty()) continue;
      const auto begin = static_cast<std::size_t>(info.first_corner(faces.first + f) - first);
      const auto end = static_cast<std::size_t>(info.first_corner(faces.first + f + 1) - first);
      const auto corners = std::span(positions).subspan(begin, end - begin);
      const double share = area_of(corners) / static_cast<double>(end - begin);
      for (std::size_t k = begin; k < end; ++k)
        add(triangles, ancestor, positions[k], uvs_[uvs[k]], share, sums);
    }
    return sums;
  }

 private:
  // None where a corner has no texture coordinate.
  void cut(std::int32_t face, std::vector<FaceTriangle>& triangles) const {
    triangles.clear();
    const std::int32_t first = mesh_.face_offsets[face], end = mesh_.face_offsets[face + 1];
    for (std::int32_t c = first; c < end; ++c)
      if (mesh_.face_uvs[c] < 0) return;
    const auto at = [&](std::int32_t c) { return mesh_.positions[mesh_.face_vertices[c]]; };
    const auto uv = [&](std::int32_t c) { return mesh_.uvs[mesh_.face_uvs[c]]; };
    for (std::int32_t c = first + 1; c + 1 < end; ++c)
      triangles.push_back({at(first), at(c) - at(first), at(c + 1) - at(first), uv(first),
                           uv(c) - uv(first), uv(c + 1) - uv(first)});
  }

  static double area_of(std::span<const glm::dvec3> corners) {
    glm::dvec3 sum(0.0);
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
      sum += glm::cross(corners[k] - corners[0], corners[k + 1] - corners[0]);
    return 0.5 * glm::length(sum);
  }

  static void add(std::span<const FaceTriangle> triangles, std::int32_t face, const glm::dvec3& p,
                  const glm::dvec2& uv, double area, SlideSums& sums) {
    const FaceTriangle* nearest = nullptr;
    glm::dvec2 weights(0.0);
    double least = std::numeric_limits<double>::infinity();
    for (const FaceTriangle& one : triangles) {
      const glm::dvec3 seen = p - one.at;
      const glm::dvec2 of = nearest_weights(one.b, one.c, seen);
      const glm::dvec3 apart = seen - of.x * one.b - of.y * one.c;
      if (const double square = glm::dot(apart, apart); square < least)
        least = square, nearest = &one, weights = of;
    }
    if (nearest == nullptr) return;
    const glm::dvec2 step =
        uv - nearest->uv - weights.x * nearest->uv_b - weights.y * nearest->uv_c;
    const double length = glm::length(step);
    sums.area += area;
    sums.squares += area * length * length;
    sums.largest = std::max(sums.largest, length);
    const double distance = nearest->length_of(step);
    if (distance < 0) return;
    sums.known_area += area;
    sums.distance_squares += area * distance * distance;
    if (distance > sums.largest_distance) sums.largest_distance = distance, sums.face = face;
  }

  const SurfaceBlocks& surface_;
  const PolygonMesh& mesh_;
  RawVector<glm::dvec2> uvs_;
};

}  // namespace

TextureSlide texture_slide(const SurfaceBlocks& surface, const PolygonMesh& mesh,
                           const Callbacks& callbacks) {
  const HostScope host(callbacks);
  const SlideMeter measure(surface, mesh);
  const std::vector<RowRange> pieces = ranges_of(surface.info().face_count, kSlideFaces);
  std::vector<SlideSums> of_pieces(pieces.size());
  parallel_each(pieces.size(), 1, [&](std::size_t i) { of_pieces[i] = measure(pieces[i]); });
  SlideSums all;
  for (const SlideSums& part : of_pieces) all.add(part);
  const auto mean = [](double squares, double area) {
    return area > 0 ? std::sqrt(squares / area) : 0.0;
  };
  return {.largest = all.largest,
          .rms = mean(all.squares, all.area),
          .largest_distance = all.largest_distance,
          .rms_distance = mean(all.distance_squares, all.known_area),
          .face = all.face};
}

}  // namespace planish
