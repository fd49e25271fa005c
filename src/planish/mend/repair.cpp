#include "planish/mend/repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {
namespace {

// Ears are looked for from every place after each cut: longer polygons would take minutes.
constexpr std::size_t kLongestKeyhole = 2000;

double double_area(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The polygon in its plane, and what is left of it.
struct Keyholed {
  std::span<const std::int32_t> vertices;
  std::vector<glm::dvec2> points;
  std::vector<std::int32_t> left;  // places

  [[nodiscard]] std::array<std::int32_t, 3> ear(std::size_t i) const {
    return {left[(i + left.size() - 1) % left.size()], left[i], left[(i + 1) % left.size()]};
  }
  // Its area, or 0 where it is no ear.
  [[nodiscard]] double ear_area(std::size_t i) const {
    const std::array<std::int32_t, 3> corners = ear(i);
    const std::int32_t p = corners[0], q = corners[1], r = corners[2];
    if (vertices[p] == vertices[r]) return 0;  // both sides of a bridge
    const glm::dvec2 &a = points[p], &b = points[q], &c = points[r];
    const double area = double_area(a, b, c);
    if (!(area > 0)) return 0;
    const bool is_clear = std::ranges::none_of(left, [&](std::int32_t place) {
      const std::int32_t v = vertices[place];
      if (v == vertices[p] || v == vertices[q] || v == vertices[r]) return false;
      const glm::dvec2& d = points[place];
      return double_area(a, b, d) >= 0 && double_area(b, c, d) >= 0 && double_area(c, a, d) >= 0;
    });
    return is_clear ? area : 0;
  }
};

// A polygon that names a vertex twice, as those do whose holes are joined to their outline by a
// bridge that runs forth and back, cut into triangles: ears in the plane of its vector area. Each
// triangle is of three places in `polygon`, of different vertices, and turns as the polygon does.
// Empty where no such triangles are found, as of polygons that cross themselves.
std::vector<std::array<std::int32_t, 3>> split_keyhole(std::span<const glm::dvec3> positions,
                                                       std::span<const std::int32_t> polygon) {
  std::vector<std::array<std::int32_t, 3>> triangles;
  const glm::dvec3 area = area_vector(positions, polygon);
  const double length = glm::length(area);
  if (polygon.size() > kLongestKeyhole || !(length > 0)) return {};
  const glm::dvec3 normal = area / length;
  const glm::dvec3 axis = std::abs(normal.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 u = glm::normalize(glm::cross(axis, normal)), v = glm::cross(normal, u);
  Keyholed shape{polygon, {}, std::vector<std::int32_t>(polygon.size())};
  std::iota(shape.left.begin(), shape.left.end(), 0);
  for (const std::int32_t vertex : polygon) {
    const glm::dvec3 from = positions[vertex] - positions[polygon[0]];
    shape.points.emplace_back(glm::dot(from, u), glm::dot(from, v));
  }
  // Below this share of the whole an ear is a line, which rounding took for one.
  const double least = 1e-12 * length;
  while (shape.left.size() > 2) {
    std::size_t at = 0;
    while (at < shape.left.size() && !(shape.ear_area(at) > least)) ++at;
    if (at == shape.left.size()) return {};
    triangles.push_back(shape.ear(at));
    shape.left.erase(shape.left.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return triangles;
}

using EdgeEnds = std::pair<std::int32_t, std::int32_t>;  // the lower vertex first

struct EdgeCopy {
  EdgeEnds original, ends;
  auto operator<=>(const EdgeCopy&) const = default;
};

void copy_creases(PolygonMesh& mesh, std::span<const std::int32_t> sources) {
  if (mesh.creases.empty()) return;
  std::vector<EdgeCopy> copies;
  group_edges(mesh).for_each([&](std::int32_t lower, std::span<const FaceSide> sides) {
    const std::int32_t higher = sides.front().higher;
    copies.push_back({std::minmax(sources[lower], sources[higher]), {lower, higher}});
  });
  std::ranges::sort(copies);
  const auto copies_of = [&](const CreaseEdge& crease) {
    // Not std::ranges::equal_range(), whose range Clang before 16 takes for none.
    const EdgeEnds ends(std::minmax(crease.v0, crease.v1));
    return std::span(std::ranges::lower_bound(copies, ends, {}, &EdgeCopy::original),
                     std::ranges::upper_bound(copies, ends, {}, &EdgeCopy::original));
  };
  // Of several tags of an edge the last one holds: several copies get that alone.
  std::vector<std::size_t> last_tags(copies.size());
  for (std::size_t i = 0; i < mesh.creases.size(); ++i) {
    const auto found = copies_of(mesh.creases[i]);
    if (!found.empty()) last_tags[found.data() - copies.data()] = i;
  }
  std::vector<CreaseEdge> creases;
  for (std::size_t i = 0; i < mesh.creases.size(); ++i) {
    const CreaseEdge& crease = mesh.creases[i];
    const auto found = copies_of(crease);
    if (found.empty()) creases.push_back(crease);
    if (found.size() > 1 && last_tags[found.data() - copies.data()] != i) continue;
    for (const EdgeCopy& copy : found)
      creases.push_back({copy.ends.first, copy.ends.second, crease.sharpness});
  }
  mesh.creases = std::move(creases);
}

// Of several tags of a vertex the last one holds for some schemes, any infinite one for others:
// copies get the sharpest and the last.
void copy_corners(PolygonMesh& mesh, std::span<const std::int32_t> sources,
                  std::int32_t original_count) {
  struct Tags {
    std::int32_t sharpest = -1, last = -1;
  };
  std::vector<Tags> tags(original_count);
  for (std::size_t i = 0; i < mesh.corners.size(); ++i) {
    const auto tag = static_cast<std::int32_t>(i);
    const std::int32_t vertex = mesh.corners[i].vertex;
    if (vertex < 0 || vertex >= original_count) continue;
    auto& [sharpest, last] = tags[vertex];
    if (sharpest < 0 || mesh.corners[i].sharpness >= mesh.corners[sharpest].sharpness)
      sharpest = tag;
    last = tag;
  }
  for (std::int32_t v = original_count; v < mesh.vertex_count(); ++v) {
    const auto [sharpest, last] = tags[sources[v]];
    if (last < 0) continue;
    if (sharpest != last) mesh.corners.push_back({v, mesh.corners[sharpest].sharpness});
    mesh.corners.push_back({v, mesh.corners[last].sharpness});
  }
}

// Creases and corners hold on every copy of their edge or vertex: makes tags of the copies from
// those of the originals. Vertices from `original_count` on are copies, `sources` has the original
// of every vertex. Creases that name no edge stay. Time and result are linear in vertices, edges
// and tags, but for a logarithm.
void copy_tags(PolygonMesh& mesh, std::span<const std::int32_t> sources,
               std::int32_t original_count) {
  copy_creases(mesh, sources);
  copy_corners(mesh, sources, original_count);
}

// Removes the tags that name no edge or used vertex, or whose sharpness is NaN; returns their
// number. Faces must have at least two corners and indices in range.
std::int64_t drop_unknown_tags(PolygonMesh& mesh) {
  if (mesh.creases.empty() && mesh.corners.empty()) return 0;
  const EdgeGroups edges = group_edges(mesh);
  std::vector<std::uint8_t> is_used(mesh.positions.size(), 0);
  for (const std::int32_t vertex : mesh.face_vertices) is_used[vertex] = 1;
  const std::size_t count = std::erase_if(mesh.creases,
                                          [&](const CreaseEdge& crease) {
                                            return std::isnan(crease.sharpness) ||
                                                   edges.find(crease.v0, crease.v1).empty();
                                          }) +
                            std::erase_if(mesh.corners, [&](const CornerVertex& corner) {
                              return std::isnan(corner.sharpness) || corner.vertex < 0 ||
                                     corner.vertex >= mesh.vertex_count() ||
                                     !is_used[corner.vertex];
                            });
  return static_cast<std::int64_t>(count);
}

using VertexPair = std::pair<std::int32_t, std::int32_t>;

// The steps in order, each leaving a mesh that the next can work on.
class Repair {
 public:
  explicit Repair(const PolygonMesh& input) : input_(input) {}

  RepairedMesh run() {
    drop_degenerate_faces();
    drop_duplicate_faces();
    orient();
    separate();
    drop_unknown();
    carry_attributes();
    result_.separated_edges.assign(cut_edges_.begin(), cut_edges_.end());
    std::ranges::sort(result_.changed_faces);
    std::vector<std::int32_t>& faces = result_.changed_faces;
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    return std::move(result_);
  }

 private:
  void drop_degenerate_faces();
  bool add_parts(std::int32_t face, std::span<const std::int32_t> corners,
                 std::span<const std::int32_t> sources);
  void drop_duplicate_faces();
  void orient();
  void separate();
  void copy_fans(DisjointSets& fans);
  void tag_cuts();
  void drop_unknown();
  void carry_attributes();

  void changed(std::int32_t face) { result_.changed_faces.push_back(result_.source_faces[face]); }
  void report(const char* code, const std::string& what, std::int64_t count, std::int64_t first) {
    if (count > 0)
      result_.changes.push_back({code, formatted("{}: {}", what, count), count, first});
  }
  [[nodiscard]] bool runs_from(const FaceSide& side, std::int32_t vertex) const {
    return mesh_.face_vertices[side.corner] == vertex;
  }

  const PolygonMesh& input_;
  RepairedMesh result_;
  PolygonMesh& mesh_ = result_.mesh;
  std::vector<std::int32_t> source_corners_;  // for each corner of mesh_ the input's
  std::set<VertexPair> cut_edges_;            // in the input's vertices
};

void Repair::drop_degenerate_faces() {
  mesh_.positions = input_.positions;
  mesh_.creases = input_.creases;
  mesh_.corners = input_.corners;
  result_.source_vertices.resize(mesh_.positions.size());
  for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) result_.source_vertices[v] = v;

  std::int64_t count = 0, first = -1, split_count = 0, first_split = -1, bare_count = 0,
               first_bare = -1;
  std::vector<std::int32_t> corners, sources, sorted;
  for (std::int32_t f = 0; f < input_.face_count(); ++f) {
    corners.clear();
    sources.clear();
    for (std::int32_t c = input_.face_offsets[f]; c < input_.face_offsets[f + 1]; ++c) {
      if (!corners.empty() && corners.back() == input_.face_vertices[c]) continue;
      corners.push_back(input_.face_vertices[c]);
      sources.push_back(c);
    }
    while (corners.size() > 1 && corners.back() == corners.front()) {
      corners.pop_back();
      sources.pop_back();
    }
    sorted = corners;
    std::ranges::sort(sorted);
    const bool repeats = std::ranges::adjacent_find(sorted) != sorted.end();
    if (repeats && add_parts(f, corners, sources)) {
      if (split_count++ == 0) first_split = f;
      continue;
    }
    if (input_.face(f).size() < 3) {
      if (bare_count++ == 0) first_bare = f;
      result_.changed_faces.push_back(f);
      continue;
    }
    const bool dropped = corners.size() < 3 || repeats;
    if (dropped || corners.size() != input_.face(f).size()) {
      if (count++ == 0) first = f;
      result_.changed_faces.push_back(f);
    }
    if (dropped) continue;
    mesh_.add_face(corners);
    source_corners_.insert(source_corners_.end(), sources.begin(), sources.end());
    result_.source_faces.push_back(f);
  }
  if (mesh_.face_count() == 0) {
    throw Error(ErrorCode::UnusableMesh, "no face with three different vertices is left");
  }
  report("keyholed-faces", "faces that name a vertex twice, as around a hole, cut in triangles",
         split_count, first_split);
  report("bare-faces", "faces of one or two corners, dropped", bare_count, first_bare);
  report("degenerate-faces", "faces that name a vertex twice, dropped or short of that corner now",
         count, first);
}

// The triangles of a keyholed polygon; false where it cannot be cut.
bool Repair::add_parts(std::int32_t face, std::span<const std::int32_t> corners,
                       std::span<const std::int32_t> sources) {
  const auto triangles = split_keyhole(mesh_.positions, corners);
  for (const auto& [a, b, c] : triangles) {
    mesh_.add_face(std::array{corners[a], corners[b], corners[c]});
    for (const std::int32_t place : {a, b, c}) source_corners_.push_back(sources[place]);
    result_.source_faces.push_back(face);
  }
  if (!triangles.empty()) result_.changed_faces.push_back(face);
  return !triangles.empty();
}

void Repair::drop_duplicate_faces() {
  std::set<std::int32_t> duplicates;
  for (const MeshProblem& problem : check(mesh_)) {
    if (problem.kind == MeshProblemKind::DuplicateFace) {
      duplicates.insert(static_cast<std::int32_t>(problem.element));
    }
  }
  if (duplicates.empty()) return;
  const PolygonMesh whole = mesh_;
  const std::vector<std::int32_t> sources = std::exchange(result_.source_faces, {});
  const std::vector<std::int32_t> corners = std::exchange(source_corners_, {});
  mesh_.face_offsets = {0};
  mesh_.face_vertices.clear();
  for (std::int32_t f = 0; f < whole.face_count(); ++f) {
    if (duplicates.contains(f)) {
      result_.changed_faces.push_back(sources[f]);
      continue;
    }
    mesh_.add_face(whole.face(f));
    source_corners_.insert(source_corners_.end(), corners.begin() + whole.face_offsets[f],
                           corners.begin() + whole.face_offsets[f + 1]);
    result_.source_faces.push_back(sources[f]);
  }
  report("duplicate-faces", "faces that repeat another one, dropped",
         static_cast<std::int64_t>(duplicates.size()), sources[*duplicates.begin()]);
}

// Spreads directions from face to face across edges of two faces, then turns the minority of each
// component round.
void Repair::orient() {
  struct Neighbour {
    std::int32_t face;
    bool agrees;
  };
  std::vector<std::vector<Neighbour>> neighbours(static_cast<std::size_t>(mesh_.face_count()));
  group_edges(mesh_).for_each([&](std::int32_t lower, std::span<const FaceSide> sides) {
    if (sides.size() != 2) return;
    const bool agrees = runs_from(sides[0], lower) != runs_from(sides[1], lower);
    neighbours[sides[0].face].push_back({sides[1].face, agrees});
    neighbours[sides[1].face].push_back({sides[0].face, agrees});
  });

  std::int64_t count = 0, first = -1;
  std::vector<std::int8_t> direction(neighbours.size(), 0);
  std::vector<std::int32_t> component;
  for (std::int32_t seed = 0; seed < mesh_.face_count(); ++seed) {
    if (direction[seed] != 0) continue;
    component.assign(1, seed);
    direction[seed] = 1;
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < component.size(); ++i) {
      const std::int32_t face = component[i];
      sum += direction[face];
      for (const Neighbour& next : neighbours[face]) {
        if (direction[next.face] != 0) continue;
        direction[next.face] = next.agrees ? direction[face] : -direction[face];
        component.push_back(next.face);
      }
    }
    const int minority = sum < 0 ? 1 : -1;
    for (const std::int32_t face : component) {
      if (direction[face] != minority) continue;
      for (auto* corners : {&mesh_.face_vertices, &source_corners_}) {
        std::reverse(corners->begin() + mesh_.face_offsets[face] + 1,
                     corners->begin() + mesh_.face_offsets[face + 1]);
      }
      changed(face);
      if (count++ == 0) first = result_.source_faces[face];
    }
  }
  report("turned-faces", "faces that ran against their neighbours, turned round", count, first);
}

// Corners of a vertex are in one fan when their faces meet at a sound edge of that vertex.
void Repair::separate() {
  DisjointSets fans(mesh_.face_vertices.size());
  std::int64_t cut_count = 0, first_cut = -1;
  group_edges(mesh_).for_each([&](std::int32_t lower, std::span<const FaceSide> sides) {
    if (sides.size() == 1) return;
    if (sides.size() > 2 || runs_from(sides[0], lower) == runs_from(sides[1], lower)) {
      cut_edges_.insert({lower, sides[0].higher});
      if (cut_count++ == 0) first_cut = lower;
      return;
    }
    const std::int32_t next0 = next_corner(mesh_, sides[0].face, sides[0].corner);
    const std::int32_t next1 = next_corner(mesh_, sides[1].face, sides[1].corner);
    fans.unite(sides[0].corner, next1);
    fans.unite(sides[1].corner, next0);
  });
  report("non-manifold-edges",
         "non-manifold edges (three or more faces, or two that cannot agree), where sheets were "
         "separated",
         cut_count, first_cut);
  copy_fans(fans);
  if (mesh_.vertex_count() > input_.vertex_count())
    copy_tags(mesh_, result_.source_vertices, input_.vertex_count());
  tag_cuts();
}

void Repair::copy_fans(DisjointSets& fans) {
  std::vector<std::int32_t> first_fan(mesh_.positions.size(), -1);
  std::map<std::int32_t, std::int32_t> vertex_of_fan;
  std::set<std::int32_t> vertices_on_cuts, split_vertices;
  for (const auto& [a, b] : cut_edges_) vertices_on_cuts.insert({a, b});
  for (std::int32_t f = 0; f < mesh_.face_count(); ++f) {
    bool renamed = false;
    for (std::int32_t c = mesh_.face_offsets[f]; c < mesh_.face_offsets[f + 1]; ++c) {
      const std::int32_t vertex = mesh_.face_vertices[c];
      const std::int32_t fan = fans.find(c);
      if (first_fan[vertex] < 0) first_fan[vertex] = fan;
      if (first_fan[vertex] == fan) continue;
      auto [copy, fresh] = vertex_of_fan.try_emplace(fan, mesh_.vertex_count());
      if (fresh) {
        mesh_.positions.push_back(mesh_.positions[vertex]);
        result_.source_vertices.push_back(vertex);
        if (!vertices_on_cuts.contains(vertex)) split_vertices.insert(vertex);
      }
      mesh_.face_vertices[c] = copy->second;
      renamed = true;
    }
    if (renamed) changed(f);
  }
  report("non-manifold-vertices",
         "non-manifold vertices, split so that each fan of faces has its own",
         static_cast<std::int64_t>(split_vertices.size()),
         split_vertices.empty() ? -1 : *split_vertices.begin());
}

// Each sheet's boundary curve would go its own way, as the faces beside it want it: between corners
// all are the same straight edges.
void Repair::tag_cuts() {
  std::set<std::int32_t> on_cuts;
  for (const auto& [a, b] : cut_edges_) on_cuts.insert({a, b});
  if (on_cuts.empty()) return;
  std::set<std::int32_t> tagged;
  for (const CornerVertex& corner : mesh_.corners) tagged.insert(corner.vertex);
  for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) {
    if (!on_cuts.contains(result_.source_vertices[v]) || tagged.contains(v)) continue;
    mesh_.corners.push_back({v, kInfiniteSharpness});
  }
}

void Repair::drop_unknown() {
  const auto is_unknown_face = [&](std::int32_t face) {
    return face < 0 || face >= input_.face_count();
  };
  report("unknown-tags",
         "crease or corner tags that name no edge or used vertex, or have no sharpness, dropped",
         drop_unknown_tags(mesh_), -1);
  report("unknown-holes", "holes that are no face, dropped",
         std::ranges::count_if(input_.hole_faces, is_unknown_face), -1);
}

void Repair::carry_attributes() {
  mesh_.uvs = input_.uvs;
  mesh_.groups = input_.groups;
  if (!input_.face_uvs.empty()) {
    for (const std::int32_t c : source_corners_) mesh_.face_uvs.push_back(input_.face_uvs[c]);
  }
  if (!input_.colors.empty()) {
    for (const std::int32_t v : result_.source_vertices) mesh_.colors.push_back(input_.colors[v]);
  }
  mesh_.attributes = attributes_of(input_.attributes, result_.source_vertices);
  const std::set<std::int32_t> holes(input_.hole_faces.begin(), input_.hole_faces.end());
  for (std::int32_t f = 0; f < mesh_.face_count(); ++f) {
    const std::int32_t source = result_.source_faces[f];
    if (!input_.face_groups.empty()) mesh_.face_groups.push_back(input_.face_groups[source]);
    if (holes.contains(source)) mesh_.hole_faces.push_back(f);
  }
}

// What no repair can supply.
void require_sound_data(const std::vector<MeshProblem>& problems) {
  for (const MeshProblem& problem : problems) {
    switch (problem.kind) {
      case MeshProblemKind::NoFaces:
      case MeshProblemKind::NonFinitePosition:
      case MeshProblemKind::IndexOutOfRange:
      case MeshProblemKind::WrongAttributeCount:
      case MeshProblemKind::UnknownTextureCoordinate:
      case MeshProblemKind::UnknownGroup:
      case MeshProblemKind::TooLarge:
      case MeshProblemKind::NoExtent:
        throw Error(ErrorCode::UnusableMesh, problem.message, problem.element);
      default:
        break;
    }
  }
}

}  // namespace

RepairedMesh repair(const PolygonMesh& mesh) {
  const std::vector<MeshProblem> problems = check(mesh);
  require_sound_data(problems);
  if (!problems.empty()) return Repair(mesh).run();
  RepairedMesh same;
  same.mesh = mesh;
  same.source_vertices.resize(mesh.positions.size());
  same.source_faces.resize(static_cast<std::size_t>(mesh.face_count()));
  for (std::size_t v = 0; v < same.source_vertices.size(); ++v) {
    same.source_vertices[v] = static_cast<std::int32_t>(v);
  }
  for (std::size_t f = 0; f < same.source_faces.size(); ++f) {
    same.source_faces[f] = static_cast<std::int32_t>(f);
  }
  return same;
}

}  // namespace planish
