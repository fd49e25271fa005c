// Based on: fair/fair_net.cpp, on a rank's vertices and two rings of faces around them. Every step
// asks for the first ring of what the step before made, which owners send between.
#include "planish/distributed/part_fair.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <optional>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/doosabin/sharp_features.h"
#include "planish/doosabin/subdivision.h"
#include "planish/fair/cured_nets.h"
#include "planish/fair/fair_net.h"
#include "planish/fair/hub_ellipse.h"
#include "planish/mesh/convex_faces.h"
#include "planish/pipeline/bend_least.h"
#include "planish/pipeline/deep_folds.h"

namespace planish {

namespace {

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

// As pipeline/solve_fair.cpp measures it.
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
