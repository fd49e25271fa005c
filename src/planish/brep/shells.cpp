#include "planish/brep/shells.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "planish/core/stop.h"

namespace planish {
namespace {

std::size_t slot(std::int32_t index) { return static_cast<std::size_t>(index); }

// Faces by shells.
void join_faces(Brep& brep) {
  std::vector<std::int32_t> parent(brep.faces.size());
  for (std::size_t f = 0; f < parent.size(); ++f) parent[f] = static_cast<std::int32_t>(f);
  const auto root = [&](std::int32_t f) {
    while (parent[slot(f)] != f) {
      auto& up = parent[slot(f)];
      up = parent[slot(up)];
      f = up;
    }
    return f;
  };
  for (const Brep::Edge& edge : brep.edges) {
    if (edge.lines[1].face < 0) continue;
    const std::int32_t a = root(edge.lines[0].face), b = root(edge.lines[1].face);
    parent[slot(std::max(a, b))] = std::min(a, b);
  }
  std::vector<std::int32_t> shell_of(brep.faces.size(), -1);
  for (std::size_t f = 0; f < brep.faces.size(); ++f) {
    std::int32_t& shell = shell_of[slot(root(static_cast<std::int32_t>(f)))];
    if (shell < 0) {
      shell = static_cast<std::int32_t>(brep.shells.size());
      brep.shells.push_back({{}, true});
    }
    brep.shells[slot(shell)].faces.push_back(static_cast<std::int32_t>(f));
  }
  for (const Brep::Edge& edge : brep.edges) {
    if (edge.lines[1].face < 0)
      brep.shells[slot(shell_of[slot(root(edge.lines[0].face))])].is_closed = false;
  }
}

// The faces of the mesh, through points of the surface, that a shell was made of: near enough to
// tell inside from outside.
struct ShellPolygons {
  std::vector<std::int32_t> faces;
  glm::dvec3 low{std::numeric_limits<double>::max()}, high{-std::numeric_limits<double>::max()};
  double volume = 0;
};

class Nesting {
 public:
  Nesting(const MeshTopology& topology, const QuadLayout& layout, const Brep& brep)
      : topology_(topology), points_(brep.places.size()), shells_(brep.shells.size()) {
    for (std::size_t v = 0; v < points_.size(); ++v) {
      const Brep::Place& place = brep.places[v];
      if (place.face >= 0) points_[v] = point_of(brep, brep.faces[slot(place.face)], place.at);
    }
    std::vector<std::int32_t> shell_of(brep.faces.size());
    for (std::size_t s = 0; s < brep.shells.size(); ++s)
      for (const std::int32_t f : brep.shells[s].faces)
        shell_of[slot(f)] = static_cast<std::int32_t>(s);
    for (std::int32_t f = 0; f < topology_.face_count(); ++f) {
      const std::int32_t corner = topology_.first_corner(f);
      if (!layout.is_hidden(corner))
        add(f, shells_[slot(shell_of[slot(layout.rectangle_of(corner))])]);
    }
  }

  [[nodiscard]] const ShellPolygons& shell(std::size_t index) const { return shells_[index]; }
  [[nodiscard]] bool holds(std::size_t index, const glm::dvec3& point) const {
    const ShellPolygons& shell = shells_[index];
    if (glm::any(glm::lessThan(point, shell.low)) || glm::any(glm::lessThan(shell.high, point)))
      return false;
    double turns = 0;
    for (const std::int32_t f : shell.faces) {
      check_stop();
      each_triangle(f, [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        turns += solid_angle(a - point, b - point, c - point);
      });
    }
    return std::abs(turns) > 2 * std::numbers::pi;
  }
  [[nodiscard]] const glm::dvec3& any_point(std::size_t index) const {
    return points_[slot(topology_.face(shells_[index].faces.front())[0])];
  }

 private:
  template <class Use>
  void each_triangle(std::int32_t face, const Use& use) const {
    const auto vertices = topology_.face(face);
    for (std::size_t i = 1; i + 1 < vertices.size(); ++i)
      use(points_[slot(vertices[0])], points_[slot(vertices[i])], points_[slot(vertices[i + 1])]);
  }
  void add(std::int32_t face, ShellPolygons& shell) {
    shell.faces.push_back(face);
    for (const std::int32_t v : topology_.face(face)) {
      shell.low = glm::min(shell.low, points_[slot(v)]);
      shell.high = glm::max(shell.high, points_[slot(v)]);
    }
    const glm::dvec3 about = points_[slot(topology_.face(shell.faces.front())[0])];
    each_triangle(face, [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
      shell.volume += glm::dot(a - about, glm::cross(b - about, c - about)) / 6;
    });
  }
  // Van Oosterom and Strackee 1983.
  static double solid_angle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const double x = glm::length(a), y = glm::length(b), z = glm::length(c);
    return 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                          x * y * z + glm::dot(a, b) * z + glm::dot(b, c) * x + glm::dot(c, a) * y);
  }

  const MeshTopology& topology_;
  std::vector<glm::dvec3> points_;  // by vertex
  std::vector<ShellPolygons> shells_;
};

}  // namespace

void make_shells(const MeshTopology& topology, const QuadLayout& layout, Brep& brep) {
  join_faces(brep);
  const Nesting nesting(topology, layout, brep);
  for (std::size_t s = 0; s < brep.shells.size(); ++s)
    brep.shells[s].is_inside_out = brep.shells[s].is_closed && nesting.shell(s).volume < 0;
  for (std::size_t s = 0; s < brep.shells.size(); ++s) {
    Brep::Shell& shell = brep.shells[s];
    if (!shell.is_inside_out) continue;
    double least = std::numeric_limits<double>::max();
    for (std::size_t o = 0; o < brep.shells.size(); ++o) {
      const double volume = nesting.shell(o).volume;
      if (!brep.shells[o].is_closed || volume <= -nesting.shell(s).volume || volume >= least)
        continue;
      if (!nesting.holds(o, nesting.any_point(s))) continue;
      least = volume;
      shell.outer = static_cast<std::int32_t>(o);
    }
  }
}

}  // namespace planish
