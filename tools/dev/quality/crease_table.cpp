#include "quality/tables.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <set>
#include <utility>

#include "make_scenes/models.h"
#include "planish/features/find_features.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "quality/part_maker.h"
#include "quality/wild_shapes.h"

namespace planish::quality {

namespace {

constexpr double kPartAim = 0.98, kOrganicAim = 0.02;
constexpr double kFewEdges = 2000;
// Vertices of simplified parts stay where they were.
constexpr double kSamePlace = 1e-9;

struct EdgeFaces {
  glm::dvec3 a, b;  // unit normals
};

EdgeFaces faces_at(const PolygonMesh& mesh, const MeshTopology& topology, std::int32_t edge) {
  const std::int32_t corner = topology.corner_of(edge);
  const auto normal = [&](std::int32_t c) {
    return glm::normalize(area_vector(mesh.positions, mesh.face(topology.face_of(c))));
  };
  return {normal(corner), normal(topology.twin(corner))};
}

bool is_cap(const glm::dvec3& normal) { return std::abs(normal.z) > 0.5; }

// Where an extruded part's outline turns: all turns of its arcs are below 30 degrees.
std::vector<glm::dvec2> outline_corners(const PolygonMesh& part) {
  constexpr double kArcCosine = 0.8660254037844386;
  const MeshTopology topology(part);
  std::vector<glm::dvec2> corners;
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto [a, b] = faces_at(part, topology, e);
    if (is_cap(a) || is_cap(b) || glm::dot(a, b) > kArcCosine) continue;
    corners.emplace_back(part.positions[topology.edge_vertices(e).first]);
  }
  return corners;
}

using EdgeSet = std::set<std::pair<std::int32_t, std::int32_t>>;

EdgeSet model_edges(const PolygonMesh& mesh, const std::vector<glm::dvec2>& corners) {
  const MeshTopology topology(mesh);
  const auto is_corner = [&](std::int32_t v) {
    const glm::dvec2 place(mesh.positions[v]);
    return std::ranges::any_of(corners, [&](const glm::dvec2& corner) {
      return glm::length(place - corner) < kSamePlace;
    });
  };
  EdgeSet edges;
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto [a, b] = faces_at(mesh, topology, e);
    const auto [v, w] = topology.edge_vertices(e);
    if (is_cap(a) && is_cap(b)) continue;
    const bool along =
        glm::length(glm::dvec2(mesh.positions[v]) - glm::dvec2(mesh.positions[w])) < kSamePlace;
    if (is_cap(a) != is_cap(b) || (along && is_corner(v))) edges.insert(std::minmax(v, w));
  }
  return edges;
}

EdgeSet feature_edges(const PolygonMesh& mesh) {
  EdgeSet edges;
  for (const CreaseEdge& edge : find_features(mesh).sharp_edges())
    edges.insert(std::minmax(edge.v0, edge.v1));
  return edges;
}

struct PartCase {
  const char* name;
  bool is_held_out;
  std::function<PolygonMesh()> make;
};

std::vector<PartCase> part_cases() {
  return {{"L part", false, [] { return l_part({16}); }},
          {"L part", true,
           [] {
             return l_part({26, 1.5});
           }},
          {"drilled plate", false, [] { return drilled_plate({16}, 3); }},
          {"drilled plate", true,
           [] {
             return drilled_plate({24, 0.8}, 5);
           }},
          {"gear", false, [] { return gear({24}, 14); }},
          {"gear", true,
           [] {
             return gear({40, 2}, 23);
           }},
          {"rod", false,
           [] {
             return rod({48, 10});
           }},
          {"rod", true,
           [] {
             return rod({72, 30});
           }},
          {"pipe", false,
           [] {
             return pipe({32, 6});
           }},
          {"pipe", true, [] {
             return pipe({50, 2.5});
           }}};
}

// As --case names it.
std::string case_name(const char* name, bool is_decimated, bool is_held_out) {
  return std::string(name) + (is_decimated ? ", decimated" : "") +
         (is_held_out ? ", held out" : "");
}

struct Match {
  double precision, recall;
};

Match match(const EdgeSet& model, const EdgeSet& found) {
  std::vector<std::pair<std::int32_t, std::int32_t>> both;
  std::ranges::set_intersection(model, found, std::back_inserter(both));
  const auto share = [&](const EdgeSet& of) {
    return of.empty() ? 1.0 : static_cast<double>(both.size()) / static_cast<double>(of.size());
  };
  return {share(found), share(model)};
}

void print_part(const PartCase& part, double tolerance, std::vector<std::string>& wrong) {
  const PolygonMesh whole = part.make();
  const PolygonMesh mesh = tolerance > 0 ? simplified(whole, tolerance) : whole;
  const EdgeSet model = model_edges(mesh, outline_corners(whole));
  const Match features = match(model, feature_edges(mesh));
  const std::string name = case_name(part.name, tolerance > 0, part.is_held_out);
  std::printf("| %s | %zu | %.3f | %.3f |\n", name.c_str(), model.size(), features.precision,
              features.recall);
  if (std::min(features.precision, features.recall) < kPartAim)
    wrong.push_back(name + ": other edges than the model's");
}

struct OrganicCase {
  const char* name;
  bool is_held_out;
  std::function<PolygonMesh()> make;
};

std::vector<OrganicCase> organic_cases() {
  const auto few = [](PolygonMesh (*shape)(), double tolerance) {
    return [=] { return simplified(shape(), tolerance); };
  };
  return {{"bust", false, shapes::bust},
          {"goblet", false, shapes::goblet},
          {"rocker arm", true, shapes::rocker_arm},
          {"bust, decimated 2e-4", false, few(shapes::bust, 2e-4)},
          {"bust, decimated 1e-3", true, few(shapes::bust, 1e-3)},
          {"goblet, decimated 2e-4", false, few(shapes::goblet, 2e-4)},
          {"goblet, decimated 1e-3", true, few(shapes::goblet, 1e-3)},
          {"rocker arm, decimated 2e-4", false, few(shapes::rocker_arm, 2e-4)},
          {"rocker arm, decimated 1e-3", true, few(shapes::rocker_arm, 1e-3)},
          {"decimated head", false, [] { return decimated_head(1, 0.05); }},
          {"decimated head", true, [] { return decimated_head(2.5, 0.05); }},
          {"animal, 150", false, [] { return low_poly_animal(150, 8); }},
          {"animal, 400", true, [] { return low_poly_animal(350, 109); }}};
}

}  // namespace

std::vector<std::string> print_crease_table(
    const std::function<bool(const std::string& name)>& is_wanted) {
  std::vector<std::string> wrong;
  std::printf(
      "| part | edges of the model | precision | recall |\n"
      "|---|--:|--:|--:|\n");
  for (const double tolerance : {0.0, 2e-3}) {
    for (const PartCase& part : part_cases())
      if (is_wanted(case_name(part.name, tolerance > 0, part.is_held_out)))
        print_part(part, tolerance, wrong);
  }
  std::printf("\n| organic shape | edges | found |\n|---|--:|--:|\n");
  for (const OrganicCase& organic : organic_cases()) {
    const std::string name = case_name(organic.name, false, organic.is_held_out);
    if (!is_wanted(name)) continue;
    const PolygonMesh mesh = organic.make();
    const auto count = static_cast<double>(feature_edges(mesh).size());
    const double edges = MeshTopology(mesh).edge_count();
    std::printf("| %s | %.0f | %.0f |\n", name.c_str(), edges, count);
    if (count > kOrganicAim * edges && edges > kFewEdges)
      wrong.push_back(name + ": creases are found on an organic shape");
  }
  return wrong;
}

}  // namespace planish::quality
