#include "planish/distributed/part_fair.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_net.h"
#include "planish/fair/fold_cure.h"
#include "planish/mend/repair.h"
#include "planish/pipeline/fit_steps.h"

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

namespace {

// Based on: fair/fair_net.cpp, on a rank's vertices and two rings of faces around them. Every step
// asks for the first ring of what the step before made, which owners send between.

using glm::dvec3;

// The part as fair_net() takes it.
struct PartMesh {
  PartMesh(const MeshPart& part, const PartFairOptions& options)
      : sub(SubMeshMaker(part).make(0, part.owned_count(), Rings::TwoTagged)),
        topology(topology_of_sound(sub.mesh)),
        features(find_sharp_features(sub.mesh, *topology, sub.mesh.positions, options.fit.sharp)),
        // The first step takes the weights of 1978 whatever the later levels take.
        subdivision(*topology, features, Weights::DooSabin),
        given(sub.mesh.positions.size()),
        keys(curve_keys(part, sub, *topology, features)) {
    for (std::size_t v = 0; v < given.size(); ++v) {
      if (!options.points.empty()) sub.mesh.positions[v] = options.points[sub.vertices[v]];
      given[v] = options.placement.to_unit(sub.mesh.positions[v]);
    }
    sort_keys(keys);
  }

  SubMesh sub;
  std::shared_ptr<const MeshTopology> topology;
  SharpFeatures features;
  Subdivision subdivision;
  std::vector<dvec3> given;
  std::vector<CurveKey> keys;
};

// As pipeline/fair_fit.cpp measures it.
void measure(const Ranks& ranks, const PartMesh& mesh, PartHalo& halo, double tolerance,
             PartFair& fair) {
  const std::vector<dvec3> limits = limit_points(mesh.subdivision, fair.state);
  std::vector<double> squares(limits.size(), 0.0);
  std::int64_t count = 0;
  double largest = 0;
  for (std::size_t v = 0; v < limits.size(); ++v) {
    if (halo.owned_vertices()[v] == 0) continue;
    double error = glm::length(limits[v] - mesh.given[v]);
    if (!std::isfinite(error)) error = HUGE_VAL;
    largest = std::max(largest, error);
    squares[v] = error * error;
    ++count;
  }
  fair.error.max = max_over(ranks, largest);
  fair.error.rms = std::sqrt(halo.sum_of_vertices(squares) / static_cast<double>(halo.sum(count)));
  fair.converged = fair.error.max <= tolerance;
}

std::int64_t count_concave(const SubMesh& sub, PartHalo& halo) {
  std::int64_t count = 0;
  for (const std::int32_t face : concave_faces(sub.mesh)) count += halo.owned_faces()[face];
  return halo.sum(count);
}

FairNet make_net(const PartMesh& mesh, PartHalo& halo, const PartFairOptions& options) {
  const FairOptions fair{options.fit.polish_steps, {}, nullptr, options.fit.cures_folds, &halo};
  std::optional<CuredNets> nets;
  const auto net_of = [&](const FairDecisions* decisions) {
    if (!decisions) return fair_net(mesh.sub.mesh, mesh.subdivision, mesh.given, fair);
    if (!nets) nets.emplace(mesh.sub.mesh, mesh.subdivision, mesh.given, fair);
    return nets->net(*decisions);
  };
  if (!options.fit.cures_folds) return net_of(nullptr);
  std::optional<DeepLook> look;
  const auto folds_of = [&](FairNet& net) {
    LevelOne level_one{std::move(net.state), options.placement};
    if (!look)
      look.emplace(mesh.sub.mesh, *mesh.topology, mesh.features, options.fit.weights, &halo);
    DeepFolds folds = look->at(level_one);
    net.state = std::move(level_one.state);
    return folds;
  };
  const auto choose = [&](std::span<const std::uint8_t> flagged, FairDecisions& decisions) {
    const FairTopology topology = make_fair_topology(mesh.sub.mesh, mesh.subdivision, &halo);
    return choose_ellipses(topology, mesh.given, flagged, decisions);
  };
  return deeply_cured_net({net_of, folds_of, choose, &halo});
}

}  // namespace

PartWithin bend_part_least(const Ranks& ranks, const MeshPart& part,
                           const PartFairOptions& options) {
  PartWithin result;
  if (options.fit.within == 0.0) return result;
  std::unique_ptr<PartMesh> mesh;
  agree(ranks, [&] { mesh = std::make_unique<PartMesh>(part, options); });
  PartHalo halo(ranks, part, mesh->sub, mesh->keys, options.block_vertices, options.after_exchange);
  result.figures = bend_least(*mesh->topology, mesh->features, options.placement, options.fit,
                              mesh->given, &halo);
  if (!(result.figures->bound(options.fit.tolerance) > 0)) return result;
  result.points = part.positions;
  for (std::size_t v = 0; v < mesh->given.size(); ++v)
    result.points[mesh->sub.vertices[v]] = options.placement.to_model(mesh->given[v]);
  return result;
}

PartFair make_part_fair(const Ranks& ranks, const MeshPart& part, const PartFairOptions& options) {
  std::unique_ptr<PartMesh> mesh;
  agree(ranks, [&] { mesh = std::make_unique<PartMesh>(part, options); });
  PartHalo halo(ranks, part, mesh->sub, mesh->keys, options.block_vertices, options.after_exchange);
  FairNet net = make_net(*mesh, halo, options);
  PartFair fair{net};
  fair.state = std::move(net.state);
  fair.placement = options.placement;
  measure(ranks, *mesh, halo, options.fit.tolerance, fair);
  fair.concave_faces = count_concave(mesh->sub, halo);
  fair.keys = std::move(mesh->keys);
  return fair;
}

LevelOne level_one_of(const MeshPart& part, const PartFair& fair, const SubMesh& sub,
                      const MeshTopology& topology, const SharpFeatures& features) {
  LevelOne result;
  result.placement = fair.placement;
  std::vector<dvec3>& state = result.state;
  const auto point = [&](std::int32_t part_vertex) {
    return fair.placement.to_unit(part.positions[part_vertex]);
  };
  for (const std::int32_t face : sub.faces)
    state.insert(state.end(), fair.state.begin() + part.face_offsets[face],
                 fair.state.begin() + part.face_offsets[face + 1]);
  for (const CurveKey& key : curve_keys(part, sub, topology, features)) {
    const auto index = index_of(fair.keys, key);
    state.push_back(index ? fair.state[*index] : point(part.local_of(key.vertex)));
  }
  for (const std::int32_t corner : features.corner_vertices)
    state.push_back(point(sub.vertices[corner]));
  return result;
}

}  // namespace planish
