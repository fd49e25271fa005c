#include "planish/reconstruct/simplify.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/reconstruct/collapse_pass.h"
#include "planish/reconstruct/flip_pass.h"
#include "planish/reconstruct/move_pass.h"
#include "planish/reconstruct/witnesses.h"

namespace planish {
namespace {

// Each round's flips and moves give the next one's collapses room: with adaptive spacing the second
// takes 11 % of the vertices that the first leaves, the third 2 %, the fourth half a percent.
constexpr int kMostRounds = 12;
// A round that takes a smaller share is the last.
constexpr double kLeastShare = 0.002;
// Of the time that is left, what the first round takes, and what each of the others does.
constexpr double kFirstRound = 0.6, kFurtherRound = 0.5;

void check_simplify_options(const SimplifyOptions& options) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::InvalidArgument, what);
  };
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
    refuse("the tolerance of the mesh must be a positive length");
  if (options.least_angle > 45)
    refuse(formatted("min-angle: {} is not from 0 to 45 degrees",
                     std::to_string(options.least_angle)));
  if (options.max_valence >= 0 && options.max_valence < 6)
    refuse(formatted("max-valence: {} is below 6", options.max_valence));
  if (options.target_vertices < 0) refuse("target-vertices: a count from 0 is needed");
}

void run_rounds(SimplifyState& state) {
  CollapsePass collapses(state);
  FlipPass flips(state);
  MovePass moves(state);
  double done = 0;
  for (int round = 0; round < kMostRounds && !state.is_done(); ++round) {
    const double begun = done;
    done += (1 - done) * (round == 0 ? kFirstRound : kFurtherRound);
    state.begin_round(begun, done);
    const std::int64_t before = state.result.collapse_count;
    collapses.run();
    flips.run();
    moves.run();
    flips.run();
    const auto taken = static_cast<double>(state.result.collapse_count - before);
    if (taken < kLeastShare * static_cast<double>(state.result.vertex_count)) break;
  }
}

// The mesh with its vertices, and then its triangles, in the order of the points: the passes look
// at neighbours, which then are near in memory, too. All points without a vertex are carried.
WitnessedMesh in_order(const OrderedPoints& points, std::span<const Triangle> triangles) {
  std::vector<std::int32_t> vertex(points.size(), -1);  // of a point as it was given
  for (const Triangle& triangle : triangles)
    for (const std::int32_t corner : triangle) vertex[corner] = 0;
  WitnessedMesh mesh;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (vertex[points.given(i)] < 0) continue;
    vertex[points.given(i)] = static_cast<std::int32_t>(mesh.vertex_points.size());
    mesh.vertex_points.push_back(static_cast<std::int32_t>(i));
  }
  mesh.triangles.assign(triangles.begin(), triangles.end());
  for (Triangle& triangle : mesh.triangles) {
    for (std::int32_t& corner : triangle) corner = vertex[corner];
    std::ranges::rotate(triangle, std::ranges::min_element(triangle));
  }
  std::ranges::sort(mesh.triangles);
  return mesh;
}

}  // namespace

double default_least_angle(Spacing spacing) { return spacing == Spacing::Even ? 22.0 : 12.0; }

std::int32_t default_max_valence(Spacing spacing) { return spacing == Spacing::Even ? 8 : 10; }

SimplifiedMesh simplify(const OrderedPoints& points, WitnessedMesh mesh,
                        const SimplifyOptions& options) {
  check_simplify_options(options);
  const HostScope host(options.callbacks);
  options.callbacks.report("simplify", 0.0);
  SimplifyState state(points, std::move(mesh), options);
  run_rounds(state);
  SimplifiedMesh result = std::move(state.result);
  for (std::size_t t = 0; t < state.mesh.triangle_count(); ++t) {
    if (!state.mesh.is_alive(static_cast<std::int32_t>(t))) continue;
    Triangle triangle = state.mesh.triangle(static_cast<std::int32_t>(t));
    for (std::int32_t& corner : triangle) corner = state.vertex_points[corner];
    result.triangles.push_back(triangle);
  }
  options.callbacks.report("simplify", 1.0);
  return result;
}

SimplifiedMesh simplify(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                        const SimplifyOptions& options) {
  check_simplify_options(options);
  const OrderedPoints points(positions);
  WitnessedMesh mesh = in_order(points, triangles);
  LoopProgress progress(options.callbacks, "simplify", 0, 0, std::ssize(positions));
  const std::int64_t strayed_count =
      std::ssize(find_carriers(points, mesh, options.tolerance, options.tolerance, progress));
  SimplifiedMesh result = simplify(points, std::move(mesh), options);
  result.strayed_count = strayed_count;
  for (Triangle& triangle : result.triangles)
    for (std::int32_t& corner : triangle) corner = points.given(corner);
  return result;
}

}  // namespace planish
