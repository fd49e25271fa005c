#include "planish/brep/cap_depth.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/brep/corner_pieces.h"
#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

struct CapError {
  double angle = 0, deviation = 0;
  void add(const CapError& other) {
    angle = std::max(angle, other.angle);
    deviation = std::max(deviation, other.deviation);
  }
};

// The square at an extraordinary point, turned to have that at (0, 0).
struct Cap {
  BezierNet net{};

  // Along a border, from the point outwards; not of unit length.
  [[nodiscard]] glm::dvec3 border_normal(bool along_v, double t) const {
    const std::size_t step = along_v ? 3 : 1, across = along_v ? 1 : 3;
    std::array<glm::dvec3, 3> a, d;
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] = net[k * step];
      d[k] = net[k * step + across] - a[k];
    }
    const glm::dvec3 along = (1 - t) * (a[1] - a[0]) + t * (a[2] - a[1]);
    const glm::dvec3 side = quadratic_blossom(d[0], d[1], d[2], t, t);
    return along_v ? glm::cross(side, along) : glm::cross(along, side);
  }
};

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  const double sine = glm::length(glm::cross(a, b)), cosine = glm::dot(a, b);
  if (sine == 0 && cosine == 0) return 0;  // parallel tangents have no normal
  return std::atan2(sine, cosine) * 180 / std::numbers::pi;
}

class CapMeasure {
 public:
  CapMeasure(const LimitSurface& surface, const QuadLayout& layout)
      : surface_(surface), layout_(layout), corner_(surface) {}

  // Of the caps around a vertex of the mesh or, of a face, around its centre.
  CapError of(std::span<const std::int32_t> corners, bool is_face, int depth) {
    const MeshTopology& topology = surface_.topology();
    caps_.clear();
    CapError error;
    for (const std::int32_t c : corners) {
      caps_.emplace_back();
      if (layout_.is_hidden(c)) continue;
      corner_.move_to(c);
      const CornerPieces pieces(corner_, depth, depth);
      const double inside = std::ldexp(0.5, -depth);
      const double place = is_face ? 1 - inside : inside;
      const SquarePiece& piece = pieces.at(place, place);
      for (std::size_t k = 0; k < 9; ++k) caps_.back().net[k] = piece.net[is_face ? 8 - k : k];
      error.deviation = std::max(error.deviation, deviation(piece));
    }
    // Across the edge that a corner's square shares with the next one.
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::int32_t c = corners[i];
      if (layout_.is_hidden(c)) continue;
      const std::int32_t next = is_face ? topology.next(c) : topology.ccw(c);
      if (next < 0 || layout_.is_hidden(next)) continue;
      if (!is_face && layout_.is_sharp(4 * c + 3)) continue;
      const Cap& other = caps_[(i + 1) % corners.size()];
      for (int k = 1; k <= kPlaces; ++k) {
        const double t = double(k) / kPlaces;
        error.angle = std::max(error.angle, angle_between(caps_[i].border_normal(true, t),
                                                          other.border_normal(false, t)));
      }
    }
    return error;
  }

 private:
  static constexpr int kPlaces = 8;

  double deviation(const SquarePiece& piece) {
    double largest = 0;
    for (int j = 1; j <= 3; ++j) {
      for (int i = 1; i <= 3; ++i) {
        const double u = piece.u + 0.25 * i * piece.size, v = piece.v + 0.25 * j * piece.size;
        const PatchPoint exact = corner_.at({u, v});
        const double length = glm::length(exact.normal);
        const glm::dvec3 apart = piece.blossom({u, u}, {v, v}) - exact.position;
        largest = std::max(largest, length > 0 ? std::abs(glm::dot(apart, exact.normal)) / length
                                               : glm::length(apart));
      }
    }
    return largest;
  }

  const LimitSurface& surface_;
  const QuadLayout& layout_;
  LimitSurface::Corner corner_;
  std::vector<Cap> caps_;
};

}  // namespace

CapDepths cap_depths(const LimitSurface& surface, const QuadLayout& layout, const CapLimits& limits,
                     const Callbacks& callbacks) {
  const MeshTopology& topology = surface.topology();
  const std::int32_t first_face = topology.vertex_count() + topology.edge_count();
  std::vector<std::int32_t> places;
  for (std::int32_t v = 0; v < layout.vertex_count(); ++v) {
    if (layout.is_extraordinary(v) &&
        !(v >= first_face && layout.is_hidden(topology.first_corner(v - first_face))))
      places.push_back(v);
  }
  CapDepths depths;
  depths.of_vertex.assign(static_cast<std::size_t>(layout.vertex_count()), 1);
  depths.count = static_cast<std::int64_t>(places.size());
  std::vector<CapError> errors(places.size());
  LoopProgress progress(callbacks, "faces", 0, 1, std::ssize(places));
  parallel_for(places.size(), 16, [&](std::size_t begin, std::size_t end) {
    CapMeasure measure(surface, layout);
    std::vector<std::int32_t> around;
    for (std::size_t i = begin; i < end; ++i) {
      const bool is_face = places[i] >= first_face;
      around.clear();
      if (is_face) {
        const std::int32_t face = places[i] - first_face;
        for (std::int32_t k = 0; k < topology.face_size(face); ++k)
          around.push_back(topology.first_corner(face) + k);
      } else {
        const auto corners = topology.corners_at(places[i]);
        around.assign(corners.begin(), corners.end());
      }
      int depth = 1;
      for (;; ++depth) {
        errors[i] = measure.of(around, is_face, depth);
        const bool keeps =
            errors[i].angle <= limits.angle && errors[i].deviation <= limits.deviation;
        if (keeps || depth == kDeepestCap) break;
      }
      depths.of_vertex[static_cast<std::size_t>(places[i])] = static_cast<std::int8_t>(depth);
      progress.add();
    }
  });
  CapError worst;
  for (const CapError& error : errors) worst.add(error);
  for (const std::int32_t v : places)
    depths.deepest = std::max<int>(depths.deepest, depths.of_vertex[static_cast<std::size_t>(v)]);
  depths.max_angle = worst.angle;
  depths.max_deviation = worst.deviation;
  return depths;
}

}  // namespace planish
