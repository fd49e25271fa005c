#include "nearest_given.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <span>
#include <utility>

namespace planish::viewer {
namespace {

/// For each vertex the first one at its place: on creases a vertex has a copy for each further
/// normal, whose limit point is the same sum. Only tangents tell them apart.
std::vector<std::uint32_t> originals(const vulkan::System& system) {
  const LimitStencilView<double> limits = system.limit_stencils();
  std::map<std::vector<std::pair<std::int32_t, double>>, std::uint32_t> first;
  std::vector<std::uint32_t> result;
  for (std::int32_t i = 0; i < limits.row_count(); ++i) {
    std::vector<std::pair<std::int32_t, double>> sum;
    for (std::int32_t k = limits.offsets[i]; k < limits.offsets[i] + limits.sizes[i]; ++k)
      if (limits.weights[k] != 0) sum.emplace_back(limits.indices[k], limits.weights[k]);
    result.push_back(first.emplace(std::move(sum), static_cast<std::uint32_t>(i)).first->second);
  }
  return result;
}

/// Neighbours along the edges of the surface's quads, of its triangles at level 0.
std::vector<std::vector<std::uint32_t>> neighbours(const vulkan::System& system,
                                                   const std::vector<std::uint32_t>& original) {
  const bool has_quads = !system.quads().empty();
  const std::span<const std::uint32_t> corners = has_quads ? system.quads() : system.triangles();
  const std::size_t size = has_quads ? 4 : 3;
  std::vector<std::vector<std::uint32_t>> result(system.vertex_count());
  for (std::size_t face = 0; face < corners.size(); face += size)
    for (std::size_t k = 0; k < size; ++k) {
      const std::uint32_t a = original[corners[face + k]];
      const std::uint32_t b = original[corners[face + (k + 1) % size]];
      result[a].push_back(b);
      result[b].push_back(a);
    }
  return result;
}

}  // namespace

NearestGiven nearest_given(const vulkan::System& system) {
  const std::vector<std::uint32_t> original = originals(system);
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
