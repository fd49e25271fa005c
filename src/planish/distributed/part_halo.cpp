#include "planish/distributed/part_halo.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "planish/core/assert.h"

namespace planish {

namespace {

auto order_of(const CurveKey& key) { return std::pair(key.vertex, key.other); }

struct VertexRequest {
  std::int64_t number;
  std::int32_t target;
};

struct CornerRequest {
  std::int64_t face;  // number in the file
  std::int64_t number;
  std::int32_t place, target;
};

}  // namespace

std::vector<CurveKey> curve_keys(const MeshPart& part, const SubMesh& sub,
                                 const MeshTopology& topology, const SharpFeatures& features) {
  std::vector<CurveKey> keys(2 * static_cast<std::size_t>(features.sharp_edge_count));
  if (keys.empty()) return keys;
  const auto number = [&](std::int32_t v) { return part.number_of(sub.vertices[v]); };
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const std::int32_t sharp = features.sharp_of_edge[e];
    if (sharp < 0) continue;
    const auto [v0, v1] = topology.edge_vertices(e);
    const std::int32_t index = topology.corner_count() + 2 * sharp;
    keys[2 * static_cast<std::size_t>(sharp)] = {number(v0), number(v1), index};
    keys[2 * static_cast<std::size_t>(sharp) + 1] = {number(v1), number(v0), index + 1};
  }
  return keys;
}

void sort_keys(std::vector<CurveKey>& keys) { std::ranges::sort(keys, {}, order_of); }

std::optional<std::int32_t> index_of(std::span<const CurveKey> sorted_keys, const CurveKey& key) {
  const auto found = std::ranges::lower_bound(sorted_keys, order_of(key), {}, order_of);
  if (found == sorted_keys.end() || order_of(*found) != order_of(key)) return std::nullopt;
  return found->index;
}

PartHalo::PartHalo(const Ranks& ranks, const MeshPart& part, const SubMesh& sub,
                   std::span<const CurveKey> keys, std::int64_t block_vertices,
                   std::function<void()> after_exchange)
    : ranks_(ranks), part_(part), after_exchange_(std::move(after_exchange)) {
  // Corners of the sub mesh are those of the part.
  agree(ranks, [&] { PLANISH_ASSERT(sub.mesh.face_offsets == part.face_offsets); });
  sub_vertices_.assign(part.file_ids.size(), -1);
  owned_vertices_.resize(sub.vertices.size());
  for (std::size_t i = sub.vertices.size(); i-- > 0;) {
    sub_vertices_[sub.vertices[i]] = static_cast<std::int32_t>(i);
    owned_vertices_[i] = sub.vertices[i] < part.owned_count() ? 1 : 0;
  }
  link_vertices(sub);
  link_corners(sub);
  link_curves(keys);
  list_blocks(sub, block_vertices);
}

// `find`: the local index of a request from another rank, or -1.
template <class Request, class OwnerOf, class Find>
PartHalo::Link PartHalo::link(const std::vector<Request>& requests, const OwnerOf& owner,
                              const Find& find) const {
  Link result;
  result.received.assign(static_cast<std::size_t>(ranks_.size), 0);
  std::vector<Request> sorted = requests;
  std::ranges::stable_sort(sorted, {}, owner);
  for (const Request& request : sorted) {
    ++result.received[owner(request)];
    result.targets.push_back(request.target);
  }
  const auto asked = all_to_all<Request>(ranks_, sorted, result.received, &result.sent);
  std::vector<std::uint8_t> found(asked.size());
  result.sources.resize(asked.size());
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const std::int32_t index = find(asked[i]);
    found[i] = index >= 0 ? 1 : 0;
    result.sources[i] = index;
  }
  const auto is_there = all_to_all<std::uint8_t>(ranks_, found, result.sent);
  for (std::size_t i = 0; i < is_there.size(); ++i)
    if (is_there[i] == 0) result.targets[i] = -1;
  return result;
}

void PartHalo::link_vertices(const SubMesh& sub) {
  std::vector<VertexRequest> requests;
  for (std::size_t i = 0; i < sub.vertices.size(); ++i)
    if (owned_vertices_[i] == 0)
      requests.push_back({part_.number_of(sub.vertices[i]), static_cast<std::int32_t>(i)});
  vertices_ = link(
      requests, [&](const VertexRequest& r) { return owner_of(part_.layout, r.number); },
      [&](const VertexRequest& r) { return sub_vertices_[part_.local_of(r.number)]; });
}

void PartHalo::link_corners(const SubMesh& sub) {
  std::vector<CornerRequest> requests;
  for (std::int32_t f = 0; f < part_.face_count(); ++f) {
    for (std::int32_t c = part_.face_offsets[f]; c < part_.face_offsets[f + 1]; ++c) {
      const std::int32_t vertex = sub.vertices[sub.mesh.face_vertices[c]];
      if (vertex < part_.owned_count()) continue;
      requests.push_back(
          {part_.face_ids[f], part_.number_of(vertex), c - part_.face_offsets[f], c});
    }
  }
  corners_ = link(
      requests, [&](const CornerRequest& r) { return owner_of(part_.layout, r.number); },
      [&](const CornerRequest& r) {
        const auto found = std::ranges::lower_bound(part_.face_ids, r.face);
        PLANISH_ASSERT(found != part_.face_ids.end() && *found == r.face);
        return part_.face_offsets[found - part_.face_ids.begin()] + r.place;
      });
}

void PartHalo::link_curves(std::span<const CurveKey> keys) {
  struct Request : CurveKey {
    std::int32_t target;
  };
  std::vector<Request> requests;
  for (const CurveKey& key : keys) {
    if (owner_of(part_.layout, key.vertex) == ranks_.rank) continue;
    Request& request = requests.emplace_back();
    static_cast<CurveKey&>(request) = key;
    request.target = key.index;
  }
  curves_ = link(
      requests, [&](const Request& r) { return owner_of(part_.layout, r.vertex); },
      [&](const Request& r) { return index_of(keys, r).value_or(-1); });
}

void PartHalo::list_blocks(const SubMesh& sub, std::int64_t block_vertices) {
  const std::int32_t owned = part_.owned_count();
  const auto block_count = static_cast<std::size_t>((owned + block_vertices - 1) / block_vertices);
  for (std::size_t b = 0; b < block_count; ++b) {
    const auto begin = static_cast<std::int64_t>(b) * block_vertices;
    const std::int64_t end = std::min<std::int64_t>(begin + block_vertices, owned);
    for (std::int64_t v = begin; v < end; ++v)
      if (sub_vertices_[v] >= 0) vertex_blocks_.elements.push_back(sub_vertices_[v]);
    vertex_blocks_.offsets.push_back(std::ssize(vertex_blocks_.elements));
  }
  owned_faces_.assign(sub.faces.size(), 0);
  std::vector<std::pair<std::int64_t, std::int32_t>> faces;  // with their blocks
  for (std::int32_t f = 0; f < part_.face_count(); ++f) {
    const std::int32_t first = part_.first_vertex(f);
    if (first >= owned) continue;
    owned_faces_[f] = 1;
    faces.emplace_back(first / block_vertices, f);
  }
  std::ranges::sort(faces);
  for (std::size_t b = 0, i = 0; b < block_count; ++b) {
    for (; i < faces.size() && faces[i].first == static_cast<std::int64_t>(b); ++i)
      face_blocks_.elements.push_back(faces[i].second);
    face_blocks_.offsets.push_back(std::ssize(face_blocks_.elements));
  }
  block_counts_.resize(static_cast<std::size_t>(ranks_.size));
  block_places_.resize(block_counts_.size());
  const int own = static_cast<int>(block_count);
  MPI_Allgather(&own, 1, MPI_INT, block_counts_.data(), 1, MPI_INT, ranks_.comm);
  std::exclusive_scan(block_counts_.begin(), block_counts_.end(), block_places_.begin(), 0);
}

template <class T>
void PartHalo::exchange(const Link& link, std::span<T> values) {
  RawVector<T> send(link.sources.size()), got(link.targets.size());
  for (std::size_t i = 0; i < send.size(); ++i)
    send[i] = link.sources[i] >= 0 ? values[link.sources[i]] : T{};
  exchange_with_peers(ranks_, reinterpret_cast<const std::byte*>(send.data()), link.sent,
                      reinterpret_cast<std::byte*>(got.data()), link.received, sizeof(T));
  for (std::size_t i = 0; i < got.size(); ++i)
    if (link.targets[i] >= 0) values[link.targets[i]] = got[i];
  if (after_exchange_) after_exchange_();
}

void PartHalo::exchange_vertices(std::span<double> values) { exchange(vertices_, values); }
void PartHalo::exchange_vertices(std::span<glm::dvec3> values) { exchange(vertices_, values); }
void PartHalo::exchange_vertices(std::span<std::uint8_t> values) { exchange(vertices_, values); }
void PartHalo::exchange_corners(std::span<float> values) { exchange(corners_, values); }
void PartHalo::exchange_state(std::span<glm::dvec3> values) {
  exchange(corners_, values);
  exchange(curves_, values);
}

double PartHalo::sum_of(const Blocks& blocks, std::span<const double> values) {
  std::vector<double> own(blocks.offsets.size() - 1, 0.0);
  for (std::size_t b = 0; b < own.size(); ++b)
    for (std::int64_t i = blocks.offsets[b]; i < blocks.offsets[b + 1]; ++i)
      own[b] += values[blocks.elements[i]];
  std::vector<double> all(static_cast<std::size_t>(block_places_.back() + block_counts_.back()));
  MPI_Allgatherv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(),
                 block_counts_.data(), block_places_.data(), MPI_DOUBLE, ranks_.comm);
  if (after_exchange_) after_exchange_();
  return std::accumulate(all.begin(), all.end(), 0.0);
}

double PartHalo::sum_of_vertices(std::span<const double> values) {
  return sum_of(vertex_blocks_, values);
}
double PartHalo::sum_of_faces(std::span<const double> values) {
  return sum_of(face_blocks_, values);
}
std::int64_t PartHalo::sum(std::int64_t value) { return sum_over(ranks_, value); }
double PartHalo::largest(double value) { return max_over(ranks_, value); }

}  // namespace planish
