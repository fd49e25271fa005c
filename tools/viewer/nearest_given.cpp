#include "nearest_given.h"

#include <algorithm>
#include <numeric>
#include <span>

namespace planish::viewer {
namespace {

/// Neighbours along the edges of the surface's quads, of its triangles at level 0.
std::vector<std::vector<std::uint32_t>> neighbours(const vulkan::System& system,
                                                   std::span<const std::int32_t> original) {
  const bool has_quads = !system.quads().empty();
  const std::span<const std::uint32_t> corners = has_quads ? system.quads() : system.triangles();
  const std::size_t size = has_quads ? 4 : 3;
  std::vector<std::vector<std::uint32_t>> result(system.vertex_count());
  for (std::size_t face = 0; face < corners.size(); face += size)
    for (std::size_t k = 0; k < size; ++k) {
      const auto a = static_cast<std::uint32_t>(original[corners[face + k]]);
      const auto b = static_cast<std::uint32_t>(original[corners[face + (k + 1) % size]]);
      result[a].push_back(b);
      result[b].push_back(a);
    }
  return result;
}

}  // namespace

NearestGiven nearest_given(const vulkan::System& system) {
  const std::span<const std::int32_t> original = system.copied_vertices();
  const auto adjacent = neighbours(system, original);
  const auto given_count = static_cast<std::uint32_t>(system.used_vertices().size());
  constexpr int kFar = -1;
  std::vector<std::vector<std::uint32_t>> rows(system.vertex_count());
  std::vector<int> steps(rows.size(), kFar);
  std::vector<std::uint32_t> reached(given_count);
  std::iota(reached.begin(), reached.end(), 0u);
  for (const std::uint32_t row : reached) {
    rows[row] = {row};
    steps[row] = 0;
  }
  for (int step = 1; !reached.empty(); ++step) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t from : reached)
      for (const std::uint32_t to : adjacent[from]) {
        if (steps[to] == kFar) {
          steps[to] = step;
          next.push_back(to);
        }
        if (steps[to] != step) continue;
        for (const std::uint32_t row : rows[from])
          if (std::ranges::find(rows[to], row) == rows[to].end()) rows[to].push_back(row);
      }
    reached = std::move(next);
  }
  NearestGiven result{{0}, {}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& nearest = rows[original[i]];
    result.rows.insert(result.rows.end(), nearest.begin(), nearest.end());
    result.offsets.push_back(static_cast<std::uint32_t>(result.rows.size()));
  }
  return result;
}

}  // namespace planish::viewer
