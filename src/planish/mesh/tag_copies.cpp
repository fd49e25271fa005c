#include "planish/mesh/tag_copies.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "planish/mesh/edge_groups.h"

namespace planish {
namespace {

using EdgeEnds = std::pair<std::int32_t, std::int32_t>;  // the lower vertex first

struct EdgeCopy {
  EdgeEnds original, ends;
  auto operator<=>(const EdgeCopy&) const = default;
};

void copy_creases(PolygonMesh& mesh, std::span<const std::int32_t> sources) {
  if (mesh.creases.empty()) return;
  std::vector<EdgeCopy> copies;
  group_edges(mesh).for_each([&](std::int32_t lower, std::span<const FaceSide> sides) {
    const std::int32_t higher = sides.front().higher;
    copies.push_back({std::minmax(sources[lower], sources[higher]), {lower, higher}});
  });
  std::ranges::sort(copies);
  const auto copies_of = [&](const CreaseEdge& crease) {
    // Not std::ranges::equal_range(), whose range Clang before 16 takes for none.
    const EdgeEnds ends(std::minmax(crease.v0, crease.v1));
    return std::span(std::ranges::lower_bound(copies, ends, {}, &EdgeCopy::original),
                     std::ranges::upper_bound(copies, ends, {}, &EdgeCopy::original));
  };
  // Of several tags of an edge the last one holds: several copies get that alone.
  std::vector<std::size_t> last_tags(copies.size());
  for (std::size_t i = 0; i < mesh.creases.size(); ++i) {
    const auto found = copies_of(mesh.creases[i]);
    if (!found.empty()) last_tags[found.data() - copies.data()] = i;
  }
  std::vector<CreaseEdge> creases;
  for (std::size_t i = 0; i < mesh.creases.size(); ++i) {
    const CreaseEdge& crease = mesh.creases[i];
    const auto found = copies_of(crease);
    if (found.empty()) creases.push_back(crease);
    if (found.size() > 1 && last_tags[found.data() - copies.data()] != i) continue;
    for (const EdgeCopy& copy : found)
      creases.push_back({copy.ends.first, copy.ends.second, crease.sharpness});
  }
  mesh.creases = std::move(creases);
}

// Of several tags of a vertex the last one holds for some schemes, any infinite one for others:
// copies get the sharpest and the last.
void copy_corners(PolygonMesh& mesh, std::span<const std::int32_t> sources,
                  std::int32_t original_count) {
  struct Tags {
    std::int32_t sharpest = -1, last = -1;
  };
  std::vector<Tags> tags(original_count);
  for (std::size_t i = 0; i < mesh.corners.size(); ++i) {
    const auto tag = static_cast<std::int32_t>(i);
    const std::int32_t vertex = mesh.corners[i].vertex;
    if (vertex < 0 || vertex >= original_count) continue;
    auto& [sharpest, last] = tags[vertex];
    if (sharpest < 0 || mesh.corners[i].sharpness >= mesh.corners[sharpest].sharpness)
      sharpest = tag;
    last = tag;
  }
  for (std::int32_t v = original_count; v < mesh.vertex_count(); ++v) {
    const auto [sharpest, last] = tags[sources[v]];
    if (last < 0) continue;
    if (sharpest != last) mesh.corners.push_back({v, mesh.corners[sharpest].sharpness});
    mesh.corners.push_back({v, mesh.corners[last].sharpness});
  }
}

}  // namespace

void copy_tags(PolygonMesh& mesh, std::span<const std::int32_t> sources,
               std::int32_t original_count) {
  copy_creases(mesh, sources);
  copy_corners(mesh, sources, original_count);
}

std::int64_t drop_unknown_tags(PolygonMesh& mesh) {
  if (mesh.creases.empty() && mesh.corners.empty()) return 0;
  const EdgeGroups edges = group_edges(mesh);
  std::vector<std::uint8_t> is_used(mesh.positions.size(), 0);
  for (const std::int32_t vertex : mesh.face_vertices) is_used[vertex] = 1;
  const std::size_t count = std::erase_if(mesh.creases,
                                          [&](const CreaseEdge& crease) {
                                            return std::isnan(crease.sharpness) ||
                                                   edges.find(crease.v0, crease.v1).empty();
                                          }) +
                            std::erase_if(mesh.corners, [&](const CornerVertex& corner) {
                              return std::isnan(corner.sharpness) || corner.vertex < 0 ||
                                     corner.vertex >= mesh.vertex_count() ||
                                     !is_used[corner.vertex];
                            });
  return static_cast<std::int64_t>(count);
}

}  // namespace planish
