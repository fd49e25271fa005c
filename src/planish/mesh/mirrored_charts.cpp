#include "planish/mesh/mirrored_charts.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <unordered_map>

#include "planish/core/parallel.h"

namespace planish {
namespace {

// The way round of a face in the texture; unknown where it has no area, or a corner no coordinate.
enum class Way : std::uint8_t { Unknown, Left, Right };

Way way_of(std::span<const std::int32_t> face, std::span<const glm::dvec2> uvs) {
  if (std::ranges::min(face) < 0) return Way::Unknown;
  double area = 0;
  for (std::size_t k = 0; k < face.size(); ++k) {
    const glm::dvec2& a = uvs[face[k]];
    const glm::dvec2& b = uvs[face[k + 1 < face.size() ? k + 1 : 0]];
    area += a.x * b.y - a.y * b.x;
  }
  return area > 0 ? Way::Left : area < 0 ? Way::Right : Way::Unknown;
}

std::span<std::int32_t> uvs_of_face(PolygonMesh& mesh, std::size_t face) {
  const auto begin = static_cast<std::size_t>(mesh.face_offsets[face]);
  return std::span(mesh.face_uvs)
      .subspan(begin, static_cast<std::size_t>(mesh.face_offsets[face + 1]) - begin);
}

// Of all faces; none where they all lie alike, as most do.
std::vector<Way> ways_of_faces(PolygonMesh& mesh, std::span<const glm::dvec2> uvs) {
  std::vector<Way> ways(static_cast<std::size_t>(mesh.face_count()), Way::Unknown);
  std::atomic<bool> has_left{false}, has_right{false};
  parallel_for(ways.size(), 4096, [&](std::size_t begin, std::size_t end) {
    bool left = false, right = false;
    for (std::size_t f = begin; f < end; ++f) {
      ways[f] = way_of(uvs_of_face(mesh, f), uvs);
      left = left || ways[f] == Way::Left;
      right = right || ways[f] == Way::Right;
    }
    if (left) has_left = true;
    if (right) has_right = true;
  });
  if (!has_left || !has_right) ways.clear();
  return ways;
}

}  // namespace

std::vector<std::int32_t> cut_mirrored_charts(PolygonMesh& mesh, std::span<const glm::dvec2> uvs) {
  std::vector<std::int32_t> copied;
  if (mesh.face_uvs.empty()) return copied;
  const std::vector<Way> ways_of = ways_of_faces(mesh, uvs);
  // The way round of the first face that has a texture coordinate is that one's.
  std::vector<Way> ways(ways_of.empty() ? 0 : uvs.size(), Way::Unknown);
  std::unordered_map<std::int32_t, std::int32_t> copies;
  for (std::size_t f = 0; f < ways_of.size(); ++f) {
    const Way way = ways_of[f];
    if (way == Way::Unknown) continue;
    for (std::int32_t& uv : uvs_of_face(mesh, f)) {
      Way& known = ways[uv];
      if (known == Way::Unknown) known = way;
      if (known == way) continue;
      const auto [copy, is_new] =
          copies.try_emplace(uv, static_cast<std::int32_t>(mesh.uvs.size() + copied.size()));
      if (is_new) copied.push_back(uv);
      uv = copy->second;
    }
  }
  for (const std::int32_t uv : copied) mesh.uvs.push_back(mesh.uvs[uv]);
  return copied;
}

}  // namespace planish
