#include "planish/pipeline/found_creases.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/formatted.h"
#include "planish/core/host_scope.h"
#include "planish/mesh/folded_edges.h"
#include "planish/pipeline/deep_folds.h"
#include "planish/surface/block_quality.h"

namespace planish {

namespace {

constexpr int kRounds = 4;
// Corners of a face from which on it is more than what lies around a vertex.
constexpr std::size_t kLargeFace = 16;
// So many creases are no loss: parts of few are not to fold at all.
constexpr double kFewCreases = 16;

// A fit that is not given out yet, with its tags.
struct CreasedCandidate {
  Fit fit;
  FoundCreases found;
  std::vector<CreaseEdge> creases;
  std::vector<CornerVertex> corners;
  std::vector<Warning> warnings;
  std::vector<std::uint8_t> folded;  // by used vertex
  double area = 0;                   // folded of levels 1 to 3, the largest share
};

double folded_area(const PolygonMesh& mesh, const Fit& fitted, const FitOptions& options,
                   const Callbacks& callbacks) {
  EvaluateOptions evaluation;
  evaluation.weights = options.weights;
  evaluation.sharp = options.sharp;
  const auto surface = fitted_surface(mesh, fitted, evaluation);
  const FoldedEdges folds = folded_edges(mesh, *fitted.prepared->topology);
  double area = 0;
  for (int level = 1; level <= 3; ++level) {
    const SurfaceQuality quality =
        surface_quality(*surface->level(level), mesh, folds.is_beside,
                        share_of(callbacks, (level - 1) / 3.0, level / 3.0));
    area = std::max(area, quality.folded_area_elsewhere);
  }
  return area;
}

CreasedCandidate creased_candidate(const PolygonMesh& mesh, const FoundCreases& found,
                                   Backend& backend, FitOptions options) {
  CreasedCandidate result;
  result.found = found;
  const Callbacks whole = options.callbacks;
  options.callbacks = share_of(whole, 0, 0.6);
  options.method = InterpolationMethod::Fair;
  options.callbacks.warning = [&](const Warning& warning) { result.warnings.push_back(warning); };
  result.fit = fit(mesh, backend, options);
  result.creases = mesh.creases;
  result.corners = mesh.corners;
  const UsedPart used = used_part(mesh, result.fit.prepared);
  DeepFolds folds =
      DeepLook(used.mesh, *used.prepared->topology, *result.fit.features, options.weights)
          .at(result.fit.fair->level_one, share_of(whole, 0.6, 0.8));
  result.folded = std::move(folds.at_vertex);
  // A place of a coarser level counts for more of the area.
  if (folds.area > 0) result.area = folded_area(mesh, result.fit, options, share_of(whole, 0.8, 1));
  return result;
}

std::vector<std::int32_t> numbers_of(std::span<const std::uint8_t> flags) {
  std::vector<std::int32_t> numbers;
  for (std::size_t v = 0; v < flags.size(); ++v)
    if (flags[v] != 0) numbers.push_back(static_cast<std::int32_t>(v));
  return numbers;
}

// Adds the vertices that are folded, and from the second round on the faces around all of them:
// what folds a vertex may run past it. Of a large face only those beside them.
void spread(std::vector<std::uint8_t>& smooth, const CreasedCandidate& folded,
            const PolygonMesh& mesh, bool widens) {
  const PreparedMesh& prepared = *folded.fit.prepared;
  for (std::size_t v = 0; v < folded.folded.size(); ++v)
    if (folded.folded[v] != 0) smooth[prepared.vertices[v]] = 1;
  if (!widens) return;
  const std::vector<std::uint8_t> before = smooth;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const auto was_smooth = [&](std::int32_t v) { return before[v] != 0; };
    if (face.size() <= kLargeFace && std::ranges::any_of(face, was_smooth)) {
      for (const std::int32_t v : face) smooth[v] = 1;
      continue;
    }
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::int32_t v0 = face[i], v1 = face[(i + 1) % face.size()];
      if (was_smooth(v0) || was_smooth(v1)) smooth[v0] = smooth[v1] = 1;
    }
  }
}

// Tags at smooth vertices that are among those found.
template <class Tag, class Found, class IsSmooth>
void drop_found(std::vector<Tag>& tags, std::vector<Found>& found, const auto& found_of,
                const IsSmooth& is_smooth) {
  std::erase_if(tags, [&](const Tag& tag) {
    const Found one = found_of(tag);
    return is_smooth(one) && std::ranges::binary_search(found, one);
  });
  std::erase_if(found, is_smooth);
}

}  // namespace

void add_tags(PolygonMesh& mesh, const FoundCreases& found) {
  const auto require_vertex = [&](std::int32_t vertex) {
    if (vertex < 0 || vertex >= mesh.vertex_count())
      throw Error(ErrorCode::UnusableMesh, formatted("vertex {} is sharp, of a mesh of {}", vertex,
                                                     counted(mesh.vertex_count(), "vertex")));
  };
  for (const auto& [v0, v1] : found.edges) {
    require_vertex(v0);
    require_vertex(v1);
    mesh.creases.push_back({v0, v1});
  }
  for (const std::int32_t corner : found.corners) {
    require_vertex(corner);
    mesh.corners.push_back({corner});
  }
}

FoundCreases add_features(PolygonMesh& mesh, const std::shared_ptr<const PreparedMesh>& prepared,
                          const FeatureRules& rules, const std::function<void(double)>& done) {
  const UsedPart used = used_part(mesh, prepared);
  const Features features = find_features(used.mesh, *prepared->topology, rules, done);
  std::vector<char> is_tagged(mesh.positions.size(), 0);
  for (const CornerVertex& corner : mesh.corners) is_tagged[corner.vertex] = 1;
  FoundCreases found;
  for (const FeatureEdge& edge : features.edges) {
    if (!edge.is_sharp || edge.reason == FeatureReason::Tagged) continue;
    const auto [v0, v1] = std::minmax(used.vertices[edge.v0], used.vertices[edge.v1]);
    found.edges.push_back({v0, v1});
  }
  for (const std::int32_t corner : features.corners)
    if (const std::int32_t vertex = used.vertices[corner]; is_tagged[vertex] == 0)
      found.corners.push_back(vertex);
  std::ranges::sort(found.edges);
  std::ranges::sort(found.corners);
  add_tags(mesh, found);
  return found;
}

void leave_smooth(PolygonMesh& mesh, FoundCreases& found, std::span<const std::int32_t> vertices) {
  std::vector<std::uint8_t> smooth(mesh.positions.size(), 0);
  for (const std::int32_t v : vertices) smooth[v] = 1;
  using Edge = std::array<std::int32_t, 2>;
  drop_found(
      mesh.creases, found.edges,
      [](const CreaseEdge& crease) {
        const auto [v0, v1] = std::minmax(crease.v0, crease.v1);
        return Edge{v0, v1};
      },
      [&](const Edge& edge) { return smooth[edge[0]] != 0 || smooth[edge[1]] != 0; });
  drop_found(
      mesh.corners, found.corners, [](const CornerVertex& corner) { return corner.vertex; },
      [&](std::int32_t vertex) { return smooth[vertex] != 0; });
}

namespace {

CreasedFit creased_fit(PolygonMesh& mesh, FoundCreases found, Backend& backend,
                       const FitOptions& options) {
  RoundParts rounds(options.callbacks, 0.8);  // mostly one is enough
  FitOptions prepared = options;
  prepared.callbacks = rounds.next();
  CreasedCandidate best = creased_candidate(mesh, found, backend, prepared);
  prepared.prepared = best.fit.prepared;
  std::vector<std::uint8_t> smooth(mesh.positions.size(), 0);
  const auto first_count = static_cast<double>(best.creases.size());
  const auto lost = [&](std::size_t creases) {
    const double count = first_count - static_cast<double>(creases) - kFewCreases;
    return kWorthAllCreases * std::max(count / first_count, 0.0);
  };
  double least = best.area;
  // False where what is taken back costs more than all folds that are left.
  const auto try_smooth = [&] {
    const std::size_t before = mesh.creases.size() + mesh.corners.size();
    leave_smooth(mesh, found, numbers_of(smooth));
    if (lost(mesh.creases.size()) >= least) return false;
    if (mesh.creases.size() + mesh.corners.size() == before) return true;
    prepared.callbacks = rounds.next();
    CreasedCandidate next = creased_candidate(mesh, found, backend, prepared);
    const double cost = next.area + lost(next.creases.size());
    if (cost >= least) return true;
    least = cost;
    best = std::move(next);
    return true;
  };
  bool is_worth_it = true;
  for (int round = 0; round < kRounds && is_worth_it && best.area > 0; ++round) {
    spread(smooth, best, mesh, round > 0);
    is_worth_it = try_smooth();
  }
  if (best.area > 0) {
    std::ranges::fill(smooth, 1);
    try_smooth();
  }
  mesh.creases = std::move(best.creases);
  mesh.corners = std::move(best.corners);
  for (const Warning& warning : best.warnings) options.callbacks.warn(warning);
  return {std::move(best.fit), std::move(best.found)};
}

}  // namespace

CreasedFit fit_with_found_creases(PolygonMesh& mesh, const FoundCreases& found, Backend& backend,
                                  const FitOptions& options) {
  const HostScope host(options.callbacks);
  CreasedFit result;
  backend.run_on_host([&] { result = creased_fit(mesh, found, backend, options); });
  options.callbacks.report("solve", 1);
  return result;
}

}  // namespace planish
