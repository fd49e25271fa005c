#include "support/random_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include "support/meshes.h"

namespace planish::test {

using glm::dvec3;
using std::int32_t;

namespace {

// The standard's distributions differ between libraries; this generator (splitmix64) does not.
class Random {
 public:
  explicit Random(std::uint32_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  int below(std::size_t count) { return int(bits() % count); }
  double unit() { return double(bits() >> 11) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

template <class T>
void shuffle(std::vector<T>& items, Random& random) {
  for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random.below(i)]);
}

using VertexPair = std::pair<int32_t, int32_t>;

std::map<VertexPair, int> half_edge_faces(const FaceList& faces) {
  std::map<VertexPair, int> result;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (std::size_t i = 0; i < faces[f].size(); ++i) {
      result[{faces[f][i], faces[f][(i + 1) % faces[f].size()]}] = int(f);
    }
  }
  return result;
}

std::map<int32_t, int> face_counts(const FaceList& faces) {
  std::map<int32_t, int> counts;
  for (const auto& face : faces) {
    for (int32_t v : face) ++counts[v];
  }
  return counts;
}

// Joins the faces left and right of a->b, if the outcome is a simple polygon of at most 9 sides
// and leaves a and b at valence 3 or more.
void merge_across(FaceList& faces, int32_t a, int32_t b) {
  const auto half_edges = half_edge_faces(faces);
  const int left = half_edges.at({a, b}), right = half_edges.at({b, a});
  auto counts = face_counts(faces);
  std::vector<int32_t> f = faces[left], g = faces[right];
  const std::set<int32_t> in_f(f.begin(), f.end());
  const auto shared = std::count_if(g.begin(), g.end(), [&](int32_t v) { return in_f.count(v); });
  if (left == right || shared != 2 || counts[a] < 4 || counts[b] < 4) return;
  if (f.size() + g.size() - 2 > 9) return;
  std::rotate(f.begin(), std::find(f.begin(), f.end(), b), f.end());  // b ... a
  std::rotate(g.begin(), std::find(g.begin(), g.end(), a), g.end());  // a ... b
  f.insert(f.end(), g.begin() + 1, g.end() - 1);
  faces[left] = f;
  faces.erase(faces.begin() + right);
}

// Every vertex has one fan of faces: as many boundary half-edges leave it as there may be, 0 or 1.
bool is_manifold(const FaceList& faces) {
  const auto half_edges = half_edge_faces(faces);
  std::map<int32_t, int> leaving;
  for (const auto& [edge, face] : half_edges) {
    if (!half_edges.count({edge.second, edge.first})) ++leaving[edge.first];
  }
  return std::all_of(leaving.begin(), leaving.end(), [](auto& entry) { return entry.second < 2; });
}

PolygonMesh without_unused(const PolygonMesh& mesh) {
  std::map<int32_t, int32_t> index;
  std::vector<dvec3> positions;
  FaceList faces = faces_of(mesh);
  for (auto& face : faces) {
    for (int32_t& v : face) {
      const auto [at, is_new] = index.try_emplace(v, int32_t(positions.size()));
      if (is_new) positions.push_back(mesh.positions[v]);
      v = at->second;
    }
  }
  return make_mesh(positions, faces);
}

}  // namespace

PolygonMesh jittered(PolygonMesh mesh, double amount, std::uint32_t seed) {
  Random random(seed);
  for (dvec3& p : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) p[axis] += amount * (2 * random.unit() - 1);
  }
  return mesh;
}

PolygonMesh random_closed_mesh(std::uint32_t seed) {
  Random random(seed);
  const PolygonMesh sphere = jittered(icosphere(2), 0.08, seed);
  FaceList faces = faces_of(sphere);
  for (int attempt = 0; attempt < 250; ++attempt) {
    const auto face = faces[random.below(faces.size())];
    const int i = random.below(face.size());
    merge_across(faces, face[i], face[(i + 1) % face.size()]);
  }
  return without_unused(make_mesh(sphere.positions, faces));
}

PolygonMesh random_dual(int count, std::uint32_t seed) {
  Random random(seed);
  std::vector<dvec3> points;
  while (int(points.size()) < count) {
    const double x = 2 * random.unit() - 1, y = 2 * random.unit() - 1;
    const dvec3 p(x, y, 2 * random.unit() - 1);
    if (glm::length(p) > 0.1 && glm::length(p) < 1) points.push_back(glm::normalize(p));
  }
  std::vector<dvec3> centroids;
  std::map<VertexPair, std::pair<int32_t, int32_t>> after;  // triangle and third corner of an edge
  const auto add = [&](int32_t a, int32_t b, int32_t c) {
    const auto triangle = int32_t(centroids.size());
    centroids.push_back((points[a] + points[b] + points[c]) / 3.0);
    after[{a, b}] = {triangle, c};
    after[{b, c}] = {triangle, a};
    after[{c, a}] = {triangle, b};
  };
  for (int32_t a = 0; a < count; ++a) {
    for (int32_t b = a + 1; b < count; ++b) {
      for (int32_t c = b + 1; c < count; ++c) {
        const dvec3 normal = glm::cross(points[b] - points[a], points[c] - points[a]);
        int above = 0, below = 0;
        for (int32_t i = 0; i < count && (above == 0 || below == 0); ++i) {
          if (i == a || i == b || i == c) continue;
          ++(glm::dot(points[i] - points[a], normal) > 0 ? above : below);
        }
        if (above == 0) add(a, b, c);
        if (below == 0) add(a, c, b);
      }
    }
  }
  FaceList faces(points.size());
  for (int32_t p = 0; p < count; ++p) {
    const int32_t first = after.lower_bound({p, 0})->first.second;
    int32_t next = first;
    do {
      const auto [triangle, third] = after.at({p, next});
      faces[p].push_back(triangle);
      next = third;
    } while (next != first);
  }
  return make_mesh(centroids, faces);
}

PolygonMesh random_open_mesh(std::uint32_t seed) {
  Random random(seed + 1000);
  const PolygonMesh closed = random_closed_mesh(seed);
  FaceList faces = faces_of(closed);
  for (int attempt = 0; attempt < 25; ++attempt) {
    FaceList fewer = faces;
    fewer.erase(fewer.begin() + random.below(fewer.size()));
    if (is_manifold(fewer)) faces = fewer;
  }
  return without_unused(make_mesh(closed.positions, faces));
}

PolygonMesh with_random_creases(PolygonMesh mesh, double probability, std::uint32_t seed) {
  Random random(seed);
  for (const auto& [edge, face] : half_edge_faces(faces_of(mesh))) {
    if (edge.first < edge.second && random.unit() < probability) {
      mesh.creases.push_back({edge.first, edge.second});
    }
  }
  return mesh;
}

PolygonMesh laden_mesh(std::uint32_t seed) {
  PolygonMesh mesh = with_random_creases(random_open_mesh(seed), 0.1, seed);
  for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c) {
    // Some vertices are seams.
    const std::int32_t v = mesh.face_vertices[c];
    mesh.face_uvs.push_back(v % 5 == 0 ? static_cast<std::int32_t>(mesh.positions.size() + c) : v);
  }
  mesh.uvs.resize(mesh.positions.size() + mesh.face_vertices.size());
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i)
    mesh.uvs[i] = {0.25 * static_cast<double>(i % 7), 0.125 * static_cast<double>(i % 11)};
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
    mesh.colors.emplace_back(0.1f * static_cast<float>(v % 10), 0.5f, 0.25f, 1.0f);
  mesh.attributes = {{"heat", {}, 1}, {"five", {}, 5}};
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    mesh.attributes[0].values.push_back(0.5f * static_cast<float>(v % 9));
    for (int k = 0; k < 5; ++k)
      mesh.attributes[1].values.push_back(0.25f * static_cast<float>(v % (k + 3)));
  }
  mesh.groups = {{"a", "red"}, {"b", "blue"}};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    mesh.face_groups.push_back(f % 2);
    if (f % 6 == 1) mesh.hole_faces.push_back(f);
  }
  return mesh;
}

Relabelled relabelled(const PolygonMesh& mesh, std::uint32_t seed) {
  Random random(seed);
  Relabelled result;
  result.new_index.resize(mesh.positions.size());
  std::iota(result.new_index.begin(), result.new_index.end(), 0);
  shuffle(result.new_index, random);
  std::vector<dvec3> positions(mesh.positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    positions[result.new_index[v]] = mesh.positions[v];
  }
  FaceList faces = faces_of(mesh);
  shuffle(faces, random);
  for (auto& face : faces) {
    std::rotate(face.begin(), face.begin() + random.below(face.size()), face.end());
    for (int32_t& v : face) v = result.new_index[v];
  }
  result.mesh = make_mesh(positions, faces);
  for (CreaseEdge crease : mesh.creases) {
    crease.v0 = result.new_index[crease.v0];
    crease.v1 = result.new_index[crease.v1];
    result.mesh.creases.push_back(crease);
  }
  for (CornerVertex corner : mesh.corners) {
    corner.vertex = result.new_index[corner.vertex];
    result.mesh.corners.push_back(corner);
  }
  return result;
}

namespace {

std::vector<dvec3> random_directions(int count, std::uint32_t seed) {
  Random random(seed);
  std::vector<dvec3> points;
  for (int i = 0; i < count; ++i) {
    const double z = 2 * random.unit() - 1, angle = 2 * std::numbers::pi * random.unit();
    const double radius = std::sqrt(1 - z * z);
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return points;
}

}  // namespace

PolygonMesh delaunay_sphere(int count, std::uint32_t seed) {
  const std::vector<dvec3> points = random_directions(count, seed);
  // Incremental hull: faces that see the new point make way for a fan from their rim.
  using Triangle = std::array<int32_t, 3>;
  const auto volume = [&](const Triangle& t, const dvec3& p) {
    return glm::dot(glm::cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]),
                    p - points[t[0]]);
  };
  std::vector<Triangle> faces{{0, 1, 2}, {0, 2, 1}};
  if (volume(faces[0], points[3]) > 0) std::swap(faces[0], faces[1]);
  faces = {faces[0],
           {faces[0][1], faces[0][0], 3},
           {faces[0][2], faces[0][1], 3},
           {faces[0][0], faces[0][2], 3}};
  for (int32_t p = 4; p < count; ++p) {
    std::map<std::pair<int32_t, int32_t>, bool> seen_edges;
    std::vector<Triangle> kept;
    for (const Triangle& t : faces) {
      if (volume(t, points[p]) <= 0) {
        kept.push_back(t);
        continue;
      }
      for (int i = 0; i < 3; ++i) seen_edges[{t[i], t[(i + 1) % 3]}] = true;
    }
    for (const auto& [edge, seen] : seen_edges) {
      if (!seen_edges.count({edge.second, edge.first}))
        kept.push_back({edge.first, edge.second, p});
    }
    faces = std::move(kept);
  }
  FaceList lists;
  for (const Triangle& t : faces) lists.push_back({t[0], t[1], t[2]});
  return make_mesh(points, lists);
}

}  // namespace planish::test
