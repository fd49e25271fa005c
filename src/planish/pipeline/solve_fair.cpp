#include "planish/pipeline/solve_fair.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/fair/fair_builder.h"
#include "planish/mesh/convex_faces.h"
#include "planish/pipeline/deep_folds.h"

namespace planish {

namespace {

constexpr int kDeepRounds = 6;

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

void warn_of_folds(const FairFit& fair, const Callbacks& callbacks) {
  const std::int64_t count = fair.flagged_edges + fair.flagged_faces;
  if (count == 0) return;
  callbacks.warn({"folds-left",
                  "the fair surface still turns over at " + std::to_string(fair.flagged_edges) +
                      " edges and " + std::to_string(fair.flagged_faces) +
                      " faces, where the mesh itself is folded or too sharp for a smooth surface; "
                      "--creases auto keeps sharp edges sharp",
                  count, -1});
}

void warn_of_concave_faces(const PolygonMesh& mesh, const Callbacks& callbacks) {
  const std::vector<std::int32_t> faces = concave_faces(mesh);
  if (faces.empty()) return;
  callbacks.warn({"concave-faces",
                  "faces with corners that turn inward, beside which the fair surface may fold: " +
                      std::to_string(faces.size()) +
                      "; with_convex_faces() and --repair safe cut them in parts unless they cross "
                      "themselves",
                  static_cast<std::int64_t>(faces.size()), -1});
}

// On the backend's device where it can.
FairNet make_net(const PolygonMesh& mesh, const Subdivision& subdivision,
                 std::span<const glm::dvec3> given, Backend& backend, const FitOptions& options) {
  const FairOptions fair{options.polish_steps, options.callbacks, options.fair_decisions,
                         options.cures_folds};
  if (fair.decisions && fair.decisions->reversed.size() != given.size()) {
    throw Error(ErrorCode::InvalidArgument,
                "fair_decisions are of " + std::to_string(fair.decisions->reversed.size()) +
                    " vertices, the mesh has " + std::to_string(given.size()) +
                    "; take those of the same mesh");
  }
  if (fair.decisions && !fair.decisions->leans.empty() &&
      fair.decisions->leans.size() != given.size()) {
    throw Error(ErrorCode::InvalidArgument,
                "fair_decisions have leans of " + std::to_string(fair.decisions->leans.size()) +
                    " vertices, the mesh has " + std::to_string(given.size()) +
                    "; take those of the same mesh, or none");
  }
  auto* const builder = dynamic_cast<FairBuilder*>(&backend);
  if (!builder) return fair_net(mesh, subdivision, given, fair);
  return builder->build_fair_net(make_fair_topology(mesh, subdivision), given, fair);
}

// Folds between the places that the construction looks at shrink with the polygons around: those of
// the vertices beside them are cured once more, in a net of the same decisions otherwise. Not
// every round helps: the best net counts.
FairNet deeply_cured_net(const Fit& result, const PolygonMesh& mesh, const Subdivision& subdivision,
                         std::span<const glm::dvec3> given, Backend& backend,
                         const FitOptions& options) {
  FairNet net = make_net(mesh, subdivision, given, backend, options);
  const bool cures = options.cures_folds && options.fair_decisions == nullptr &&
                     net.decisions.cures.size() == given.size();
  if (!cures) return net;
  const auto folds_of = [&](FairNet& of) {
    LevelOne level_one{std::move(of.state), result.placement};
    DeepFolds folds = deep_folds(mesh, result.prepared->topology, level_one, options);
    of.state = std::move(level_one.state);
    return folds;
  };
  DeepFolds folds = folds_of(net);
  double least = folds.area;
  FairDecisions decisions = net.decisions;
  for (int round = 0; round < kDeepRounds && folds.area > kNoDeepFolds; ++round) {
    options.callbacks.check_cancelled();
    for (std::size_t v = 0; v < given.size(); ++v) decisions.cures[v] += folds.at_vertex[v];
    FitOptions decided = options;
    decided.fair_decisions = &decisions;
    FairNet next = make_net(mesh, subdivision, given, backend, decided);
    folds = folds_of(next);
    if (folds.area >= least) continue;
    least = folds.area;
    net = std::move(next);
  }
  return net;
}

}  // namespace

void solve_fair(Fit& result, const PolygonMesh& mesh, const Subdivision& subdivision,
                std::span<const glm::dvec3> given, Backend& backend, const FitOptions& options) {
  FairNet net = deeply_cured_net(result, mesh, subdivision, given, backend, options);
  result.interpolation = measured(subdivision, net.state, given, options.tolerance);
  FairFit& fair = result.fair.emplace();
  fair.level_one = {std::move(net.state), result.placement};
  fair.shrunk_vertices = net.shrunk_vertices;
  fair.reversed_vertices = net.reversed_vertices;
  fair.cured_vertices = net.cured_vertices;
  fair.flagged_edges = net.flagged_edges;
  fair.flagged_faces = net.flagged_faces;
  fair.decisions = std::move(net.decisions);
  warn_of_folds(fair, options.callbacks);
  warn_of_concave_faces(mesh, options.callbacks);
}

}  // namespace planish
