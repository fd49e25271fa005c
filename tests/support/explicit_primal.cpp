#include "support/explicit_primal.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>

namespace planish::test {

namespace {

using glm::dvec3;
using std::int32_t;
using Edge = ExplicitPrimal::Edge;

constexpr double kSharpForEver = 10.0;

Edge edge_of(int32_t a, int32_t b) { return {std::min(a, b), std::max(a, b)}; }

double less_sharp(double sharpness) {
  return sharpness >= kSharpForEver ? sharpness : std::max(sharpness - 1.0, 0.0);
}

dvec3 centroid(const ExplicitPrimal& mesh, const std::vector<int32_t>& face) {
  dvec3 sum(0.0);
  for (const int32_t v : face) sum += mesh.points[v];
  return sum / static_cast<double>(face.size());
}

// Who touches whom.
struct Neighbours {
  std::map<Edge, std::vector<int32_t>> faces_of_edge;
  std::map<int32_t, std::set<int32_t>> edge_ends, faces_of_vertex;
  std::map<Edge, double> sharpness;  // of every edge, boundaries included

  explicit Neighbours(const ExplicitPrimal& mesh) {
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto& face = mesh.faces[f];
      for (std::size_t i = 0; i < face.size(); ++i) {
        const int32_t a = face[i], b = face[(i + 1) % face.size()];
        faces_of_edge[edge_of(a, b)].push_back(static_cast<int32_t>(f));
        edge_ends[a].insert(b);
        edge_ends[b].insert(a);
        faces_of_vertex[a].insert(static_cast<int32_t>(f));
      }
    }
    for (const auto& [edge, faces] : faces_of_edge) {
      const auto tag = mesh.edge_sharpness.find(edge);
      sharpness[edge] = tag == mesh.edge_sharpness.end() ? 0.0 : tag->second;
      if (faces.size() == 1) sharpness[edge] = kSharpForEver;
    }
  }
};

int32_t opposite(const std::vector<int32_t>& triangle, const Edge& edge) {
  for (const int32_t v : triangle) {
    if (v != edge[0] && v != edge[1]) return v;
  }
  return -1;
}

dvec3 edge_point(const ExplicitPrimal& mesh, PrimalScheme scheme, const Edge& edge,
                 const Neighbours& around) {
  const dvec3 middle = (mesh.points[edge[0]] + mesh.points[edge[1]]) / 2.0;
  const double sharpness = around.sharpness.at(edge);
  if (sharpness >= 1) return middle;
  dvec3 smooth(0.0);
  const auto& faces = around.faces_of_edge.at(edge);
  if (scheme == PrimalScheme::CatmullClark) {
    smooth = (2.0 * middle + centroid(mesh, mesh.faces[faces[0]]) +
              centroid(mesh, mesh.faces[faces[1]])) /
             4.0;
  } else {
    smooth = 0.75 * middle + (mesh.points[opposite(mesh.faces[faces[0]], edge)] +
                              mesh.points[opposite(mesh.faces[faces[1]], edge)]) /
                                 8.0;
  }
  return (1 - sharpness) * smooth + sharpness * middle;
}

dvec3 smooth_vertex_point(const ExplicitPrimal& mesh, PrimalScheme scheme, int32_t vertex,
                          const Neighbours& around) {
  const dvec3& own = mesh.points[vertex];
  const auto& ends = around.edge_ends.at(vertex);
  const double n = static_cast<double>(ends.size());
  if (scheme == PrimalScheme::Loop) {
    dvec3 sum(0.0);
    for (const int32_t end : ends) sum += mesh.points[end];
    const double a = 3.0 / 8.0 + std::cos(2 * std::numbers::pi / n) / 4.0;
    const double share = 5.0 / 8.0 - a * a;
    return (1 - share) * own + share * sum / n;
  }
  dvec3 faces(0.0), middles(0.0);
  for (const int32_t f : around.faces_of_vertex.at(vertex)) faces += centroid(mesh, mesh.faces[f]);
  for (const int32_t end : ends) middles += (own + mesh.points[end]) / 2.0;
  return (faces / n + 2.0 * middles / n + (n - 3) * own) / n;
}

// The point by the rule that the sharp edges' number picks.
dvec3 vertex_point(const ExplicitPrimal& mesh, PrimalScheme scheme, int32_t vertex,
                   const Neighbours& around, double own_sharpness,
                   const std::vector<int32_t>& sharp_ends) {
  const dvec3& own = mesh.points[vertex];
  if (own_sharpness > 0 || sharp_ends.size() > 2) return own;
  if (sharp_ends.size() < 2) return smooth_vertex_point(mesh, scheme, vertex, around);
  return 0.75 * own + (mesh.points[sharp_ends[0]] + mesh.points[sharp_ends[1]]) / 8.0;
}

dvec3 moved_vertex(const ExplicitPrimal& mesh, PrimalScheme scheme, int32_t vertex,
                   const Neighbours& around) {
  const auto tag = mesh.vertex_sharpness.find(vertex);
  const double own = tag == mesh.vertex_sharpness.end() ? 0.0 : tag->second;
  std::vector<int32_t> sharp, still_sharp;
  std::vector<double> decaying;
  if (own > 0 && less_sharp(own) == 0) decaying.push_back(own);
  for (const int32_t end : around.edge_ends.at(vertex)) {
    const double s = around.sharpness.at(edge_of(vertex, end));
    if (s > 0) sharp.push_back(end);
    if (less_sharp(s) > 0) still_sharp.push_back(end);
    if (s > 0 && less_sharp(s) == 0) decaying.push_back(s);
  }
  const dvec3 before = vertex_point(mesh, scheme, vertex, around, own, sharp);
  const dvec3 after = vertex_point(mesh, scheme, vertex, around, less_sharp(own), still_sharp);
  if (decaying.empty()) return before;
  double weight = 0;
  for (const double s : decaying) weight += s / static_cast<double>(decaying.size());
  return weight * before + (1 - weight) * after;
}

dvec3 corner_normal(const ExplicitPrimal& mesh, const std::vector<int32_t>& face, int32_t vertex) {
  const auto place = std::find(face.begin(), face.end(), vertex) - face.begin();
  const std::size_t m = face.size();
  const dvec3 own = mesh.points[vertex];
  return glm::normalize(glm::cross(mesh.points[face[(place + 1) % m]] - own,
                                   mesh.points[face[(place + m - 1) % m]] - own));
}

// The faces around a vertex as a mesh of their own, the vertex first.
struct Cut {
  ExplicitPrimal mesh;
  std::vector<int32_t> faces;  // their indices in the mesh cut from
};

Cut cut_star(const ExplicitPrimal& mesh, int32_t vertex) {
  Cut cut;
  std::map<int32_t, int32_t> place{{vertex, 0}};
  cut.mesh.points.push_back(mesh.points[vertex]);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& face = mesh.faces[f];
    if (std::find(face.begin(), face.end(), vertex) == face.end()) continue;
    cut.faces.push_back(static_cast<int32_t>(f));
    auto& copy = cut.mesh.faces.emplace_back();
    for (const int32_t v : face) {
      const auto [entry, is_new] =
          place.try_emplace(v, static_cast<int32_t>(cut.mesh.points.size()));
      if (is_new) cut.mesh.points.push_back(mesh.points[v]);
      copy.push_back(entry->second);
    }
  }
  for (const auto& [edge, sharpness] : mesh.edge_sharpness) {
    if (!place.contains(edge[0]) || !place.contains(edge[1])) continue;
    cut.mesh.edge_sharpness[edge_of(place[edge[0]], place[edge[1]])] = sharpness;
  }
  const auto tag = mesh.vertex_sharpness.find(vertex);
  if (tag != mesh.vertex_sharpness.end()) cut.mesh.vertex_sharpness[0] = tag->second;
  return cut;
}

}  // namespace

ExplicitPrimal explicit_primal(const PolygonMesh& mesh) {
  ExplicitPrimal result;
  result.points = mesh.positions;
  for (int32_t f = 0; f < mesh.face_count(); ++f) {
    result.faces.emplace_back(mesh.face(f).begin(), mesh.face(f).end());
  }
  for (const CreaseEdge& crease : mesh.creases) {
    result.edge_sharpness[edge_of(crease.v0, crease.v1)] = crease.sharpness;
  }
  for (const CornerVertex& corner : mesh.corners) {
    result.vertex_sharpness[corner.vertex] = corner.sharpness;
  }
  return result;
}

ExplicitPrimal explicit_step(const ExplicitPrimal& mesh, PrimalScheme scheme) {
  const Neighbours around(mesh);
  ExplicitPrimal next;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    next.points.push_back(moved_vertex(mesh, scheme, static_cast<int32_t>(v), around));
  }
  std::vector<int32_t> centre_of_face;
  if (scheme == PrimalScheme::CatmullClark) {
    for (const auto& face : mesh.faces) {
      centre_of_face.push_back(static_cast<int32_t>(next.points.size()));
      next.points.push_back(centroid(mesh, face));
    }
  }
  std::map<Edge, int32_t> middle_of_edge;
  for (const auto& [edge, faces] : around.faces_of_edge) {
    const auto middle = static_cast<int32_t>(next.points.size());
    middle_of_edge[edge] = middle;
    next.points.push_back(edge_point(mesh, scheme, edge, around));
    const double sharpness = faces.size() == 1 ? 0.0 : less_sharp(around.sharpness.at(edge));
    for (const int32_t end : edge) {
      if (sharpness > 0) next.edge_sharpness[edge_of(end, middle)] = sharpness;
    }
  }
  for (const auto& [vertex, sharpness] : mesh.vertex_sharpness) {
    next.vertex_sharpness[vertex] = less_sharp(sharpness);
  }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& face = mesh.faces[f];
    const std::size_t m = face.size();
    std::vector<int32_t> middles;
    for (std::size_t i = 0; i < m; ++i) {
      middles.push_back(middle_of_edge.at(edge_of(face[i], face[(i + 1) % m])));
    }
    for (std::size_t i = 0; i < m; ++i) {
      std::vector<int32_t> child{face[i], middles[i]};
      if (scheme == PrimalScheme::CatmullClark) child.push_back(centre_of_face[f]);
      child.push_back(middles[(i + m - 1) % m]);
      next.faces.push_back(child);
    }
    if (scheme == PrimalScheme::Loop) next.faces.push_back(middles);
  }
  return next;
}

ExplicitPrimal explicit_levels(const PolygonMesh& mesh, PrimalScheme scheme, int levels) {
  ExplicitPrimal result = explicit_primal(mesh);
  for (int l = 0; l < levels; ++l) result = explicit_step(result, scheme);
  return result;
}

ExplicitLimit explicit_limit(const ExplicitPrimal& mesh, PrimalScheme scheme, int32_t vertex) {
  constexpr int kSteps = 60;
  // Further on the slower of two tangent directions drowns in rounding.
  constexpr int kNormalStep = 40;
  const Cut start = cut_star(mesh, vertex);
  ExplicitPrimal star = start.mesh;
  ExplicitLimit limit{dvec3(0.0), {}};
  double scale = 1;
  for (int step = 0; step < kSteps; ++step) {
    star = cut_star(explicit_step(star, scheme), 0).mesh;
    double size = 0;
    const dvec3 own = star.points[0];
    limit.point += scale * own;
    for (dvec3& p : star.points) {
      p -= own;
      size = std::max(size, glm::length(p));
    }
    for (dvec3& p : star.points) p /= size;
    scale *= size;
    if (step != kNormalStep) continue;
    for (std::size_t i = 0; i < star.faces.size(); ++i) {
      limit.normals[start.faces[i]] = corner_normal(star, star.faces[i], 0);
    }
  }
  return limit;
}

}  // namespace planish::test
