#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/mend/faults.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {
namespace {

using VertexPair = std::pair<std::int32_t, std::int32_t>;

// The steps for one mesh.
class FlatTriangles {
 public:
  FlatTriangles(const PolygonMesh& mesh, const MeshTopology& topology, bool adds_uvs)
      : mesh_(mesh),
        topology_(topology),
        adds_uvs_(adds_uvs),
        diagonal_(placement_of(mesh).diagonal) {}

  UnflattenedMesh run() {
    const auto face_count = static_cast<std::size_t>(mesh_.face_count());
    const bool is_any = ordered_reduce(
        face_count, 4096, false,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t f = begin; f < end; ++f)
            if (longest_side(static_cast<std::int32_t>(f))) return true;
          return false;
        },
        [](bool& total, bool found) { total |= found; });
    if (!is_any) return {};
    for (const CreaseEdge& crease : mesh_.creases)
      tagged_.insert(std::minmax(crease.v0, crease.v1));
    is_taken_.assign(face_count, 0);
    for (const std::int32_t hole : mesh_.hole_faces)
      if (hole >= 0 && hole < mesh_.face_count()) is_taken_[hole] = 1;
    for (std::int32_t f = 0; f < mesh_.face_count(); ++f)
      if (const auto corner = longest_side(f)) take_out(f, *corner);
    if (result_.flat_faces.empty()) return {};
    assemble();
    return std::move(result_);
  }

 private:
  [[nodiscard]] const glm::dvec3& at(std::int32_t corner) const {
    return mesh_.positions[mesh_.face_vertices[corner]];
  }
  // In units of the diagonal, whose squares are numbers however small the mesh is.
  [[nodiscard]] glm::dvec3 along(std::int32_t from, std::int32_t to) const {
    return (at(to) - at(from)) / diagonal_;
  }
  [[nodiscard]] std::int32_t uv_at(std::int32_t corner) const {
    return mesh_.face_uvs.empty() ? -1 : mesh_.face_uvs[corner];
  }

  // The corner where that of a flat triangle begins.
  [[nodiscard]] std::optional<std::int32_t> longest_side(std::int32_t face) const {
    if (mesh_.face_size(face) != 3) return std::nullopt;
    const std::int32_t first = mesh_.face_offsets[face];
    std::array<glm::dvec3, 3> sides;
    std::array<double, 3> lengths;
    for (std::int32_t i = 0; i < 3; ++i) {
      sides[i] = along(first + i, first + (i + 1) % 3);
      lengths[i] = glm::length(sides[i]);
    }
    const auto side = std::ranges::max_element(lengths) - lengths.begin();
    const double longest = lengths[side];
    const double height = glm::length(glm::cross(sides[0], sides[1])) / longest;
    // With a short side it is a needle, of which no corner lies within a side.
    if (std::ranges::min(lengths) <= kShortEdge ||
        height > std::min(kShortEdge, kShortShare * longest))
      return std::nullopt;
    return first + static_cast<std::int32_t>(side);
  }

  void take_out(std::int32_t face, std::int32_t corner);
  [[nodiscard]] std::optional<std::int32_t> uv_within(std::int32_t corner, std::int32_t twin,
                                                      std::int32_t within);
  void assemble();

  const PolygonMesh& mesh_;
  const MeshTopology& topology_;
  bool adds_uvs_;
  double diagonal_;
  UnflattenedMesh result_;
  std::set<VertexPair> tagged_, made_;
  std::vector<std::uint8_t> is_taken_;  // by face: it goes, or takes a vertex
  struct Taken {
    std::int32_t twin, vertex, uv;  // the vertex comes after that corner
  };
  std::unordered_map<std::int32_t, Taken> takes_;  // by face
  std::vector<glm::dvec2> added_uvs_;
};

// `corner` begins its longest side.
void FlatTriangles::take_out(std::int32_t face, std::int32_t corner) {
  if (is_taken_[face] != 0) return;
  const std::int32_t within = topology_.prev(corner), twin = topology_.twin(corner);
  const std::int32_t vertex = mesh_.face_vertices[within];
  const VertexPair side =
      std::minmax(mesh_.face_vertices[corner], mesh_.face_vertices[topology_.next(corner)]);
  if (tagged_.contains(side)) return;
  if (twin < 0) {
    if (topology_.is_boundary_vertex(topology_.vertex_of(within))) return;
  } else {
    const std::int32_t other = topology_.face_of(twin);
    if (is_taken_[other] != 0) return;
    if (mesh_.face_size(other) == 3) {
      const std::int32_t across = topology_.prev(twin);
      const VertexPair edge = std::minmax(vertex, mesh_.face_vertices[across]);
      const std::int32_t a = topology_.vertex_of(within), b = topology_.vertex_of(across);
      if (a == b || topology_.find_edge(a, b) >= 0 || made_.contains(edge)) return;
      made_.insert(edge);
    } else if (std::ranges::find(mesh_.face(other), vertex) != mesh_.face(other).end()) {
      return;
    }
    const auto uv = uv_within(corner, twin, within);
    if (!uv) return;
    takes_.emplace(other, Taken{twin, vertex, *uv});
    is_taken_[other] = 1;
    result_.changed_faces.push_back(other);
  }
  is_taken_[face] = 1;
  result_.flat_faces.push_back(face);
  result_.changed_faces.push_back(face);
}

// The texture coordinates of the vertex in the face that takes it; nothing where it may have none.
std::optional<std::int32_t> FlatTriangles::uv_within(std::int32_t corner, std::int32_t twin,
                                                     std::int32_t within) {
  const std::int32_t begin = uv_at(topology_.next(twin)), end = uv_at(twin);
  if (begin < 0 || end < 0) return -1;
  if (begin == uv_at(corner) && end == uv_at(topology_.next(corner))) return uv_at(within);
  if (!adds_uvs_) return std::nullopt;
  const double part =
      glm::length(along(corner, within)) / glm::length(along(corner, topology_.next(corner)));
  added_uvs_.push_back(glm::mix(mesh_.uvs[begin], mesh_.uvs[end], part));
  return static_cast<std::int32_t>(mesh_.uvs.size() + added_uvs_.size()) - 1;
}

void FlatTriangles::assemble() {
  PolygonMesh& made = result_.mesh;
  made = mesh_;
  made.uvs.insert(made.uvs.end(), added_uvs_.begin(), added_uvs_.end());
  made.face_offsets = {0};
  made.face_vertices.clear();
  made.face_uvs.clear();
  made.face_groups.clear();
  made.hole_faces.clear();
  std::vector<std::int32_t> vertices, uvs;
  const auto add = [&](std::int32_t face, std::span<const std::size_t> places) {
    for (const std::size_t place : places) {
      made.face_vertices.push_back(vertices[place]);
      if (!mesh_.face_uvs.empty()) made.face_uvs.push_back(uvs[place]);
    }
    made.face_offsets.push_back(static_cast<std::int32_t>(made.face_vertices.size()));
    if (!mesh_.face_groups.empty()) made.face_groups.push_back(mesh_.face_groups[face]);
    result_.source_faces.push_back(face);
  };
  const std::set<std::int32_t> flat(result_.flat_faces.begin(), result_.flat_faces.end());
  const std::set<std::int32_t> holes(mesh_.hole_faces.begin(), mesh_.hole_faces.end());
  std::vector<std::size_t> places;
  for (std::int32_t f = 0; f < mesh_.face_count(); ++f) {
    if (flat.contains(f)) continue;
    if (holes.contains(f)) made.hole_faces.push_back(made.face_count());
    vertices.clear();
    uvs.clear();
    const auto taken = takes_.find(f);
    const bool takes = taken != takes_.end();
    const std::int32_t first = mesh_.face_offsets[f], size = mesh_.face_size(f);
    const std::int32_t start = takes ? taken->second.twin - first : 0;
    for (std::int32_t i = 0; i < size; ++i) {
      const std::int32_t corner = first + (start + i) % size;
      vertices.push_back(mesh_.face_vertices[corner]);
      uvs.push_back(uv_at(corner));
      if (i > 0 || !takes) continue;
      vertices.push_back(taken->second.vertex);
      uvs.push_back(taken->second.uv);
    }
    if (takes && size == 3) {
      add(f, std::array<std::size_t, 3>{0, 1, 3});
      add(f, std::array<std::size_t, 3>{1, 2, 3});
      continue;
    }
    places.resize(vertices.size());
    for (std::size_t i = 0; i < places.size(); ++i) places[i] = i;
    add(f, places);
  }
  std::ranges::sort(result_.changed_faces);
}

}  // namespace

UnflattenedMesh without_flat_triangles(const PolygonMesh& mesh, const MeshTopology& topology,
                                       bool adds_uvs) {
  return FlatTriangles(mesh, topology, adds_uvs).run();
}

namespace {

constexpr double kCuspReach = kCuspReachDegrees * std::numbers::pi / 180;

}  // namespace

PolygonMesh with_cusp_corners(const PolygonMesh& mesh) {
  // Of a checked mesh a boundary vertex has one boundary edge that leaves it and one that comes.
  std::vector<std::int32_t> next(mesh.positions.size(), -1), previous(mesh.positions.size(), -1);
  const std::vector<std::uint8_t> all(static_cast<std::size_t>(mesh.face_count()), 1);
  group_edges(mesh, all).for_each([&](std::int32_t, std::span<const FaceSide> sides) {
    if (sides.size() > 1) return;
    const FaceSide& side = sides.front();
    const std::int32_t from = mesh.face_vertices[side.corner];
    const std::int32_t to = mesh.face_vertices[next_corner(mesh, side.face, side.corner)];
    next[from] = to;
    previous[to] = from;
  });
  std::vector<std::uint8_t> tagged(mesh.positions.size(), 0);
  for (const CornerVertex& corner : mesh.corners) {
    if (corner.sharpness >= kInfiniteSharpness) tagged[corner.vertex] = 1;
  }
  // How far the faces at a vertex reach around it: beside steep faces a tip's lips may lie over
  // each other, and the boundary turns by less.
  std::vector<double> reach(mesh.positions.size(), 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t k = 0; k < face.size(); ++k) {
      const std::int32_t v = face[k];
      if (next[v] >= 0)
        reach[v] += angle_between(
            mesh.positions[face[(k + 1) % face.size()]] - mesh.positions[v],
            mesh.positions[face[(k + face.size() - 1) % face.size()]] - mesh.positions[v]);
    }
  }
  PolygonMesh result = mesh;
  const double least_cosine = portable::cos(kCuspDegrees * std::numbers::pi / 180);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (next[v] < 0 || previous[v] < 0 || tagged[v]) continue;
    const glm::dvec3 in = mesh.positions[v] - mesh.positions[previous[v]];
    const glm::dvec3 out = mesh.positions[next[v]] - mesh.positions[v];
    if (glm::dot(in, out) < least_cosine * glm::length(in) * glm::length(out) ||
        reach[v] > kCuspReach) {
      result.corners.push_back({v, kInfiniteSharpness});
    }
  }
  return result;
}

namespace {

// The way round of a face in the texture; unknown where it has no area, or a corner no coordinate.
enum class Way : std::uint8_t { Unknown, Left, Right };

Way way_of(std::span<const std::int32_t> face, std::span<const glm::dvec2> uvs) {
  if (std::ranges::min(face) < 0) return Way::Unknown;
  double area = 0;
  for (std::size_t k = 0; k < face.size(); ++k) {
    const glm::dvec2& a = uvs[face[k]];
    const glm::dvec2& b = uvs[face[k + 1 < face.size() ? k + 1 : 0]];
    area += a.x * b.y - a.y * b.x;
  }
  return area > 0 ? Way::Left : area < 0 ? Way::Right : Way::Unknown;
}

std::span<std::int32_t> uvs_of_face(PolygonMesh& mesh, std::size_t face) {
  const auto begin = static_cast<std::size_t>(mesh.face_offsets[face]);
  return std::span(mesh.face_uvs)
      .subspan(begin, static_cast<std::size_t>(mesh.face_offsets[face + 1]) - begin);
}

// Of all faces; none where they all lie alike, as most do.
std::vector<Way> ways_of_faces(PolygonMesh& mesh, std::span<const glm::dvec2> uvs) {
  std::vector<Way> ways(static_cast<std::size_t>(mesh.face_count()), Way::Unknown);
  std::atomic<bool> has_left{false}, has_right{false};
  parallel_for(ways.size(), 4096, [&](std::size_t begin, std::size_t end) {
    bool left = false, right = false;
    for (std::size_t f = begin; f < end; ++f) {
      ways[f] = way_of(uvs_of_face(mesh, f), uvs);
      left = left || ways[f] == Way::Left;
      right = right || ways[f] == Way::Right;
    }
    if (left) has_left = true;
    if (right) has_right = true;
  });
  if (!has_left || !has_right) ways.clear();
  return ways;
}

}  // namespace

std::vector<std::int32_t> cut_mirrored_charts(PolygonMesh& mesh, std::span<const glm::dvec2> uvs) {
  std::vector<std::int32_t> copied;
  if (mesh.face_uvs.empty()) return copied;
  const std::vector<Way> ways_of = ways_of_faces(mesh, uvs);
  // The way round of the first face that has a texture coordinate is that one's.
  std::vector<Way> ways(ways_of.empty() ? 0 : uvs.size(), Way::Unknown);
  std::unordered_map<std::int32_t, std::int32_t> copies;
  for (std::size_t f = 0; f < ways_of.size(); ++f) {
    const Way way = ways_of[f];
    if (way == Way::Unknown) continue;
    for (std::int32_t& uv : uvs_of_face(mesh, f)) {
      Way& known = ways[uv];
      if (known == Way::Unknown) known = way;
      if (known == way) continue;
      const auto [copy, is_new] =
          copies.try_emplace(uv, static_cast<std::int32_t>(mesh.uvs.size() + copied.size()));
      if (is_new) copied.push_back(uv);
      uv = copy->second;
    }
  }
  for (const std::int32_t uv : copied) mesh.uvs.push_back(mesh.uvs[uv]);
  return copied;
}

}  // namespace planish
