#include "osd/drawing/borders.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>

namespace planish::testing {

using namespace OpenSubdiv;
using Far::PatchDescriptor;

namespace {

/// Corners of triangles on edges that no other triangle of the patch shares. Where a level is
/// hardly above 1, the tessellator rounds inner points onto the border, too.
std::vector<DrawnVertex> border_of(const std::vector<DrawnVertex>& vertices) {
  using Place = std::array<float, 3>;
  const auto place = [](const DrawnVertex& v) { return Place{v.patch, v.u, v.v}; };
  std::map<std::pair<Place, Place>, int> edges;
  const auto each_edge = [&](const auto& visit) {
    for (std::size_t i = 0; i < vertices.size(); i += 3)
      for (std::size_t k = 0; k < 3; ++k) visit(vertices[i + k], vertices[i + (k + 1) % 3]);
  };
  each_edge([&](const auto& a, const auto& b) {
    if (place(a) < place(b))
      ++edges[{place(a), place(b)}];
    else
      --edges[{place(b), place(a)}];
  });
  std::vector<DrawnVertex> border;
  each_edge([&](const auto& a, const auto& b) {
    if (place(a) != place(b) && edges[std::minmax(place(a), place(b))] != 0)
      border.insert(border.end(), {a, b});
  });
  return border;
}

/// Points of a border by how far along.
using Side = std::map<float, glm::vec3>;

/// Of each patch all borders, halves of transition edges apart.
std::vector<Side> sides_of(const std::vector<Patch>& patches,
                           const std::vector<DrawnVertex>& vertices) {
  std::map<std::pair<int, int>, Side> sides;
  for (const DrawnVertex& made : border_of(vertices)) {
    const auto number = static_cast<int>(made.patch);
    const Patch& patch = patches[number];
    const bool triangle = is_triangle(patch.type);
    const float far = triangle ? 1 - made.u - made.v : 1 - made.u;
    const auto add = [&](int side, int transition, float t) {
      const bool halves = (patch.param.GetTransition() & transition) != 0;
      if (!halves || t <= 0.5f) sides[{number, 2 * side}][t] = made.position;
      if (halves && t >= 0.5f) sides[{number, 2 * side + 1}][t] = made.position;
    };
    if (made.u == 0) add(0, triangle ? 4 : 8, made.v);
    if (made.v == 0) add(1, 1, made.u);
    if (std::abs(far) < 1e-6f) add(2, 2, made.v);
    if (!triangle && made.v == 1) add(3, 4, made.u);
  }
  std::vector<Side> result;
  for (auto& [key, side] : sides) result.push_back(std::move(side));
  return result;
}

float distance_to(const Side& side, const glm::vec3& p) {
  float least = glm::distance(p, side.begin()->second);
  for (auto a = side.begin(), b = std::next(a); b != side.end(); a = b++) {
    const glm::vec3 along = b->second - a->second;
    const float size = glm::dot(along, along);
    const float t = size > 0 ? std::clamp(glm::dot(p - a->second, along) / size, 0.0f, 1.0f) : 0.0f;
    least = std::min(least, glm::distance(p, a->second + t * along));
  }
  return least;
}

}  // namespace

bool is_triangle(int type) {
  return type == PatchDescriptor::TRIANGLES || type == PatchDescriptor::LOOP ||
         type == PatchDescriptor::GREGORY_TRIANGLE;
}

std::vector<Patch> patches_of(const Far::PatchTable& table) {
  std::vector<Patch> patches;
  for (int array = 0; array < table.GetNumPatchArrays(); ++array) {
    const PatchDescriptor descriptor = table.GetPatchArrayDescriptor(array);
    for (int local = 0; local < table.GetNumPatches(array); ++local) {
      Patch patch{};
      patch.handle.arrayIndex = array;
      patch.handle.patchIndex = static_cast<int>(patches.size());
      patch.handle.vertIndex = local * descriptor.GetNumControlVertices();
      patch.param = table.GetPatchParam(patch.handle);
      patch.type = descriptor.GetType();
      patches.push_back(patch);
    }
  }
  return patches;
}

int loose_edges(const std::vector<DrawnVertex>& vertices) {
  std::map<std::array<float, 3>, int> points;
  std::vector<int> numbers;
  for (const DrawnVertex& vertex : vertices) {
    const glm::vec3 p = vertex.position + 0.0f;  // no -0
    numbers.push_back(points.try_emplace({p.x, p.y, p.z}, int(points.size())).first->second);
  }
  std::map<std::pair<int, int>, int> edges;
  for (std::size_t i = 0; i < numbers.size(); i += 3) {
    const int* const n = &numbers[i];
    if (n[0] == n[1] || n[1] == n[2] || n[2] == n[0]) continue;
    for (int k = 0; k < 3; ++k) ++edges[{n[k], n[(k + 1) % 3]}];
  }
  EXPECT_FALSE(edges.empty());
  return static_cast<int>(std::ranges::count_if(edges, [&](const auto& edge) {
    const auto opposite = edges.find({edge.first.second, edge.first.first});
    return opposite == edges.end() || opposite->second != edge.second;
  }));
}

float widest_gap(const std::vector<Patch>& patches, const std::vector<DrawnVertex>& vertices,
                 float extent) {
  const std::vector<Side> sides = sides_of(patches, vertices);
  std::vector<glm::vec3> corners;
  const auto corner = [&](const glm::vec3& p) {
    const auto same = std::ranges::find_if(
        corners, [&](const glm::vec3& other) { return glm::distance(p, other) < 1e-4f * extent; });
    const std::ptrdiff_t number = same - corners.begin();
    if (same == corners.end()) corners.push_back(p);
    return number;
  };
  std::map<std::pair<std::ptrdiff_t, std::ptrdiff_t>, std::vector<const Side*>> borders;
  for (const Side& side : sides) {
    const auto a = corner(side.begin()->second), b = corner(side.rbegin()->second);
    borders[std::minmax(a, b)].push_back(&side);
  }
  float widest = 0;
  for (const auto& [ends, shared] : borders) {
    EXPECT_EQ(shared.size() % 2, 0u);
    for (const Side* side : shared) {
      // Of the others the nearest, where two patches share several borders.
      float nearest = HUGE_VALF;
      for (const Side* other : shared) {
        float gap = 0;
        for (const auto& [t, p] : *side) gap = std::max(gap, distance_to(*other, p));
        for (const auto& [t, p] : *other) gap = std::max(gap, distance_to(*side, p));
        if (other != side) nearest = std::min(nearest, gap);
      }
      widest = std::max(widest, nearest);
    }
  }
  return widest;
}

}  // namespace planish::testing
