#include "planish/files/gltf/gltf_tangents.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numeric>
#include <tuple>

#include "planish/files/gltf/gltf_face_writer.h"

namespace planish {
namespace {

constexpr std::int64_t kFaces = std::int64_t{1} << 14;

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 ? v / length : glm::dvec3(0.0);
}

glm::dvec3 flattened(const glm::dvec3& v, const glm::dvec3& normal) {
  return unit_or_zero(v - normal * glm::dot(normal, v));
}

// Where u grows on a triangle, and on which side of it v does.
struct Direction {
  glm::dvec3 along_u{0.0};
  double area = 0;  // in the texture, with a sign
};

Direction direction_of(const std::array<glm::dvec3, 3>& points,
                       const std::array<glm::dvec2, 3>& uvs) {
  const glm::dvec2 s = uvs[1] - uvs[0], t = uvs[2] - uvs[0];
  const double area = s.x * t.y - s.y * t.x;
  const glm::dvec3 along = t.y * (points[1] - points[0]) - s.y * (points[2] - points[0]);
  return {unit_or_zero(area < 0 ? -along : along), area};
}

// What is known of a texture coordinate: the sum of the directions at its corners, by their angles.
struct Known {
  glm::dvec3 sum{0.0};
  double area = 0;
  glm::vec3 normal{0.0f};
  std::int32_t row = -1, set = -1;
};

struct Share {
  std::int32_t uv;
  Known known;
};

class Collector {
 public:
  Collector(const SurfaceBlocks& surface, const TangentSource& source)
      : surface_(surface), source_(source) {
    const SurfaceInfo& info = surface.info();
    by_corner_.corners.resize(static_cast<std::size_t>(info.corner_count));
    std::iota(by_corner_.corners.begin(), by_corner_.corners.end(), 0);
  }

  void operator()(RowRange faces, std::vector<Share>& shares) const {
    const SurfaceInfo& info = surface_.info();
    const std::int64_t first = info.first_corner(faces.first);
    const auto count =
        static_cast<std::size_t>(info.first_corner(faces.first + faces.count) - first);
    std::vector<std::int32_t> rows(count), uvs(count);
    std::vector<std::int32_t> groups(static_cast<std::size_t>(faces.count), 0);
    std::vector<glm::dvec3> positions(count);
    std::vector<glm::vec3> normals(count);
    surface_.face_vertices(faces, rows);
    surface_.face_uvs(faces, uvs);
    if (info.has_groups) surface_.face_groups(faces, groups);
    surface_.corners(faces, positions, normals);
    RawVector<std::byte> bytes;
    FaceWriter<std::uint32_t>(surface_, by_corner_)(faces, bytes);
    const std::span corners(reinterpret_cast<const std::uint32_t*>(bytes.data()),
                            bytes.size() / sizeof(std::uint32_t));
    shares.clear();
    std::int64_t face = faces.first;
    for (std::size_t at = 0; at < corners.size(); at += 3) {
      while (corners[at] >= info.first_corner(face + 1)) ++face;
      const int set = source_.set_of_group[static_cast<std::size_t>(groups[face - faces.first])];
      if (set < 0) continue;
      std::array<std::size_t, 3> corner;
      std::array<glm::dvec3, 3> points;
      std::array<glm::dvec2, 3> places;
      for (std::size_t k = 0; k < 3; ++k) {
        corner[k] = corners[at + k] - static_cast<std::size_t>(first);
        points[k] = positions[corner[k]];
        places[k] =
            source_.sets[static_cast<std::size_t>(set)][static_cast<std::size_t>(uvs[corner[k]])];
      }
      const Direction direction = direction_of(points, places);
      for (std::size_t k = 0; k < 3; ++k) {
        const glm::dvec3 normal(normals[corner[k]]);
        const glm::dvec3 next = flattened(points[(k + 1) % 3] - points[k], normal);
        const glm::dvec3 last = flattened(points[(k + 2) % 3] - points[k], normal);
        const double angle = std::acos(std::clamp(glm::dot(next, last), -1.0, 1.0));
        shares.push_back({uvs[corner[k]],
                          {.sum = angle * flattened(direction.along_u, normal),
                           .area = direction.area,
                           .normal = normals[corner[k]],
                           .row = rows[corner[k]],
                           .set = set}});
      }
    }
  }

 private:
  const SurfaceBlocks& surface_;
  const TangentSource& source_;
  GltfVertices by_corner_;  // so that triangles come by their corners
};

void write_tangent(const Known& known, const glm::dvec3& sum, std::span<float, 4> to) {
  const glm::dvec3 normal(known.normal);
  glm::dvec3 tangent = flattened(sum, normal);
  if (tangent == glm::dvec3(0.0)) {
    const glm::dvec3 size = glm::abs(normal);
    const int axis = size.x <= size.y && size.x <= size.z ? 0 : size.y <= size.z ? 1 : 2;
    glm::dvec3 any(0.0);
    any[axis] = 1;
    tangent = flattened(any, normal);
  }
  for (int axis = 0; axis < 3; ++axis)
    to[static_cast<std::size_t>(axis)] = static_cast<float>(tangent[axis]);
  to[3] = known.area < 0 ? -1.0f : 1.0f;
}

}  // namespace

std::vector<float> surface_tangents(const SurfaceBlocks& surface, const TangentSource& source) {
  const auto uv_count = static_cast<std::size_t>(surface.info().uv_count);
  std::vector<Known> known(uv_count);
  const Collector collect(surface, source);
  const std::vector<RowRange> pieces = ranges_of(surface.info().face_count, kFaces);
  in_order<std::vector<Share>>(pieces, collect, [&](RowRange, const std::vector<Share>& shares) {
    for (const auto& [uv, share] : shares) {
      Known& of = known[static_cast<std::size_t>(uv)];
      const glm::dvec3 sum = of.sum + share.sum;
      const double area = of.area + share.area;
      of = share;
      of.sum = sum;
      of.area = area;
    }
  });
  // Texture coordinates that are one to a reader, which compares what vertices have.
  std::vector<std::int32_t> order(uv_count);
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::int32_t uv) {
    const Known& of = known[static_cast<std::size_t>(uv)];
    const glm::dvec2 place =
        of.set < 0 ? glm::dvec2(0.0)
                   : source.sets[static_cast<std::size_t>(of.set)][static_cast<std::size_t>(uv)];
    return std::tuple(of.set, of.row, place.x, place.y, of.area < 0);
  };
  oneapi::tbb::parallel_sort(order, [&](std::int32_t a, std::int32_t b) {
    const auto of_a = key(a), of_b = key(b);
    return of_a != of_b ? of_a < of_b : a < b;
  });
  std::vector<float> tangents(4 * uv_count, 0.0f);
  for (std::size_t begin = 0, end = 0; begin < uv_count; begin = end) {
    glm::dvec3 sum(0.0);
    for (end = begin; end < uv_count && key(order[end]) == key(order[begin]); ++end)
      sum += known[static_cast<std::size_t>(order[end])].sum;
    for (std::size_t i = begin; i < end; ++i) {
      const auto uv = static_cast<std::size_t>(order[i]);
      if (known[uv].set >= 0)
        write_tangent(known[uv], sum, std::span<float, 4>(tangents.data() + 4 * uv, 4));
    }
  }
  return tangents;
}

}  // namespace planish
