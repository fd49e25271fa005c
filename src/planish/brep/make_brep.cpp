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

// Places on a face's border, around it as its loop: at its knots and between them.
std::vector<glm::dvec3> border_of(const Brep& brep, const Brep::Face& face) {
  std::vector<glm::dvec3> border;
  for (int side = 0; side < 4; ++side) {
    const bool along_v = side % 2 == 1, is_back = side >= 2;
    const std::vector<double>& knots = along_v ? face.knots_v : face.knots_u;
    const double across = side == 1 ? face.knots_u.back() : side == 2 ? face.knots_v.back() : 0;
    const std::size_t last = 2 * (knots.size() - 1);
    for (std::size_t i = 0; i < last; ++i) {
      const std::size_t place = is_back ? last - i : i;
      const double t = 0.5 * (knots[place / 2] + knots[(place + 1) / 2]);
      border.push_back(
          point_of(brep, face, along_v ? glm::dvec2(across, t) : glm::dvec2(t, across)));
    }
  }
  return border;
}

// Where all control points lie within `reach` of a plane, which the whole border tells: at a corner
// of half a turn both sides have one direction. None of what is no wider than that, where rounding
// would choose the plane.
std::optional<Brep::Plane> plane_of(const Brep& brep, const Brep::Face& face, double reach,
                                    double& off) {
  const glm::dvec3 origin = face.points.front();
  const std::vector<glm::dvec3> border = border_of(brep, face);
  glm::dvec3 area(0.0), longest(0.0);  // twice the area, as Newell has it
  double around = 0;
  for (std::size_t i = 0; i < border.size(); ++i) {
    const glm::dvec3& next = border[(i + 1) % border.size()];
    area += glm::cross(border[i] - origin, next - origin);
    const glm::dvec3 along = next - border[i];
    if (glm::length(along) > glm::length(longest)) longest = along;
    around += glm::length(along);
  }
  if (!(glm::length(area) > 2 * reach * around)) return std::nullopt;
  Brep::Plane plane;
  plane.normal = glm::normalize(area);
  for (const glm::dvec3& p : face.points)
    off = std::max(off, std::abs(glm::dot(p - origin, plane.normal)));
  if (off > reach) return std::nullopt;
  plane.along = glm::normalize(longest - glm::dot(longest, plane.normal) * plane.normal);
  return plane;
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
  const auto spot = [&](const Brep::Spot& unit) {
    return Brep::Spot{surface.placement().to_model(unit.position), unit.face};
  };
  brep.max_angle = depths.worst.angle;
  brep.max_angle_at = spot(depths.worst.angle_at);
  brep.max_deviation = depths.worst.deviation;
  brep.max_deviation_at = spot(depths.worst.deviation_at);
  const auto half_edges = 4 * static_cast<std::size_t>(surface.topology().corner_count());
  const std::vector<FaceEdges> edges = make_topology(layout, half_edges, brep);
  brep.places.resize(static_cast<std::size_t>(surface.topology().vertex_count()));
  for (std::size_t f = 0; f < brep.faces.size(); ++f)
    place_vertices(layout, static_cast<std::int32_t>(f), brep);
  // Within what no program tells from nothing.
  constexpr double kFlat = 1e-9;  // of the diagonal
  const double diagonal = surface.placement().diagonal,
               flat = diagonal * std::min(kFlat, options.deviation);
  std::vector<double> off_planes(brep.faces.size());
  LoopProgress progress(callbacks, "faces", kDepthsShare, 1, std::ssize(brep.faces));
  parallel_each(brep.faces.size(), 1, [&](std::int32_t f) {
    const SplineFace spline(surface, layout, depths, f);
    Brep::Face& face = brep.faces[f];
    spline.fill(face);
    face.plane = plane_of(brep, face, flat, off_planes[f]);
    if (!face.plane) off_planes[f] = 0;
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
  for (std::size_t f = 0; f < off_planes.size(); ++f) {
    if (off_planes[f] > diagonal * brep.max_deviation) {
      brep.max_deviation = off_planes[f] / diagonal;
      brep.max_deviation_at = {
          brep.faces[f].points.front(),
          surface.topology().face_of(layout.rectangles()[f].cells.front().corner)};
    }
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
