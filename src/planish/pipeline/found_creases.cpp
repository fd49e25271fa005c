#include "planish/pipeline/found_creases.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <numbers>
#include <utility>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/mesh/angle_between.h"
#include "planish/mesh/coarse_balls.h"
#include "planish/mesh/cone_apexes.h"
#include "planish/mesh/face_areas.h"
#include "planish/mesh/folded_edges.h"
#include "planish/mesh/outline_corners.h"
#include "planish/pipeline/deep_folds.h"
#include "planish/surface/block_quality.h"

namespace planish {

namespace {

constexpr int kRounds = 4;
// Of all turns; see pipeline/details.md.
constexpr double kClearShare = 0.9;
// By what the flattest crease turns more than the sharpest other edge where they are apart.
constexpr double kApart = 1.5;
// Corners of a face from which on it is more than what lies around a vertex.
constexpr std::size_t kLargeFace = 16;
// So many creases are no loss: parts of few are not to fold at all.
constexpr double kFewCreases = 16;

// A fit that is not given out yet, with its tags.
struct CreasedCandidate {
  Fit fit;
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

CreasedCandidate creased_candidate(const PolygonMesh& mesh, Backend& backend, FitOptions options) {
  CreasedCandidate result;
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

void find(PolygonMesh& mesh, const PreparedMesh& prepared, const CreaseDetectionOptions& options) {
  if (prepared.uses_all()) {
    detect_creases(mesh, *prepared.topology, options);
  } else {
    mesh = with_detected_creases(mesh, options);
  }
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

enum class Clarity { Unclear, OfBalls, Clear, Apart };

Clarity clarity_of(const PolygonMesh& mesh, const std::shared_ptr<const PreparedMesh>& prepared,
                   const CreaseDetectionOptions& options) {
  if (mesh.creases.empty()) return Clarity::Unclear;
  const UsedPart used = used_part(mesh, prepared);
  const MeshTopology& topology = *prepared->topology;
  std::vector<std::uint8_t> is_crease(static_cast<std::size_t>(topology.edge_count()), 0);
  for (const CreaseEdge& crease : used.mesh.creases) {
    const std::int32_t edge = topology.find_edge(crease.v0, crease.v1);
    if (edge >= 0) is_crease[edge] = 1;
  }
  const std::vector<glm::dvec3> areas = face_areas(used.mesh);
  double all = 0, of_creases = 0;
  double flattest = std::numbers::pi, sharpest_other = 0;
  bool is_any_smooth = false;
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    if (topology.is_boundary_edge(e)) continue;
    is_any_smooth |= is_crease[e] == 0;
    const std::int32_t corner = topology.corner_of(e), twin = topology.twin(corner);
    const glm::dvec3 &a = areas[topology.face_of(corner)], &b = areas[topology.face_of(twin)];
    const double turn = angle_between(a, b);
    const double weight = glm::length(a) / topology.face_size(topology.face_of(corner)) +
                          glm::length(b) / topology.face_size(topology.face_of(twin));
    all += turn * turn * weight;
    if (is_crease[e] != 0) {
      of_creases += turn * turn * weight;
      flattest = std::min(flattest, turn);
    } else {
      sharpest_other = std::max(sharpest_other, turn);
    }
  }
  const bool are_apart = sharpest_other <= glm::radians(options.dihedral_degrees) &&
                         flattest >= kApart * sharpest_other;
  if (!are_apart && of_creases < kClearShare * all) return Clarity::Unclear;
  if (!is_any_smooth && are_coarse_balls(used.mesh, topology, areas)) return Clarity::OfBalls;
  return are_apart ? Clarity::Apart : Clarity::Clear;
}

}  // namespace

CreaseDetectionOptions crease_detection(double degrees) {
  CreaseDetectionOptions options{.dihedral_degrees = degrees};
  if (degrees >= kOutlineDegrees) options.corner_degrees = kOutlineCornerDegrees;
  return options;
}

FoundCreases add_found_creases(PolygonMesh& mesh, const PreparedMesh& prepared,
                               const CreaseDetectionOptions& options) {
  FoundCreases found{options, mesh.creases, mesh.corners};
  found.options.smooth_vertices = {};
  find(mesh, prepared, options);
  return found;
}

ClearCreases add_clear_creases(PolygonMesh& mesh,
                               const std::shared_ptr<const PreparedMesh>& prepared,
                               CreaseTrial trial) {
  if (trial == CreaseTrial::None || !mesh.creases.empty()) return {};
  FoundCreases found = add_found_creases(mesh, *prepared, {});
  const Clarity clarity = clarity_of(mesh, prepared, found.options);
  const bool are_of_balls = clarity == Clarity::OfBalls;
  if (clarity != Clarity::Unclear && (!are_of_balls || trial == CreaseTrial::All))
    return {std::move(found), false, clarity == Clarity::Apart};
  mesh.creases = found.creases;
  mesh.corners = found.corners;
  return {std::nullopt, are_of_balls};
}

void leave_smooth(PolygonMesh& mesh, const PreparedMesh& prepared, const FoundCreases& found,
                  std::span<const std::int32_t> smoothed_vertices) {
  std::vector<std::uint8_t> smooth(mesh.positions.size(), 0);
  for (const std::int32_t v : smoothed_vertices)
    if (v >= 0 && v < mesh.vertex_count()) smooth[v] = 1;
  mesh.creases = found.creases;
  mesh.corners = found.corners;
  CreaseDetectionOptions options = found.options;
  options.smooth_vertices = smooth;
  find(mesh, prepared, options);
}

std::optional<std::vector<std::int32_t>> add_outline_corners(
    PolygonMesh& mesh, const std::shared_ptr<const PreparedMesh>& prepared) {
  const CreaseDetectionOptions options = crease_detection(kOutlineDegrees);
  std::vector<std::uint8_t> is_clear(mesh.positions.size(), 0);
  {
    const UsedPart used = used_part(mesh, prepared);
    const MeshTopology& topology = *prepared->topology;
    const auto corners = outline_corners(used.mesh, topology, options.corner_degrees);
    const std::vector<std::uint8_t> none_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
    const auto apexes = cone_apexes(topology, face_areas(used.mesh), none_sharp);
    if (corners.empty() && apexes.empty()) return std::nullopt;
    for (const auto& clear : {corners, apexes})
      for (const std::int32_t v : clear) is_clear[used.vertices[v]] = 1;
  }
  const FoundCreases found = add_found_creases(mesh, *prepared, options);
  std::vector<std::int32_t> smoothed;
  for (std::size_t i = found.corners.size(); i < mesh.corners.size(); ++i)
    if (is_clear[mesh.corners[i].vertex] == 0) smoothed.push_back(mesh.corners[i].vertex);
  std::ranges::sort(smoothed);
  if (!smoothed.empty()) leave_smooth(mesh, *prepared, found, smoothed);
  return smoothed;
}

void tag_outline_corners(PolygonMesh& mesh, const PreparedMesh& prepared,
                         std::span<const std::int32_t> smoothed_vertices) {
  const FoundCreases before{crease_detection(kOutlineDegrees), mesh.creases, mesh.corners};
  leave_smooth(mesh, prepared, before, smoothed_vertices);
}

namespace {

CreasedFit creased_fit(PolygonMesh& mesh, const FoundCreases& found, Backend& backend,
                       const FitOptions& options) {
  CreasedFit result;
  RoundParts rounds(options.callbacks, 0.8);  // mostly one is enough
  FitOptions prepared = options;
  prepared.callbacks = rounds.next();
  CreasedCandidate best = creased_candidate(mesh, backend, prepared);
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
    std::vector<std::int32_t> smoothed = numbers_of(smooth);
    const std::size_t before = mesh.creases.size() + mesh.corners.size();
    leave_smooth(mesh, *prepared.prepared, found, smoothed);
    if (lost(mesh.creases.size()) >= least) return false;
    if (mesh.creases.size() + mesh.corners.size() == before) return true;
    prepared.callbacks = rounds.next();
    CreasedCandidate next = creased_candidate(mesh, backend, prepared);
    const double cost = next.area + lost(next.creases.size());
    if (cost >= least) return true;
    least = cost;
    result.smoothed_vertices = std::move(smoothed);
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
  result.fit = std::move(best.fit);
  return result;
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
