#include "planish/files/gltf/gltf_tangents.h"

#include <oneapi/tbb/parallel_sort.h>

#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numeric>
#include <tuple>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/files/gltf/gltf_face_writer.h"
#include "planish/files/gltf/tangent_batch.h"

namespace planish {
namespace {

constexpr std::int64_t kFaces = std::int64_t{1} << 12;
constexpr std::size_t kTangentsAtOnce = 1 << 12;

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 ? v * (1 / length) : glm::dvec3(0.0);
}

glm::dvec3 flattened(const glm::dvec3& v, const glm::dvec3& normal) {
  return unit_or_zero(v - normal * glm::dot(normal, v));
}

// What is known of a texture coordinate: the sum of the directions at its corners, by their angles.
struct Known {
  glm::dvec3 sum{0.0};
  double area = 0;
  glm::vec3 normal{0.0f};
  std::int32_t row = -1, set = -1;
};

// The same of each corner of some faces.
struct CornerSums {
  RawVector<std::int32_t> rows, uvs;
  std::vector<std::int32_t> sets;  // -1: none is wanted
  RawVector<glm::dvec3> positions;
  RawVector<glm::vec3> normals;
  std::vector<glm::dvec3> sums;
  std::vector<double> areas;
  RawVector<std::byte> triangles;

  void resize(std::size_t count) {
    rows.resize(count), uvs.resize(count), positions.resize(count), normals.resize(count);
    sets.assign(count, -1);
    sums.assign(count, glm::dvec3(0.0));
    areas.assign(count, 0);
  }
};

class Collector {
 public:
  Collector(const SurfaceBlocks& surface, const TangentSource& source)
      : surface_(surface), source_(source) {
    const SurfaceInfo& info = surface.info();
    by_corner_.corners.resize(static_cast<std::size_t>(info.corner_count));
    std::iota(by_corner_.corners.begin(), by_corner_.corners.end(), 0);
  }

  void operator()(RowRange faces, CornerSums& made) const {
    const SurfaceInfo& info = surface_.info();
    const std::int64_t first = info.first_corner(faces.first);
    const auto count =
        static_cast<std::size_t>(info.first_corner(faces.first + faces.count) - first);
    made.resize(count);
    std::vector<std::int32_t> groups(static_cast<std::size_t>(faces.count), 0);
    surface_.face_vertices(faces, made.rows);
    surface_.face_uvs(faces, made.uvs);
    if (info.has_groups) surface_.face_groups(faces, groups);
    surface_.corners(faces, made.positions, made.normals);
    FaceWriter<std::uint32_t>(surface_, by_corner_)(faces, made.triangles, made.positions);
    const std::span corners(reinterpret_cast<const std::uint32_t*>(made.triangles.data()),
                            made.triangles.size() / sizeof(std::uint32_t));
    std::int64_t face = faces.first;
    Batch batch(source_, made);
    for (std::size_t at = 0; at < corners.size(); at += 3) {
      while (corners[at] >= info.first_corner(face + 1)) ++face;
      const int set = source_.set_of_group[static_cast<std::size_t>(groups[face - faces.first])];
      if (set >= 0) batch.add(corners.subspan(at).first<3>(), first, set);
    }
    batch.finish();
  }

 private:
  // Triangles side by side; what they sum up comes to the corners in their order.
  class Batch {
   public:
    Batch(const TangentSource& source, CornerSums& made) : source_(source), made_(made) {}

    void add(std::span<const std::uint32_t, 3> triangle, std::int64_t first, int set) {
      const std::span<const glm::dvec2> uvs = source_.sets[static_cast<std::size_t>(set)];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t corner = triangle[k] - static_cast<std::size_t>(first);
        const glm::dvec2& uv = uvs[static_cast<std::size_t>(made_.uvs[corner])];
        for (int axis = 0; axis < 3; ++axis) {
          given_.position[k][axis][count_] = made_.positions[corner][axis];
          given_.normal[k][axis][count_] = static_cast<double>(made_.normals[corner][axis]);
        }
        given_.uv[k][0][count_] = uv.x;
        given_.uv[k][1][count_] = uv.y;
        corners_[k][count_] = static_cast<std::uint32_t>(corner);
        made_.sets[corner] = set;
      }
      if (++count_ == kTangentLanes) finish();
    }

    void finish() {
      if (count_ == 0) return;
      measure_tangents(given_, sums_);
      for (int i = 0; i < count_; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          const std::uint32_t corner = corners_[k][i];
          made_.sums[corner] +=
              glm::dvec3(sums_.along[k][0][i], sums_.along[k][1][i], sums_.along[k][2][i]);
          made_.areas[corner] += sums_.area[i];
        }
      }
      count_ = 0;
    }

   private:
    const TangentSource& source_;
    CornerSums& made_;
    TangentBatch given_{};  // lanes that are not used stay finite
    TangentSums sums_;
    std::uint32_t corners_[3][kTangentLanes];
    int count_ = 0;
  };

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

std::vector<Known> known_of(const SurfaceBlocks& surface, const TangentSource& source) {
  std::vector<Known> known(static_cast<std::size_t>(surface.info().uv_count));
  const Collector collect(surface, source);
  const std::vector<RowRange> pieces = ranges_of(surface.info().face_count, kFaces);
  in_order<CornerSums>(pieces, collect, [&](RowRange, const CornerSums& made) {
    for (std::size_t c = 0; c < made.uvs.size(); ++c) {
      if (made.sets[c] < 0) continue;
      Known& of = known[static_cast<std::size_t>(made.uvs[c])];
      of.sum += made.sums[c];
      of.area += made.areas[c];
      of.normal = made.normals[c];
      of.row = made.rows[c];
      of.set = made.sets[c];
    }
  });
  return known;
}

// Texture coordinates of rows that have several.
std::vector<std::int32_t> shared_rows(std::span<const Known> known, std::int64_t row_count) {
  constexpr std::int32_t kNone = -1, kSeveral = -2;
  std::vector<std::int32_t> only(static_cast<std::size_t>(row_count), kNone);
  for (std::size_t uv = 0; uv < known.size(); ++uv) {
    if (known[uv].set < 0) continue;
    std::int32_t& of = only[static_cast<std::size_t>(known[uv].row)];
    of = of == kNone ? static_cast<std::int32_t>(uv) : kSeveral;
  }
  std::vector<std::int32_t> shared;
  for (std::size_t uv = 0; uv < known.size(); ++uv)
    if (known[uv].set >= 0 && only[static_cast<std::size_t>(known[uv].row)] == kSeveral)
      shared.push_back(static_cast<std::int32_t>(uv));
  return shared;
}

}  // namespace

std::vector<float> surface_tangents(const SurfaceBlocks& surface, const TangentSource& source) {
  const std::vector<Known> known = known_of(surface, source);
  std::vector<float> tangents(4 * known.size(), 0.0f);
  const auto write = [&](std::size_t uv, const glm::dvec3& sum) {
    write_tangent(known[uv], sum, std::span<float, 4>(tangents.data() + 4 * uv, 4));
  };
  parallel_for(known.size(), kTangentsAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t uv = begin; uv < end; ++uv)
      if (known[uv].set >= 0) write(uv, known[uv].sum);
  });
  // Texture coordinates that are one to a reader, which compares what vertices have.
  std::vector<std::int32_t> order = shared_rows(known, surface.info().row_count);
  const auto key = [&](std::int32_t uv) {
    const Known& of = known[static_cast<std::size_t>(uv)];
    const glm::dvec2 place =
        source.sets[static_cast<std::size_t>(of.set)][static_cast<std::size_t>(uv)];
    return std::tuple(of.set, of.row, place.x, place.y, of.area < 0);
  };
  oneapi::tbb::parallel_sort(order, [&](std::int32_t a, std::int32_t b) {
    const auto of_a = key(a), of_b = key(b);
    return of_a != of_b ? of_a < of_b : a < b;
  });
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    glm::dvec3 sum(0.0);
    for (end = begin; end < order.size() && key(order[end]) == key(order[begin]); ++end)
      sum += known[static_cast<std::size_t>(order[end])].sum;
    for (std::size_t i = begin; i < end; ++i) write(static_cast<std::size_t>(order[i]), sum);
  }
  return tangents;
}

}  // namespace planish
