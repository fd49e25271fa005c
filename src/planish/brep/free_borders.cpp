#include "planish/brep/free_borders.h"

#include <algorithm>
#include <cstddef>

namespace planish {
namespace {

// Corners along the edge between two vertices of the given mesh; empty where there is none.
class EdgeWalker {
 public:
  EdgeWalker(const FittedTopology& fitted, std::size_t given_count)
      : fitted_(fitted), vertex_of_(given_count, -1) {
    for (std::int32_t v = 0; v < std::ssize(fitted.on); ++v)
      if (fitted.on[v][0] >= 0 && fitted.on[v][0] == fitted.on[v][1])
        vertex_of_[fitted.on[v][0]] = v;
  }

  [[nodiscard]] std::vector<std::int32_t> walk(std::int32_t a, std::int32_t b) const {
    std::vector<std::int32_t> corners;
    const std::int32_t target = vertex_of_[b];
    for (std::int32_t at = vertex_of_[a], before = -1; at != target;) {
      const std::int32_t corner = at < 0 ? -1 : step(at, before, target, {a, b});
      if (corner < 0) return {};
      corners.push_back(corner);
      before = at;
      at = head(corner);
    }
    return corners;
  }

 private:
  [[nodiscard]] std::int32_t head(std::int32_t corner) const {
    return fitted_.topology.vertex_of(fitted_.topology.next(corner));
  }
  [[nodiscard]] std::int32_t step(std::int32_t at, std::int32_t before, std::int32_t target,
                                  std::array<std::int32_t, 2> ends) const {
    std::ranges::sort(ends);
    std::int32_t found = -1;
    for (const std::int32_t c : fitted_.topology.corners_at(at)) {
      const std::int32_t to = head(c);
      if (to == target) return c;
      std::array<std::int32_t, 2> on = fitted_.on[to];
      std::ranges::sort(on);
      if (on == ends && to != before) found = c;
    }
    return found;
  }

  const FittedTopology& fitted_;
  std::vector<std::int32_t> vertex_of_;  // of the given mesh's
};

// The next corner whose leading edge is a border, on the same side.
std::int32_t next_border(const MeshTopology& topology, std::span<const char> is_border,
                         std::int32_t corner) {
  std::int32_t next = topology.next(corner);
  while (is_border[topology.edge_of(next)] == 0 && topology.twin(next) >= 0)
    next = topology.next(topology.twin(next));
  return next;
}

}  // namespace

FreeBorders find_free_borders(const RegionBorders& borders, const FittedTopology& fitted) {
  const MeshTopology& topology = fitted.topology;
  FreeBorders result;
  result.corners.resize(borders.chains.size());
  result.is_border.assign(static_cast<std::size_t>(topology.edge_count()), 0);
  result.is_free.assign(static_cast<std::size_t>(topology.face_count()), 0);
  result.is_torn = result.is_free;
  std::int32_t given_count = 0;
  for (const auto& on : fitted.on) given_count = std::max({given_count, on[0] + 1, on[1] + 1});
  const EdgeWalker walker(fitted, static_cast<std::size_t>(given_count));
  std::vector<std::int32_t> free, bound;  // faces
  for (std::size_t c = 0; c < borders.chains.size(); ++c) {
    const BorderChain& chain = borders.chains[c];
    if (chain.right >= 0 || chain.is_boundary) continue;
    std::vector<std::int32_t>& corners = result.corners[c];
    for (std::size_t i = 0; i + 1 < chain.vertices.size(); ++i) {
      const auto own = walker.walk(chain.vertices[i], chain.vertices[i + 1]);
      const bool is_lost = own.empty() || std::ranges::any_of(own, [&](std::int32_t corner) {
                             return topology.twin(corner) < 0;
                           });
      if (is_lost) {
        corners.clear();
        break;
      }
      corners.insert(corners.end(), own.begin(), own.end());
    }
    for (const std::int32_t corner : corners) {
      result.is_border[topology.edge_of(corner)] = 1;
      bound.push_back(topology.face_of(corner));
      free.push_back(topology.face_of(topology.twin(corner)));
    }
  }
  // All faces that are reached from one side without crossing a border.
  const auto flood = [&](std::vector<std::int32_t> faces) {
    std::vector<char> is_reached(static_cast<std::size_t>(topology.face_count()), 0);
    for (const std::int32_t f : faces) is_reached[f] = 1;
    while (!faces.empty()) {
      const std::int32_t f = faces.back();
      faces.pop_back();
      for (std::int32_t i = 0; i < topology.face_size(f); ++i) {
        const std::int32_t corner = topology.first_corner(f) + i, twin = topology.twin(corner);
        if (twin < 0 || result.is_border[topology.edge_of(corner)] != 0) continue;
        const std::int32_t other = topology.face_of(twin);
        if (is_reached[other] != 0) continue;
        is_reached[other] = 1;
        faces.push_back(other);
      }
    }
    return is_reached;
  };
  result.is_free = flood(free);
  const std::vector<char> is_bound = flood(bound);
  for (std::size_t f = 0; f < is_bound.size(); ++f)
    result.is_torn[f] = is_bound[f] != 0 && result.is_free[f] != 0 ? 1 : 0;
  return result;
}

std::vector<std::vector<FreeSpan>> spans_along(const RegionBorders& borders,
                                               const FreeBorders& free, const MeshTopology& fitted,
                                               const Brep& brep,
                                               std::span<const char> is_free_face) {
  // By half of an edge, at 2 c and 2 c + 1 of the corner on the region's side, along it.
  std::vector<FreeSpan> halves(2 * static_cast<std::size_t>(fitted.corner_count()));
  for (std::int32_t e = 0; e < std::ssize(brep.edges); ++e) {
    const Brep::Edge& edge = brep.edges[e];
    if (edge.lines[1].face < 0) continue;
    const bool is_free = is_free_face[edge.lines[0].face] != 0;
    if (is_free == (is_free_face[edge.lines[1].face] != 0)) continue;
    // Quads' half edges 0 and 3 lie on the mesh's edges.
    std::int32_t corner = edge.half_edge / 4;
    int half = 0;
    if (edge.half_edge % 4 == 3) {
      corner = fitted.prev(corner);
      half = 1;
    }
    const auto count = static_cast<std::int32_t>(edge.knots.back());
    for (std::int32_t i = 0; i < count; ++i) {
      if (is_free) {
        halves[2 * fitted.twin(corner) + 1 - half] = {e, i + 1.0, static_cast<double>(i)};
      } else {
        halves[2 * corner + half] = {e, static_cast<double>(i), i + 1.0};
      }
      if (half == 1) corner = next_border(fitted, free.is_border, corner);
      half = 1 - half;
    }
  }
  std::vector<std::vector<FreeSpan>> result(borders.chains.size());
  for (std::size_t c = 0; c < borders.chains.size(); ++c) {
    std::vector<FreeSpan>& spans = result[c];
    for (const std::int32_t corner : free.corners[c]) {
      for (int half = 0; half < 2; ++half) {
        const FreeSpan& own = halves[2 * corner + half];
        if (!spans.empty() && spans.back().edge == own.edge && spans.back().to == own.from) {
          spans.back().to = own.to;
        } else {
          spans.push_back(own);
        }
      }
    }
    if (borders.chains[c].is_closed && spans.size() > 1 &&
        spans.front().edge == spans.back().edge && spans.front().from == spans.back().to) {
      spans.front().from = spans.back().from;
      spans.pop_back();
    }
    if (std::ranges::any_of(spans, [](const FreeSpan& span) { return span.edge < 0; }))
      spans.clear();
  }
  return result;
}

}  // namespace planish
