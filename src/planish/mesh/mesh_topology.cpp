#include "planish/mesh/mesh_topology.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/prefix_sum.h"

namespace planish {
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

}  // namespace planish
