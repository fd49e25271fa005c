#include "planish/mesh/mesh_topology.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/group_by.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/mesh/check.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/sound_topology.h"

namespace planish {
namespace {

// Calls visit(lower, side) for each side of the faces in use.
template <class Visit>
void for_each_side(const PolygonMesh& mesh, std::span<const std::uint8_t> use_face,
                   const Visit& visit) {
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    if (!use_face[face]) continue;
    for (std::int32_t corner = mesh.face_offsets[face]; corner < mesh.face_offsets[face + 1];
         ++corner) {
      const std::int32_t from = mesh.face_vertices[corner];
      const std::int32_t to = mesh.face_vertices[next_corner(mesh, face, corner)];
      visit(std::min(from, to), FaceSide{std::max(from, to), corner, face});
    }
  }
}

}  // namespace

std::span<const FaceSide> EdgeGroups::find(std::int32_t v0, std::int32_t v1) const {
  const std::int32_t lower = std::min(v0, v1), higher = std::max(v0, v1);
  if (lower < 0 || higher >= static_cast<std::int64_t>(offsets.size()) - 1) return {};
  const auto end = sides.begin() + offsets[lower + 1];
  const auto first = std::lower_bound(
      sides.begin() + offsets[lower], end, higher,
      [](const FaceSide& side, std::int32_t vertex) { return side.higher < vertex; });
  const auto last =
      std::find_if(first, end, [&](const FaceSide& side) { return side.higher != higher; });
  return {first, last};
}

EdgeGroups group_edges(const PolygonMesh& mesh, std::span<const std::uint8_t> use_face) {
  auto [offsets, sides] = group_by<FaceSide>(
      mesh.positions.size(), [&](const auto& take) { for_each_side(mesh, use_face, take); });
  EdgeGroups groups{std::move(offsets), std::move(sides)};
  for (std::size_t lower = 0; lower < mesh.positions.size(); ++lower) {
    std::sort(groups.sides.begin() + groups.offsets[lower],
              groups.sides.begin() + groups.offsets[lower + 1],
              [](const FaceSide& a, const FaceSide& b) {
                return a.higher != b.higher ? a.higher < b.higher : a.corner < b.corner;
              });
  }
  return groups;
}

EdgeGroups group_edges(const PolygonMesh& mesh) {
  return group_edges(mesh, std::vector<std::uint8_t>(mesh.face_count(), 1));
}

PolygonMesh polygons_of(std::span<const Triangle> triangles) {
  PolygonMesh mesh;
  mesh.face_vertices.reserve(3 * triangles.size());
  mesh.face_offsets.reserve(triangles.size() + 1);
  for (const Triangle& triangle : triangles) mesh.add_face(triangle);
  return mesh;
}

std::vector<Triangle> quads_as_triangles(std::span<const std::int32_t> corners) {
  std::vector<Triangle> triangles;
  triangles.reserve(corners.size() / 2);
  for (std::size_t i = 0; i + 3 < corners.size(); i += 4) {
    triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    triangles.push_back({corners[i], corners[i + 2], corners[i + 3]});
  }
  return triangles;
}

EdgeGroups edges_of(std::span<const Triangle> triangles, std::size_t vertex_count) {
  PolygonMesh mesh = polygons_of(triangles);
  mesh.positions.resize(vertex_count);
  return group_edges(mesh, std::vector<std::uint8_t>(triangles.size(), 1));
}

std::vector<std::int32_t> twins_of(std::span<const Triangle> triangles, std::size_t vertex_count) {
  std::vector<std::int32_t> twins(3 * triangles.size(), -1);
  edges_of(triangles, vertex_count).for_each([&](std::int32_t, std::span<const FaceSide> sides) {
    PLANISH_ASSERT(sides.size() <= 2);
    if (sides.size() < 2) return;
    twins[sides[0].corner] = sides[1].corner;
    twins[sides[1].corner] = sides[0].corner;
  });
  return twins;
}

namespace {

constexpr std::size_t kLinkGrain = 4096;  // elements that a thread takes at least

// The corners of one vertex with the other ends of their edges, and who lies beside whom.
class Fan {
 public:
  struct Side {
    std::int32_t corner, prev;  // corner, and the one before it in its face
    std::int32_t to, from;      // vertices at the ends of the leading and the trailing edge
  };

  void clear() { sides_.clear(); }
  void add(const Side& side) { sides_.push_back(side); }

  // Finds each corner's clockwise and counter-clockwise neighbour. False where two leading or two
  // trailing edges are the same.
  [[nodiscard]] bool match() {
    const std::size_t count = sides_.size();
    clockwise_.assign(count, -1);
    counter_clockwise_.assign(count, -1);
    // Pairs are compared all with all, but where that would be many.
    constexpr std::size_t kFew = 24;
    return count <= kFew ? match_few() : match_many();
  }

  // Writes the corners counter-clockwise. False where they are more than one fan.
  [[nodiscard]] bool write_order(std::span<std::int32_t> order) const {
    if (order.empty()) return true;
    const auto boundary = std::ranges::find(clockwise_, -1);
    const auto start =
        boundary == clockwise_.end() ? 0 : static_cast<std::int32_t>(boundary - clockwise_.begin());
    std::size_t written = 0;
    for (std::int32_t i = start; i >= 0 && written < order.size();) {
      order[written++] = sides_[i].corner;
      i = counter_clockwise_[i];
      if (i == start) break;
    }
    return written == order.size();
  }

  // Twin of the leading edge of corner number i.
  [[nodiscard]] std::int32_t twin(std::size_t i) const {
    return clockwise_[i] < 0 ? -1 : sides_[clockwise_[i]].prev;
  }
  [[nodiscard]] std::span<const Side> sides() const { return sides_; }

 private:
  bool join(std::size_t leading, std::size_t trailing) {
    if (clockwise_[leading] >= 0 || counter_clockwise_[trailing] >= 0) return false;
    clockwise_[leading] = static_cast<std::int32_t>(trailing);
    counter_clockwise_[trailing] = static_cast<std::int32_t>(leading);
    return true;
  }

  bool match_few() {
    for (std::size_t i = 0; i < sides_.size(); ++i) {
      for (std::size_t j = 0; j < sides_.size(); ++j) {
        if (sides_[i].to == sides_[j].from && !join(i, j)) return false;
        if (j < i && (sides_[i].to == sides_[j].to || sides_[i].from == sides_[j].from))
          return false;
      }
    }
    return true;
  }

  bool match_many() {
    using End = std::pair<std::int32_t, std::int32_t>;  // vertex, number of the corner
    std::vector<End> leading, trailing;
    for (std::size_t i = 0; i < sides_.size(); ++i) {
      leading.emplace_back(sides_[i].to, static_cast<std::int32_t>(i));
      trailing.emplace_back(sides_[i].from, static_cast<std::int32_t>(i));
    }
    for (auto* ends : {&leading, &trailing}) {
      std::ranges::sort(*ends);
      if (std::ranges::adjacent_find(*ends, {}, &End::first) != ends->end()) return false;
    }
    for (auto i = leading.begin(), j = trailing.begin();
         i != leading.end() && j != trailing.end();) {
      if (i->first == j->first && !join(i->second, j->second)) return false;
      const bool step_leading = i->first <= j->first, step_trailing = j->first <= i->first;
      i += step_leading;
      j += step_trailing;
    }
    return true;
  }

  std::vector<Side> sides_;
  std::vector<std::int32_t> clockwise_, counter_clockwise_;  // by corner of the fan; -1: none
};

}  // namespace

MeshTopology::MeshTopology(const PolygonMesh& mesh) {
  std::optional<MeshTopology> made = if_manifold(mesh);
  if (!made) {
    throw Error(ErrorCode::UnusableMesh,
                "the faces of the mesh do not meet as a manifold; `planish inspect` lists where");
  }
  *this = std::move(*made);
}

std::optional<MeshTopology> MeshTopology::if_manifold(const PolygonMesh& mesh) {
  MeshTopology topology;
  topology.take_faces(mesh);
  topology.vertex_first_.resize(mesh.positions.size() + 1);
  topology.gather_corners();
  if (!topology.join_corners()) return std::nullopt;
  topology.number_edges();
  return topology;
}

void MeshTopology::take_faces(const PolygonMesh& mesh) {
  face_offsets_.resize(mesh.face_offsets.size());
  corner_vertex_.resize(mesh.face_vertices.size());
  corner_face_.resize(mesh.face_vertices.size());
  face_offsets_[0] = 0;
  parallel_each(static_cast<std::size_t>(mesh.face_count()), kLinkGrain, [&](std::int32_t f) {
    const std::int32_t first = mesh.face_offsets[f], last = mesh.face_offsets[f + 1];
    face_offsets_[f + 1] = last;
    for (std::int32_t c = first; c < last; ++c) {
      corner_vertex_[c] = mesh.face_vertices[c];
      corner_face_[c] = f;
    }
  });
}

// A counting sort of corners by vertex. Threads draw places in any order; join_corners() sorts
// those of each vertex.
void MeshTopology::gather_corners() {
  const std::size_t count = corner_vertex_.size();
  parallel_for(vertex_first_.size(), kLinkGrain, [&](std::size_t begin, std::size_t end) {
    std::fill(vertex_first_.begin() + static_cast<std::ptrdiff_t>(begin),
              vertex_first_.begin() + static_cast<std::ptrdiff_t>(end), 0);
  });
  twin_.resize(count);  // until they are known: a corner's place among those of its vertex
  parallel_each(count, kLinkGrain, [&](std::size_t c) {
    const std::atomic_ref counter(vertex_first_[corner_vertex_[c]]);
    twin_[c] = counter.fetch_add(1, std::memory_order_relaxed);
  });
  exclusive_sum(vertex_first_);
  vertex_corners_.resize(count);
  parallel_each(count, kLinkGrain, [&](std::int32_t c) {
    vertex_corners_[vertex_first_[corner_vertex_[c]] + twin_[c]] = c;
  });
}

// Neighbours around a vertex share an edge, so that its own corners tell all twins.
bool MeshTopology::join_corners() {
  std::atomic<bool> manifold{true};
  parallel_for(vertex_first_.size() - 1, kLinkGrain, [&](std::size_t begin, std::size_t end) {
    Fan fan;
    for (std::size_t v = begin; v < end; ++v) {
      const auto corners = std::span(vertex_corners_)
                               .subspan(vertex_first_[v], vertex_first_[v + 1] - vertex_first_[v]);
      std::ranges::sort(corners);
      fan.clear();
      for (const std::int32_t corner : corners) {
        const std::int32_t before = prev(corner);
        fan.add({corner, before, corner_vertex_[next(corner)], corner_vertex_[before]});
      }
      if (!fan.match() || !fan.write_order(corners)) {
        manifold.store(false, std::memory_order_relaxed);
        return;
      }
      for (std::size_t i = 0; i < corners.size(); ++i) twin_[fan.sides()[i].corner] = fan.twin(i);
    }
  });
  return manifold.load();
}

void MeshTopology::number_edges() {
  const std::size_t count = twin_.size();
  const auto leads = [&](std::int32_t c) { return twin_[c] < 0 || c < twin_[c]; };
  const SelectedBlocks blocks = count_selected(count, leads);
  edge_corner_.resize(blocks.total);
  corner_edge_.resize(count);
  for_selected(count, blocks, leads, [&](std::size_t c, std::int32_t edge) {
    edge_corner_[edge] = static_cast<std::int32_t>(c);
    corner_edge_[c] = edge;
    if (twin_[c] >= 0) corner_edge_[twin_[c]] = edge;
  });
}

std::int32_t MeshTopology::find_edge(std::int32_t v0, std::int32_t v1) const {
  if (std::min(v0, v1) < 0 || std::max(v0, v1) >= vertex_count()) return -1;
  if (corners_at(v1).size() < corners_at(v0).size()) std::swap(v0, v1);
  for (const std::int32_t corner : corners_at(v0)) {
    if (corner_vertex_[next(corner)] == v1) return corner_edge_[corner];
    const std::int32_t before = prev(corner);
    if (corner_vertex_[before] == v1) return corner_edge_[before];
  }
  return -1;
}

namespace {

std::shared_ptr<const PreparedMesh> prepared_of(const PolygonMesh& mesh,
                                                std::optional<MeshTopology> topology) {
  auto prepared = std::make_shared<PreparedMesh>();
  prepared->given_vertex_count = mesh.vertex_count();
  const auto is_used = [&](std::int32_t v) { return !topology->corners_at(v).empty(); };
  const auto count = static_cast<std::size_t>(mesh.vertex_count());
  const SelectedBlocks blocks = count_selected(count, is_used);
  prepared->vertices.resize(blocks.total);
  for_selected(count, blocks, is_used, [&](std::size_t v, std::int32_t number) {
    prepared->vertices[number] = static_cast<std::int32_t>(v);
  });
  if (!prepared->uses_all()) topology.emplace(without_unused_vertices(mesh).mesh);
  prepared->topology = std::make_shared<const MeshTopology>(std::move(*topology));
  return prepared;
}

}  // namespace

std::shared_ptr<const PreparedMesh> prepare_if_sound(const PolygonMesh& mesh) {
  std::optional<MeshTopology> topology = sound_topology(mesh);
  if (!topology) {
    if (!check(mesh).empty()) return nullptr;
    topology.emplace(mesh);
  }
  return prepared_of(mesh, std::move(topology));
}

std::shared_ptr<const PreparedMesh> prepare_mesh(const PolygonMesh& mesh, std::string_view name) {
  return prepared_of(mesh, usable_topology(mesh, name));
}

std::shared_ptr<const PreparedMesh> prepared_whole(const PolygonMesh& mesh,
                                                   std::shared_ptr<const MeshTopology> topology) {
  auto prepared = std::make_shared<PreparedMesh>();
  prepared->given_vertex_count = mesh.vertex_count();
  prepared->vertices.resize(mesh.positions.size());
  std::iota(prepared->vertices.begin(), prepared->vertices.end(), 0);
  prepared->topology = std::move(topology);
  return prepared;
}

UsedPart used_part(const PolygonMesh& mesh, std::shared_ptr<const PreparedMesh> prepared) {
  PLANISH_ASSERT(mesh.vertex_count() == prepared->given_vertex_count);
  PLANISH_ASSERT(mesh.face_count() == prepared->topology->face_count());
  const std::span<const std::int32_t> vertices = prepared->vertices;
  if (prepared->uses_all()) return {std::move(prepared), nullptr, mesh, vertices};
  auto copy = std::make_unique<const PolygonMesh>(without_unused_vertices(mesh).mesh);
  const PolygonMesh& used = *copy;
  return {std::move(prepared), std::move(copy), used, vertices};
}

namespace {

constexpr double kJustOutside = 1e-9;

// Tiles in a row.
std::int32_t tiles_across(std::int32_t m) {
  if (m < 10) return m > 4 ? 3 : 2;
  return 1 + static_cast<std::int32_t>(std::sqrt(static_cast<double>(m - 1)));
}

[[noreturn]] void refuse(const SurfaceParameter& at, const std::string& what) {
  throw Error(ErrorCode::InvalidArgument,
              formatted("face {} at ({}, {}): {}", at.face, shortest(at.u), shortest(at.v), what));
}

double inside(double value, double largest, const SurfaceParameter& at) {
  if (!(value >= -kJustOutside && value <= largest + kJustOutside))
    refuse(at, "lies outside the face");
  return std::clamp(value, 0.0, largest);
}

// The tile's place along one direction, and what is left. What lies just before a tile is its own.
std::pair<std::int32_t, double> tile_of(double value, const SurfaceParameter& at) {
  if (!(value > -1 && value < 1e6)) refuse(at, "lies outside the face");
  auto tile = static_cast<std::int32_t>(std::floor(value));
  double rest = value - tile;
  if (rest > 0.75) ++tile, rest -= 1;
  return {tile, inside(rest, 0.5, at)};
}

}  // namespace

CornerParameter corner_parameter(const MeshTopology& topology, const SurfaceParameter& at) {
  if (at.face < 0 || at.face >= topology.face_count())
    refuse(at, formatted("the mesh has {} faces", topology.face_count()));
  const std::int32_t first = topology.first_corner(at.face);
  const std::int32_t m = topology.face_size(at.face);
  if (m != 4) {
    const auto [i, u] = tile_of(at.u, at);
    const auto [j, v] = tile_of(at.v, at);
    const std::int32_t across = tiles_across(m);
    if (i < 0 || i >= across || j < 0 || j * across + i >= m) refuse(at, "lies outside the face");
    return {first + j * across + i, 2 * u, 2 * v, 1, 0};
  }
  const double u = inside(at.u, 1, at), v = inside(at.v, 1, at);
  if (v < 0.5) {
    if (u < 0.5) return {first, 2 * u, 2 * v, 1, 0};
    return {first + 1, 2 * v, 2 - 2 * u, 0, 1};
  }
  if (u < 0.5) return {first + 3, 2 - 2 * v, 2 * u, 0, -1};
  return {first + 2, 2 - 2 * u, 2 - 2 * v, -1, 0};
}

SurfaceParameter surface_parameter(const MeshTopology& topology, std::int32_t corner, double u,
                                   double v) {
  const std::int32_t face = topology.face_of(corner), place = topology.place_of(corner);
  const std::int32_t m = topology.face_size(face);
  if (m != 4) {
    const std::int32_t across = tiles_across(m);
    const std::int32_t row = place / across, column = place % across;
    return {face, column + u / 2, row + v / 2};
  }
  switch (place) {
    case 0:
      return {face, u / 2, v / 2};
    case 1:
      return {face, 1 - v / 2, u / 2};
    case 2:
      return {face, 1 - u / 2, 1 - v / 2};
    default:
      return {face, v / 2, 1 - u / 2};
  }
}

}  // namespace planish
