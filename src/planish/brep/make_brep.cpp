#include "planish/brep/make_brep.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "planish/brep/cap_depth.h"
#include "planish/brep/doo_sabin_splines.h"
#include "planish/brep/quad_layout.h"
#include "planish/brep/shells.h"
#include "planish/brep/spline_face.h"
#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

// An edge's place in a face.
struct EdgePlace {
  std::int32_t edge = 0;
  int side = 0;
  std::int32_t first = 0, count = 0;
};

struct FaceEdges {
  std::vector<EdgePlace> own;    // which the face makes
  std::vector<EdgePlace> other;  // which the face across makes
};

void check(const BrepOptions& options) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::InvalidArgument, what);
  };
  if (!(options.angle > 0 && options.angle <= kMostBrepAngle))
    refuse("the angle at a B-rep's edges is above 0 and at most 90 degrees");
  if (!(options.deviation > 0 && options.deviation <= 1))
    refuse("the deviation of a B-rep is above 0 and at most 1 of the diagonal");
  if (options.face_size < 1 || options.face_size > kMostFaceSize)
    refuse("a B-rep's face has 1 to 4096 quads a side");
}

// Numbers edges and vertices, and sets loops, shells and ends of edges.
std::vector<FaceEdges> make_topology(const QuadLayout& layout, std::size_t half_edge_count,
                                     Brep& brep) {
  std::vector<std::int32_t> edge_at(half_edge_count, -1);  // by its first half edge
  std::vector<std::int32_t> vertex_of(static_cast<std::size_t>(layout.vertex_count()), -1);
  std::int32_t vertex_count = 0;
  const auto vertex = [&](std::int32_t v) {
    std::int32_t& number = vertex_of[v];
    if (number < 0) number = vertex_count++;
    return number;
  };
  const auto& rectangles = layout.rectangles();
  std::vector<FaceEdges> edges(rectangles.size());
  brep.faces.resize(rectangles.size());
  for (std::size_t f = 0; f < rectangles.size(); ++f) {
    for (int s = 0; s < 4; ++s) {
      const std::vector<std::int32_t> side = rectangles[f].side(s);
      for (std::size_t i = 0; i < side.size();) {
        std::size_t j = i + 1;
        while (j < side.size() && !layout.is_end(layout.origin(side[j]))) ++j;
        const auto first = static_cast<std::int32_t>(i), count = static_cast<std::int32_t>(j - i);
        const std::int32_t back = layout.twin(side[j - 1]);
        const std::int32_t known = back < 0 ? -1 : edge_at[back];
        if (known >= 0) {
          edges[f].other.push_back({known, s, first, count});
          brep.faces[f].loop.push_back({known, true});
        } else {
          const auto edge = static_cast<std::int32_t>(brep.edges.size());
          edge_at[side[i]] = edge;
          edges[f].own.push_back({edge, s, first, count});
          brep.faces[f].loop.push_back({edge, false});
          Brep::Edge made;
          made.from = vertex(layout.origin(side[i]));
          made.to = vertex(layout.target(side[j - 1]));
          brep.edges.push_back(std::move(made));
        }
        i = j;
      }
    }
  }
  brep.vertices.resize(static_cast<std::size_t>(vertex_count));
  return edges;
}

// What faces and edges take at most: all knots are counted, of which some will not be needed.
void require_memory_for(const QuadLayout& layout, const CapDepths& depths) {
  double bytes = 0;
  for (const QuadLayout::Rectangle& rectangle : layout.rectangles()) {
    double inside = static_cast<double>(layout.degree()) + 1;
    for (int s = 0; s < 4; ++s) {
      const std::int32_t vertex = layout.origin(rectangle.side(s).front());
      if (layout.is_extraordinary(vertex)) inside += 0.5 * depths.of_vertex[vertex];
    }
    const double u = rectangle.width + inside, v = rectangle.height + inside;
    bytes += sizeof(glm::dvec3) * (u * v + u + v) + 1000;
  }
  const auto free = available_memory_bytes();
  if (bytes <= static_cast<double>(free)) return;
  const auto mebibytes = [](double count) {
    return std::to_string(static_cast<std::uint64_t>(count) >> 20);
  };
  throw Error(ErrorCode::OutOfMemory,
              counted(std::ssize(layout.rectangles()), "B-spline face") + " need about " +
                  mebibytes(bytes) + " MiB of memory where " + mebibytes(double(free)) +
                  " are free; allow a larger angle and deviation, or take a coarser mesh");
}

// Within what no program tells from nothing.
bool is_flat(std::span<const glm::dvec3> points, double diagonal) {
  constexpr double kFlat = 1e-9;  // of the diagonal
  const glm::dvec3 origin = points.front();
  glm::dvec3 normal(0.0);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const glm::dvec3 area = glm::cross(points[i] - origin, points[i + 1] - origin);
    if (glm::dot(area, area) > glm::dot(normal, normal)) normal = area;
  }
  const double length = glm::length(normal);
  if (!(length > 0)) return false;
  return std::ranges::all_of(points, [&](const glm::dvec3& p) {
    return std::abs(glm::dot(p - origin, normal)) <= kFlat * diagonal * length;
  });
}

// Of a rectangle's cells whose quad's vertex is one of the mesh.
void place_vertices(const QuadLayout& layout, std::int32_t face, Brep& brep) {
  constexpr std::array<glm::dvec2, 4> kOrigin{{{0, 0}, {0, 1}, {1, 1}, {1, 0}}};
  const QuadLayout::Rectangle& cells = layout.rectangles()[face];
  for (std::int32_t y = 0; y < cells.height; ++y) {
    for (std::int32_t x = 0; x < cells.width; ++x) {
      const QuadLayout::Cell& cell = cells.cell(x, y);
      brep.places[layout.origin(4 * cell.corner)] = {face, glm::dvec2(x, y) + kOrigin[cell.turn]};
    }
  }
}

}  // namespace

Brep make_brep(const SplineSurface& surface, const BrepOptions& options, const Callbacks& callbacks,
               std::span<const std::int32_t> groups) {
  check(options);
  const HostScope host(callbacks);
  callbacks.report("faces", 0);
  const QuadLayout layout(surface, options.face_size, groups);
  constexpr double kDepthsShare = 0.4;  // of the time
  const Callbacks depths_callbacks = share_of(callbacks, 0, kDepthsShare);
  const CapDepths depths =
      cap_depths(surface, layout, {options.angle, options.deviation}, depths_callbacks);
  require_memory_for(layout, depths);
  Brep brep;
  brep.degree = surface.degree();
  brep.extraordinary = depths.count;
  brep.moved = depths.moved;
  brep.deepest = depths.deepest;
  brep.max_angle = depths.max_angle;
  brep.max_deviation = depths.max_deviation;
  const auto half_edges = 4 * static_cast<std::size_t>(surface.topology().corner_count());
  const std::vector<FaceEdges> edges = make_topology(layout, half_edges, brep);
  brep.places.resize(static_cast<std::size_t>(surface.topology().vertex_count()));
  for (std::size_t f = 0; f < brep.faces.size(); ++f)
    place_vertices(layout, static_cast<std::int32_t>(f), brep);
  LoopProgress progress(callbacks, "faces", kDepthsShare, 1, std::ssize(brep.faces));
  parallel_each(brep.faces.size(), 1, [&](std::int32_t f) {
    const SplineFace spline(surface, layout, depths, f);
    Brep::Face& face = brep.faces[f];
    spline.fill(face);
    face.is_flat = is_flat(face.points, surface.placement().diagonal);
    if (!groups.empty()) {
      const std::int32_t corner = layout.rectangles()[f].cells.front().corner;
      face.group = groups[surface.topology().face_of(corner)];
    }
    for (const EdgePlace& own : edges[f].own) {
      Brep::Edge& edge = brep.edges[own.edge];
      spline.fill(edge, own.side, own.first, own.count);
      edge.lines[0] = spline.line(own.side, own.first, own.count, false);
    }
    for (const EdgePlace& other : edges[f].other) {
      brep.edges[other.edge].lines[1] = spline.line(other.side, other.first, other.count, true);
    }
    progress.add();
  });
  for (const Brep::Edge& edge : brep.edges) {
    brep.vertices[edge.from] = edge.points.front();
    brep.vertices[edge.to] = edge.points.back();
  }
  make_shells(surface.topology(), layout, brep);
  callbacks.report("faces", 1);
  return brep;
}

Brep make_brep(const LimitSurface& surface, const BrepOptions& options, const Callbacks& callbacks,
               std::span<const std::int32_t> groups) {
  return make_brep(DooSabinSplines(surface), options, callbacks, groups);
}

}  // namespace planish
