#include "planish/refine/refine_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <numeric>
#include <ranges>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/mesh/angle_between.h"
#include "planish/mesh/triangulate.h"

namespace planish {
namespace {

constexpr std::size_t kSumPiece = 4096;
// Faces that turn by more do not sample a smooth surface: each side is looked at by itself.
constexpr double kTurnsNoMore = glm::radians(60.0);

bool is_hole(std::span<const std::int32_t> holes, std::int32_t face) {
  return std::ranges::binary_search(holes, face);
}

// What rides on a mesh, asked of places on its faces.
class Riders {
 public:
  Riders(const PolygonMesh& mesh, const PreparedMesh& prepared)
      : mesh_(mesh), topology_(*prepared.topology), vertices_(prepared.vertices) {
    holes_ = mesh.hole_faces;
    std::ranges::sort(holes_);
    sharpness_.assign(topology_.edge_count(), 0.0f);
    std::vector<std::int32_t> number(mesh.positions.size(), -1);
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      number[vertices_[i]] = static_cast<std::int32_t>(i);
    for (const CreaseEdge& crease : mesh.creases) {
      const std::int32_t a = number[crease.v0], b = number[crease.v1];
      const std::int32_t edge = a < 0 || b < 0 ? -1 : topology_.find_edge(a, b);
      if (edge >= 0) sharpness_[edge] = std::max(sharpness_[edge], crease.sharpness);
    }
  }

  [[nodiscard]] bool is_crease(std::int32_t edge) const {
    return sharpness_[edge] >= kInfiniteSharpness;
  }
  // Across which no smooth surface can be guessed.
  [[nodiscard]] std::vector<char> sharp_edges() const {
    std::vector<char> is_sharp(sharpness_.size());
    parallel_each(is_sharp.size(), [&](std::size_t e) {
      const auto edge = static_cast<std::int32_t>(e);
      is_sharp[e] = is_crease(edge) || turn(edge) > kTurnsNoMore;
    });
    return is_sharp;
  }
  // By which the faces turn at an edge, in radians; 0 at a boundary.
  [[nodiscard]] double turn(std::int32_t edge) const {
    const std::int32_t corner = topology_.corner_of(edge), twin = topology_.twin(corner);
    if (twin < 0) return 0;
    return angle_between(normal(topology_.face_of(corner)), normal(topology_.face_of(twin)));
  }
  [[nodiscard]] double length(std::int32_t edge) const {
    const auto [a, b] = topology_.edge_vertices(edge);
    return glm::distance(position(a), position(b));
  }
  [[nodiscard]] float sharpness(std::int32_t edge) const { return sharpness_[edge]; }

  // Edges that have a tag, or other riders on their two sides.
  [[nodiscard]] std::vector<char> lines() const {
    std::vector<char> is_line(sharpness_.size(), 0);
    parallel_each(is_line.size(), [&](std::size_t e) {
      const std::int32_t corner = topology_.corner_of(static_cast<std::int32_t>(e));
      const std::int32_t twin = topology_.twin(corner);
      if (twin < 0) return;
      const std::int32_t f = topology_.face_of(corner), g = topology_.face_of(twin);
      is_line[e] = sharpness_[e] > 0 || group(f) != group(g) ||
                   is_hole(holes_, f) != is_hole(holes_, g) ||
                   uv(corner) != uv(topology_.next(twin)) || uv(topology_.next(corner)) != uv(twin);
    });
    return is_line;
  }

  [[nodiscard]] bool hole(std::int32_t face) const { return is_hole(holes_, face); }

  // Colours and attributes of the added vertices.
  void add_vertices(std::span<const FacePlace> places, PolygonMesh& to) const {
    const auto first = to.positions.size() - places.size();
    if (!mesh_.colors.empty()) {
      to.colors.resize(to.positions.size());
      for (std::size_t i = 0; i < places.size(); ++i) {
        glm::dvec4 color(0);
        for (int k = 0; k < 3; ++k)
          color += places[i].weights[k] * glm::dvec4(mesh_.colors[vertex(places[i], k)]);
        to.colors[first + i] = color;
      }
    }
    for (VertexAttribute& attribute : to.attributes) {
      const auto width = static_cast<std::size_t>(attribute.width);
      attribute.values.resize(width * to.positions.size());
      for (std::size_t i = 0; i < places.size(); ++i)
        for (std::size_t j = 0; j < width; ++j) {
          double value = 0;
          for (int k = 0; k < 3; ++k)
            value += places[i].weights[k] *
                     attribute.values[width * static_cast<std::size_t>(vertex(places[i], k)) + j];
          attribute.values[width * (first + i) + j] = static_cast<float>(value);
        }
    }
  }

  // Texture coordinates of the corners of `even`, whose vertices are numbered without unused ones.
  void add_uvs(const EvenTriangles& even, PolygonMesh& to) const {
    if (mesh_.face_uvs.empty()) return;
    to.face_uvs.reserve(even.corner_places.size());
    // Of each added vertex, by the given face on whose side the corner is: one, or two on lines.
    const std::size_t given = even.positions.size() - even.places.size();
    std::vector<std::array<std::pair<std::int32_t, std::int32_t>, 2>> made(
        even.places.size(), {std::pair{-1, -1}, std::pair{-1, -1}});
    for (std::size_t c = 0; c < even.corner_places.size(); ++c) {
      const FacePlace& place = even.corner_places[c];
      const auto v = static_cast<std::size_t>(even.triangles[c / 3][c % 3]);
      const std::int32_t corner = topology_.first_corner(place.face);
      if (v < given) {
        const int k = place.weights.x > 0.5 ? 0 : place.weights.y > 0.5 ? 1 : 2;
        to.face_uvs.push_back(uv(corner + k));
        continue;
      }
      auto& sides = made[v - given];
      auto& side = sides[0].first < 0 || sides[0].first == place.face ? sides[0] : sides[1];
      if (side.first < 0) side = {place.face, added_uv(place, corner, to)};
      to.face_uvs.push_back(side.second);
    }
  }

 private:
  const PolygonMesh& mesh_;
  const MeshTopology& topology_;
  std::span<const std::int32_t> vertices_;
  std::vector<std::int32_t> holes_;  // ascending
  std::vector<float> sharpness_;     // by edge

  [[nodiscard]] const glm::dvec3& position(std::int32_t vertex) const {
    return mesh_.positions[vertices_[vertex]];
  }
  [[nodiscard]] glm::dvec3 normal(std::int32_t face) const {
    const std::span<const std::int32_t> v = topology_.face(face);
    const glm::dvec3& a = position(v[0]);
    return glm::cross(position(v[1]) - a, position(v[2]) - a);
  }
  [[nodiscard]] std::int32_t group(std::int32_t face) const {
    return mesh_.face_groups.empty() ? 0 : mesh_.face_groups[face];
  }
  [[nodiscard]] std::int32_t uv(std::int32_t corner) const {
    return mesh_.face_uvs.empty() ? -1 : mesh_.face_uvs[corner];
  }
  [[nodiscard]] std::int32_t vertex(const FacePlace& place, int corner) const {
    return vertices_[topology_.face(place.face)[corner]];
  }
  [[nodiscard]] std::int32_t added_uv(const FacePlace& place, std::int32_t corner,
                                      PolygonMesh& to) const {
    glm::dvec2 sum(0);
    for (int k = 0; k < 3; ++k) {
      if (uv(corner + k) < 0) return -1;
      sum += place.weights[k] * mesh_.uvs[uv(corner + k)];
    }
    to.uvs.push_back(sum);
    return static_cast<std::int32_t>(to.uvs.size()) - 1;
  }
};

bool are_triangles(const PolygonMesh& mesh) {
  return mesh.face_vertices.size() == 3 * static_cast<std::size_t>(mesh.face_count()) &&
         std::ranges::all_of(std::views::iota(0, mesh.face_count()),
                             [&](std::int32_t f) { return mesh.face_size(f) == 3; });
}

// Faces in the order of the given ones that they lie over, added vertices in that of the faces:
// what is drawn, packed or cut into parts by numbers keeps together what lies together.
void order_by_hosts(EvenTriangles& even) {
  std::vector<std::int32_t> order(even.triangles.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::int32_t f) { return even.source_faces[f]; });
  EvenTriangles made = even;
  const std::size_t given = even.positions.size() - even.places.size();
  std::vector<std::int32_t> number(even.positions.size(), -1);
  std::iota(number.begin(), number.begin() + static_cast<std::ptrdiff_t>(given), 0);
  auto next = static_cast<std::int32_t>(given);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto from = static_cast<std::size_t>(order[i]);
    made.source_faces[i] = even.source_faces[from];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t v = even.triangles[from][k];
      if (number[v] < 0) number[v] = next++;
      made.triangles[i][k] = number[v];
      made.corner_places[3 * i + k] = even.corner_places[3 * from + k];
    }
  }
  for (std::size_t v = given; v < even.positions.size(); ++v) {
    made.positions[number[v]] = even.positions[v];
    made.places[number[v] - given] = even.places[v - given];
  }
  for (LinePart& part : made.lines) {
    part.v0 = number[part.v0];
    part.v1 = number[part.v1];
  }
  even = std::move(made);
}

// Quads have even rings of their own: they gain nothing.
bool are_mostly_quads(const PolygonMesh& mesh) {
  std::int64_t quads = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) quads += mesh.face_size(f) == 4;
  return 2 * quads >= mesh.face_count();
}

// Larger faces in triangles; what rides on the mesh rides on.
struct CutMesh {
  PolygonMesh mesh;
  std::vector<std::int32_t> source_faces;
};

CutMesh in_triangles(const PolygonMesh& mesh) {
  CutMesh cut{mesh, {}};
  PolygonMesh& to = cut.mesh;
  to.face_offsets = {0};
  for (auto* const list : {&to.face_vertices, &to.face_uvs, &to.face_groups, &to.hole_faces})
    list->clear();
  std::vector<std::int32_t> holes = mesh.hole_faces, places;
  std::ranges::sort(holes);
  std::vector<glm::dvec3> points;
  std::vector<std::uint32_t> parts;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::int32_t> face = mesh.face(f);
    const std::int32_t first = mesh.face_offsets[f];
    places.resize(face.size());
    std::iota(places.begin(), places.end(), 0);
    points.clear();
    for (const std::int32_t v : face) points.push_back(mesh.positions[v]);
    parts.resize(3 * (face.size() - 2));
    triangulate(places, points, parts);
    for (std::size_t i = 0; i < parts.size(); i += 3) {
      to.add_face(std::array{face[parts[i]], face[parts[i + 1]], face[parts[i + 2]]});
      for (std::size_t k = i; k < i + 3 && !mesh.face_uvs.empty(); ++k)
        to.face_uvs.push_back(mesh.face_uvs[first + parts[k]]);
      if (!mesh.face_groups.empty()) to.face_groups.push_back(mesh.face_groups[f]);
      if (is_hole(holes, f)) to.hole_faces.push_back(to.face_count() - 1);
      cut.source_faces.push_back(f);
    }
  }
  return cut;
}

std::optional<RefinedMesh> refine_triangles(const PolygonMesh& mesh, const PreparedMesh& prepared) {
  std::vector<glm::dvec3> used(prepared.vertices.size());
  for (std::size_t i = 0; i < used.size(); ++i) used[i] = mesh.positions[prepared.vertices[i]];
  const Riders riders(mesh, prepared);
  EvenTriangles even =
      make_even_triangles(used, *prepared.topology, riders.lines(), riders.sharp_edges());
  if (even.places.empty()) return std::nullopt;
  order_by_hosts(even);
  RefinedMesh made;
  PolygonMesh& to = made.mesh;
  to.positions = mesh.positions;
  to.positions.insert(to.positions.end(), even.positions.begin() + std::ssize(used),
                      even.positions.end());
  // Unused vertices stay among the given ones.
  const auto number = [&](std::int32_t v) {
    const auto given = static_cast<std::int32_t>(used.size());
    return v < given ? prepared.vertices[v] : mesh.vertex_count() + v - given;
  };
  for (const auto& [a, b, c] : even.triangles)
    to.add_face(std::array{number(a), number(b), number(c)});
  for (const LinePart& part : even.lines)
    if (const float sharpness = riders.sharpness(part.edge); sharpness > 0)
      to.creases.push_back({number(part.v0), number(part.v1), sharpness});
  to.corners = mesh.corners;
  to.uvs = mesh.uvs;
  to.colors = mesh.colors;
  to.attributes = mesh.attributes;
  riders.add_vertices(even.places, to);
  riders.add_uvs(even, to);
  to.groups = mesh.groups;
  for (std::size_t f = 0; f < even.source_faces.size(); ++f) {
    const std::int32_t source = even.source_faces[f];
    if (!mesh.face_groups.empty()) to.face_groups.push_back(mesh.face_groups[source]);
    if (riders.hole(source)) to.hole_faces.push_back(static_cast<std::int32_t>(f));
  }
  made.source_faces = std::move(even.source_faces);
  made.added.reserve(even.places.size());
  for (const FacePlace& place : even.places) {
    const std::span<const std::int32_t> v = prepared.topology->face(place.face);
    const auto doubts =
        std::span(even.doubts).subspan(prepared.topology->first_corner(place.face), 3);
    made.added.push_back({{number(v[0]), number(v[1]), number(v[2])},
                          place.weights,
                          glm::dot(place.weights, glm::dvec3(doubts[0], doubts[1], doubts[2]))});
  }
  return made;
}

}  // namespace

std::optional<RefinedMesh> refine_mesh(const PolygonMesh& mesh, const PreparedMesh& prepared) {
  if (are_triangles(mesh)) return refine_triangles(mesh, prepared);
  if (are_mostly_quads(mesh)) return std::nullopt;
  CutMesh cut = in_triangles(mesh);
  // A diagonal may run where the mesh has an edge.
  const auto cut_prepared = prepare_if_sound(cut.mesh);
  if (!cut_prepared) return std::nullopt;
  std::optional<RefinedMesh> made = refine_triangles(cut.mesh, *cut_prepared);
  if (!made) return std::nullopt;
  for (std::int32_t& face : made->source_faces) face = cut.source_faces[face];
  return made;
}

double rms_turn(const PolygonMesh& mesh, const PreparedMesh& prepared) {
  const Riders riders(mesh, prepared);
  struct Sum {
    double squares = 0, length = 0;
  };
  const Sum sum = ordered_reduce(
      static_cast<std::size_t>(prepared.topology->edge_count()), kSumPiece, Sum{},
      [&](std::size_t begin, std::size_t end) {
        Sum part;
        for (auto e = static_cast<std::int32_t>(begin); e < static_cast<std::int32_t>(end); ++e) {
          if (riders.is_crease(e)) continue;
          const double length = riders.length(e), turn = riders.turn(e);
          part.squares += length * turn * turn;
          part.length += length;
        }
        return part;
      },
      [](Sum& total, const Sum& part) {
        total.squares += part.squares;
        total.length += part.length;
      });
  return sum.length > 0 ? glm::degrees(std::sqrt(sum.squares / sum.length)) : 0;
}

}  // namespace planish
