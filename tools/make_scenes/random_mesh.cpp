#include "make_scenes/random_mesh.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

#include "make_scenes/mesh_builder.h"
#include "make_scenes/random_numbers.h"
#include "make_scenes/shapes.h"

namespace planish::shapes {

namespace {

using Polygon = std::vector<std::int32_t>;

std::vector<Polygon> polygons_of(const PolygonMesh& mesh) {
  std::vector<Polygon> polygons;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    polygons.emplace_back(mesh.face(f).begin(), mesh.face(f).end());
  }
  return polygons;
}

struct FacePair {
  std::int32_t v0, v1;         // the edge, in the direction of the first face
  std::int32_t first, second;  // faces
};

std::vector<FacePair> face_pairs_of(const PolygonMesh& mesh) {
  std::vector<FacePair> pairs;
  std::unordered_map<std::uint64_t, std::size_t> pair_at;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::int32_t v0 = corners[i];
      const std::int32_t v1 = corners[(i + 1) % corners.size()];
      const auto [entry, is_new] = pair_at.try_emplace(edge_key(v0, v1), pairs.size());
      if (is_new) {
        pairs.push_back({v0, v1, f, f});
      } else {
        pairs[entry->second].second = f;
      }
    }
  }
  return pairs;
}

template <typename T>
void shuffle(std::vector<T>& items, RandomNumbers& random) {
  for (std::size_t i = items.size(); i > 1; --i) {
    std::swap(items[i - 1], items[random.below(static_cast<std::int32_t>(i))]);
  }
}

// The face of both polygons without the edge v0 -> v1 of `first`.
Polygon merged(const Polygon& first, const Polygon& second, std::int32_t v0, std::int32_t v1) {
  Polygon result = first;
  std::rotate(result.begin(), std::find(result.begin(), result.end(), v1), result.end());
  Polygon other = second;  // runs v1 -> v0
  std::rotate(other.begin(), std::find(other.begin(), other.end(), v0), other.end());
  result.insert(result.end(), other.begin() + 1, other.end() - 1);
  return result;
}

std::int32_t shared_vertex_count(const Polygon& a, const Polygon& b) {
  return static_cast<std::int32_t>(std::count_if(a.begin(), a.end(), [&](std::int32_t v) {
    return std::find(b.begin(), b.end(), v) != b.end();
  }));
}

std::int32_t root_of(std::vector<std::int32_t>& parents, std::int32_t face) {
  while (parents[face] != face) face = parents[face] = parents[parents[face]];
  return face;
}

// Two triangles (a, b, c) and (b, a, d) become (c, d, b) and (d, c, a).
void flip_edges(std::vector<Polygon>& faces, std::vector<std::int32_t>& valences,
                std::int32_t flip_count, RandomNumbers& random) {
  constexpr std::int32_t kLeastValence = 3;
  constexpr std::int32_t kGreatestValence = 12;
  std::unordered_map<std::uint64_t, std::int32_t> face_at;  // by directed edge
  const auto directed = [](std::int32_t a, std::int32_t b) {
    return (static_cast<std::uint64_t>(a) << 32) | static_cast<std::uint32_t>(b);
  };
  const auto enter = [&](std::int32_t face, Polygon corners) {
    for (int i = 0; i < 3; ++i) face_at[directed(corners[i], corners[(i + 1) % 3])] = face;
    faces[face] = std::move(corners);
  };
  for (std::size_t f = 0; f < faces.size(); ++f) enter(static_cast<std::int32_t>(f), faces[f]);
  for (std::int32_t i = 0; i < flip_count; ++i) {
    const std::int32_t face = random.below(static_cast<std::int32_t>(faces.size()));
    const std::int32_t corner = random.below(3);
    const std::int32_t a = faces[face][corner];
    const std::int32_t b = faces[face][(corner + 1) % 3];
    const std::int32_t c = faces[face][(corner + 2) % 3];
    const std::int32_t other = face_at.at(directed(b, a));
    std::int32_t d = 0;
    for (const std::int32_t v : faces[other]) {
      if (v != a && v != b) d = v;
    }
    if (face_at.contains(directed(c, d)) || face_at.contains(directed(d, c))) continue;
    if (valences[a] <= kLeastValence || valences[b] <= kLeastValence) continue;
    if (valences[c] >= kGreatestValence || valences[d] >= kGreatestValence) continue;
    face_at.erase(directed(a, b));
    face_at.erase(directed(b, a));
    enter(face, {c, d, b});
    enter(other, {d, c, a});
    --valences[a], --valences[b], ++valences[c], ++valences[d];
  }
}

// Moves every vertex to the mean of its neighbours on the unit sphere, many times: an embedding
// without overlaps.
void smooth_on_sphere(PolygonMesh& mesh) {
  constexpr int kSteps = 300;
  for (int step = 0; step < kSteps; ++step) {
    std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const glm::dvec3 normal = face_normal(mesh, f);
      glm::dvec3 centroid(0.0);
      for (const std::int32_t v : mesh.face(f)) centroid += mesh.positions[v] / 3.0;
      // Weights by area keep the mesh from gathering on one side.
      for (const std::int32_t v : mesh.face(f)) sums[v] += centroid * glm::length(normal);
    }
    for (std::size_t v = 0; v < sums.size(); ++v) mesh.positions[v] = glm::normalize(sums[v]);
  }
}

// Evens out a mesh of three edges at every vertex: each vertex towards the mean of its neighbours.
void smooth_dual(PolygonMesh& mesh) {
  constexpr int kSteps = 40;
  for (int step = 0; step < kSteps; ++step) {
    std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const auto corners = mesh.face(f);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        sums[corners[i]] += mesh.positions[corners[(i + 1) % corners.size()]];
      }
    }
    for (std::size_t v = 0; v < sums.size(); ++v) {
      mesh.positions[v] = glm::normalize(mesh.positions[v] + sums[v] / 3.0);
    }
  }
}

}  // namespace

PolygonMesh dual(const PolygonMesh& mesh) {
  PolygonMesh result;
  std::vector<std::unordered_map<std::int32_t, std::pair<std::int32_t, std::int32_t>>> around(
      mesh.positions.size());  // by incoming neighbour: face and outgoing neighbour
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      sum += mesh.positions[corners[i]];
      const std::int32_t previous = corners[(i + corners.size() - 1) % corners.size()];
      around[corners[i]][corners[(i + 1) % corners.size()]] = {f, previous};
    }
    result.positions.push_back(sum / static_cast<double>(corners.size()));
  }
  for (std::size_t v = 0; v < around.size(); ++v) {
    if (around[v].empty()) continue;
    std::int32_t first = around[v].begin()->first;
    for (const auto& [neighbour, unused] : around[v]) first = std::min(first, neighbour);
    Polygon polygon;
    std::int32_t neighbour = first;
    do {
      const auto [face, next] = around[v].at(neighbour);
      polygon.push_back(face);
      neighbour = next;
    } while (neighbour != first);
    result.add_face(polygon);
  }
  return result;
}

PolygonMesh random_polygon_mesh(const RandomMeshOptions& options) {
  RandomNumbers random(options.seed);
  const PolygonMesh sphere = icosphere(options.level);
  std::vector<Polygon> faces = polygons_of(sphere);
  std::vector<FacePair> pairs = face_pairs_of(sphere);
  std::vector<std::int32_t> valences(sphere.positions.size(), 0);
  for (const FacePair& pair : pairs) ++valences[pair.v0], ++valences[pair.v1];
  std::vector<std::int32_t> parents(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) parents[f] = static_cast<std::int32_t>(f);
  shuffle(pairs, random);
  pairs.resize(static_cast<std::size_t>(options.merged_share * pairs.size()));
  for (const FacePair& pair : pairs) {
    const std::int32_t first = root_of(parents, pair.first);
    const std::int32_t second = root_of(parents, pair.second);
    if (first == second) continue;
    // Faces that meet elsewhere too would leave a vertex of valence 2 or a hole.
    if (shared_vertex_count(faces[first], faces[second]) != 2) continue;
    if (valences[pair.v0] <= 3 || valences[pair.v1] <= 3) continue;
    Polygon face = merged(faces[first], faces[second], pair.v0, pair.v1);
    if (static_cast<std::int32_t>(face.size()) > options.largest_face) continue;
    faces[first] = std::move(face);
    parents[second] = first;
    --valences[pair.v0], --valences[pair.v1];
  }
  PolygonMesh mesh;
  mesh.positions = sphere.positions;
  const double edge =
      glm::distance(sphere.positions[sphere.face(0)[0]], sphere.positions[sphere.face(0)[1]]);
  for (glm::dvec3& position : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] += options.jitter * edge * (2.0 * random.unit() - 1.0);
    }
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (parents[f] == static_cast<std::int32_t>(f)) mesh.add_face(faces[f]);
  }
  return mesh;
}

PolygonMesh mixed_polygons(std::uint32_t seed) {
  constexpr std::int32_t kLevel = 3;
  constexpr std::int32_t kFlipsPerFace = 1;
  const glm::dvec3 kAxes(1.0, 0.8, 0.6);
  RandomNumbers random(seed);
  PolygonMesh sphere = icosphere(kLevel);
  std::vector<Polygon> faces = polygons_of(sphere);
  std::vector<std::int32_t> valences(sphere.positions.size(), 0);
  for (const std::int32_t v : sphere.face_vertices) ++valences[v];
  flip_edges(faces, valences, kFlipsPerFace * sphere.face_count(), random);
  sphere.face_vertices.clear();
  sphere.face_offsets = {0};
  for (const Polygon& face : faces) sphere.add_face(face);
  smooth_on_sphere(sphere);
  PolygonMesh mesh = dual(sphere);
  smooth_dual(mesh);
  for (glm::dvec3& position : mesh.positions) position *= kAxes;
  return mesh;
}

}  // namespace planish::shapes
