// Every test asks only whether all is well: where it is not, check() looks again, one element after
// another, and words the problems.
#include "planish/mesh/sound_topology.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_arrays.h"
#include "planish/mesh/placement.h"

namespace planish {
namespace {

constexpr std::size_t kSoundGrain = 4096;

// Whether test(begin, end) holds on all pieces; further pieces are left out once one fails.
template <class Test>
bool holds_everywhere(std::size_t count, const Test& test) {
  std::atomic<bool> holds{true};
  parallel_for(count, kSoundGrain, [&](std::size_t begin, std::size_t end) {
    if (holds.load(std::memory_order_relaxed) && !test(begin, end))
      holds.store(false, std::memory_order_relaxed);
  });
  return holds.load();
}

bool counts_fit(const PolygonMesh& mesh) {
  const std::size_t largest =
      std::max({mesh.positions.size(), mesh.face_offsets.size(), mesh.face_vertices.size()});
  return mesh.face_offsets.size() > 1 && largest <= static_cast<std::size_t>(kMaxInt32);
}

bool names_one_twice(std::span<const std::int32_t> face, std::vector<std::int32_t>& scratch) {
  constexpr std::size_t kFew = 12;
  if (face.size() <= kFew) {
    for (std::size_t i = 1; i < face.size(); ++i)
      if (std::find(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(i), face[i]) !=
          face.begin() + static_cast<std::ptrdiff_t>(i))
        return true;
    return false;
  }
  scratch.assign(face.begin(), face.end());
  std::ranges::sort(scratch);
  return std::ranges::adjacent_find(scratch) != scratch.end();
}

// Offsets, indices and sizes of the faces; writes the lowest vertex of each.
bool faces_are_sound(const PolygonMesh& mesh, RawVector<std::int32_t>& lowest) {
  const auto corner_count = static_cast<std::int32_t>(mesh.face_vertices.size());
  if (mesh.face_offsets.front() != 0 || mesh.face_offsets.back() != corner_count) return false;
  lowest.resize(mesh.face_offsets.size() - 1);
  return holds_everywhere(lowest.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<std::int32_t> scratch;
    for (std::size_t f = begin; f < end; ++f) {
      const std::int32_t first = mesh.face_offsets[f], last = mesh.face_offsets[f + 1];
      if (first < 0 || last > corner_count || last < first + std::int64_t{3} ||
          last > first + std::int64_t{kMaxValence})
        return false;
      const auto face = mesh.face(static_cast<std::int32_t>(f));
      const auto [low, high] = std::ranges::minmax(face);
      if (low < 0 || high >= mesh.vertex_count() || names_one_twice(face, scratch)) return false;
      lowest[f] = low;
    }
    return true;
  });
}

using SummedFaces = std::vector<std::pair<std::uint64_t, std::int32_t>>;  // sum of squares, face

// Whether two of the faces have the same vertices.
bool have_duplicates(const MeshTopology& topology, SummedFaces& faces) {
  std::ranges::sort(faces);
  std::vector<std::vector<std::int32_t>> alike;
  for (std::size_t begin = 0, end; begin < faces.size(); begin = end) {
    end = begin + 1;
    while (end < faces.size() && faces[end].first == faces[begin].first) ++end;
    if (end - begin == 1) continue;
    alike.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const auto face = topology.face(faces[i].second);
      std::ranges::sort(alike.emplace_back(face.begin(), face.end()));
    }
    std::ranges::sort(alike);
    if (std::ranges::adjacent_find(alike) != alike.end()) return true;
  }
  return false;
}

// Valences, and that no two faces have the same vertices: they would share their lowest one.
bool vertices_are_sound(const MeshTopology& topology, std::span<const std::int32_t> lowest) {
  const auto count = static_cast<std::size_t>(topology.vertex_count());
  return holds_everywhere(count, [&](std::size_t begin, std::size_t end) {
    SummedFaces faces;
    for (std::size_t v = begin; v < end; ++v) {
      const auto vertex = static_cast<std::int32_t>(v);
      if (topology.valence(vertex) > kMaxValence) return false;
      std::int32_t lowest_of = 0;
      for (const std::int32_t corner : topology.corners_at(vertex))
        lowest_of += lowest[topology.face_of(corner)] == vertex ? 1 : 0;
      if (lowest_of < 2) continue;
      faces.clear();
      for (const std::int32_t corner : topology.corners_at(vertex)) {
        const std::int32_t face = topology.face_of(corner);
        if (lowest[face] != vertex) continue;
        // Faces that differ mostly differ in the sum of squares.
        std::uint64_t sum = 0;
        for (const std::int32_t other : topology.face(face))
          sum += static_cast<std::uint64_t>(other) * static_cast<std::uint64_t>(other);
        faces.emplace_back(sum, face);
      }
      if (have_duplicates(topology, faces)) return false;
    }
    return true;
  });
}

bool tags_are_known(const PolygonMesh& mesh, const MeshTopology& topology) {
  constexpr std::size_t kLongSearch = 256;  // corners around a vertex
  const auto count = topology.vertex_count();
  const auto is_vertex = [&](std::int32_t v) { return v >= 0 && v < count; };
  const bool edges = holds_everywhere(mesh.creases.size(), [&](std::size_t begin, std::size_t end) {
    return std::all_of(
        mesh.creases.begin() + static_cast<std::ptrdiff_t>(begin),
        mesh.creases.begin() + static_cast<std::ptrdiff_t>(end), [&](const CreaseEdge& crease) {
          if (!is_vertex(crease.v0) || !is_vertex(crease.v1)) return false;
          const std::size_t search = std::min(topology.corners_at(crease.v0).size(),
                                              topology.corners_at(crease.v1).size());
          return search <= kLongSearch && topology.find_edge(crease.v0, crease.v1) >= 0;
        });
  });
  return edges && std::ranges::all_of(mesh.corners, [&](const CornerVertex& corner) {
           return is_vertex(corner.vertex) && !topology.corners_at(corner.vertex).empty();
         });
}

}  // namespace

bool positions_are_finite(const PolygonMesh& mesh) {
  return holds_everywhere(mesh.positions.size(), [&](std::size_t begin, std::size_t end) {
    bool finite = true;
    for (std::size_t v = begin; v < end; ++v) {
      // Comparisons with NaN are false.
      const glm::dvec3& p = mesh.positions[v];
      finite = finite && std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
               std::abs(p.z) <= kMaxCoordinate;
    }
    return finite;
  });
}

std::optional<MeshTopology> sound_topology(const PolygonMesh& mesh) {
  RawVector<std::int32_t> lowest;
  if (!counts_fit(mesh) || !positions_are_finite(mesh) || !faces_are_sound(mesh, lowest) ||
      !attributes_are_sound(arrays_of(mesh)) || !has_extent(mesh))
    return std::nullopt;
  std::optional<MeshTopology> topology = MeshTopology::if_manifold(mesh);
  if (!topology || !vertices_are_sound(*topology, lowest) || !tags_are_known(mesh, *topology))
    return std::nullopt;
  return topology;
}

MeshTopology usable_topology(const PolygonMesh& mesh, std::string_view name) {
  std::optional<MeshTopology> topology = sound_topology(mesh);
  if (topology) return std::move(*topology);
  require_usable(mesh, name);
  return MeshTopology(mesh);
}

}  // namespace planish
