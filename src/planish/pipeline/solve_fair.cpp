#include "planish/pipeline/solve_fair.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/counted.h"
#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/fair/cured_nets.h"
#include "planish/fair/fair_builder.h"
#include "planish/fair/hub_ellipse.h"
#include "planish/fair/plane_places.h"
#include "planish/mesh/convex_faces.h"
#include "planish/pipeline/deep_folds.h"

namespace planish {

namespace {

// Of the time of a round, that of the net; the rest is the look at its surface.
constexpr double kNetMade = 0.6;
constexpr std::size_t kPolygonGrain = 1024;

// The error of the finished net: nothing that built it is taken at its word.
Interpolation measured(const Subdivision& subdivision, std::span<const glm::dvec3> state,
                       std::span<const glm::dvec3> given, double tolerance) {
  Interpolation result;
  const std::vector<glm::dvec3> limits = limit_points(subdivision, state);
  double sum_of_squares = 0;
  for (std::size_t v = 0; v < given.size(); ++v) {
    double error = glm::length(limits[v] - given[v]);
    if (!std::isfinite(error)) error = HUGE_VAL;
    sum_of_squares += error * error;
    if (result.worst_vertex < 0 || error > result.error.max) {
      result.error.max = error;
      result.worst_vertex = static_cast<std::int64_t>(v);
    }
  }
  result.error.rms = std::sqrt(sum_of_squares / static_cast<double>(given.size()));
  result.converged = result.error.max <= tolerance;
  result.stop_reason = result.converged ? StopReason::Converged : StopReason::Stagnated;
  return result;
}

// On the backend's device where it can.
FairNet make_net(const PolygonMesh& mesh, const Subdivision& subdivision,
                 std::span<const glm::dvec3> given, Backend& backend, const FitOptions& options,
                 const Callbacks& callbacks, const FairDecisions* decisions) {
  std::vector<KeptPlane> planes;
  if (options.keeps_planes && decisions == nullptr) planes = kept_planes(mesh, subdivision);
  const FairOptions fair{.polish_steps = options.polish_steps,
                         .callbacks = callbacks,
                         .decisions = decisions,
                         .cures_folds = options.cures_folds,
                         .planes = planes};
  auto* const builder = dynamic_cast<FairBuilder*>(&backend);
  if (!builder) return fair_net(mesh, subdivision, given, fair);
  return builder->build_fair_net(make_fair_topology(mesh, subdivision), given, fair);
}

// With a look at the finished surface.
FairNet make_cured_net(const Fit& result, const PolygonMesh& mesh, const Subdivision& subdivision,
                       std::span<const glm::dvec3> given, Backend& backend,
                       const FitOptions& options) {
  if (!options.cures_folds || options.fair_decisions != nullptr)
    return make_net(mesh, subdivision, given, backend, options, options.callbacks,
                    options.fair_decisions);
  RoundParts rounds(options.callbacks, 0.75);
  Callbacks round;
  std::optional<DeepLook> look;
  std::optional<CuredNets> nets;  // a device makes each net whole
  std::optional<FairTopology> topology;
  const bool on_device = dynamic_cast<FairBuilder*>(&backend) != nullptr;
  return deeply_cured_net(
      {.make_net =
           [&](const FairDecisions* decisions) {
             round = rounds.next();
             const Callbacks callbacks = share_of(round, 0, kNetMade);
             if (!decisions || on_device)
               return make_net(mesh, subdivision, given, backend, options, callbacks, decisions);
             if (!nets)
               nets.emplace(mesh, subdivision, given,
                            FairOptions{.polish_steps = options.polish_steps});
             return nets->net(*decisions, callbacks);
           },
       .folds_of = [&](FairNet& net) -> DeepFolds {
         if (net.decisions.cures.size() != given.size()) return {};
         LevelOne level_one{std::move(net.state), result.placement};
         if (!look)
           look.emplace(mesh, *result.prepared->topology, *result.features, options.weights);
         DeepFolds folds = look->at(level_one, share_of(round, kNetMade, 1));
         net.state = std::move(level_one.state);
         return folds;
       },
       .choose_ellipses =
           [&](std::span<const std::uint8_t> flagged, FairDecisions& decisions) {
             if (!topology) topology = make_fair_topology(mesh, subdivision);
             return choose_ellipses(*topology, given, flagged, decisions);
           }});
}

// See FairFigures::least_polygon.
std::optional<double> least_polygon(const MeshTopology& topology, const SharpFeatures& features,
                                    std::span<const glm::dvec3> given,
                                    std::span<const glm::dvec3> state) {
  std::vector<double> sizes(given.size(), HUGE_VAL);
  parallel_each(sizes.size(), kPolygonGrain, [&](std::size_t i) {
    const auto vertex = static_cast<std::int32_t>(i);
    const VertexKind kind = features.vertex_kinds[i];
    if (kind != VertexKind::Smooth && kind != VertexKind::Dart) return;
    double farthest = 0, shortest = HUGE_VAL;
    for (const std::int32_t c : topology.corners_at(vertex)) {
      farthest = std::max(farthest, glm::distance(state[c], given[i]));
      for (const std::int32_t other : {topology.next(c), topology.prev(c)})
        shortest = std::min(shortest, glm::distance(given[topology.vertex_of(other)], given[i]));
    }
    if (shortest > 0 && std::isfinite(shortest)) sizes[i] = farthest / shortest;
  });
  const double least = sizes.empty() ? HUGE_VAL : std::ranges::min(sizes);
  return std::isfinite(least) ? std::optional(least) : std::nullopt;
}

}  // namespace

Warning folds_left_warning(std::int64_t edges, std::int64_t faces) {
  return {"folds-left",
          formatted("the fair surface still turns over at {} and {}, where the mesh itself is "
                    "folded or too sharp for a smooth surface",
                    counted(edges, "edge"), counted(faces, "face")),
          edges + faces, -1};
}

Warning concave_faces_warning(std::int64_t faces, std::int64_t crossing) {
  std::string text = formatted(
      "faces with corners that turn inward, beside which the fair surface may fold: {}; ", faces);
  if (crossing < faces) text += "with_convex_faces() and --repair safe cut them in parts";
  if (crossing > 0)
    text += crossing < faces
                ? formatted(", but not the {} that cross themselves", crossing)
                : "they cross themselves: cut them in triangles, whichever way is meant";
  return {"concave-faces", text, faces, -1};
}

void solve_fair(Fit& result, const PolygonMesh& mesh, const Subdivision& subdivision,
                std::span<const glm::dvec3> given, Backend& backend, const FitOptions& options) {
  FairNet net = make_cured_net(result, mesh, subdivision, given, backend, options);
  result.interpolation = measured(subdivision, net.state, given, options.tolerance);
  net.least_polygon = least_polygon(*result.prepared->topology, *result.features, given, net.state);
  FairFit& fair = result.fair.emplace(
      FairFit{net, {std::move(net.state), result.placement}, std::move(net.decisions)});
  if (fair.flagged_edges + fair.flagged_faces > 0)
    options.callbacks.warn(folds_left_warning(fair.flagged_edges, fair.flagged_faces));
  const auto concave = std::ssize(concave_faces(mesh));
  if (concave > 0)
    options.callbacks.warn(
        concave_faces_warning(concave, std::ssize(with_convex_faces(mesh).concave_faces)));
}

}  // namespace planish
