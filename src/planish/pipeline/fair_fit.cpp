#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/fold_cure.h"
#include "planish/fair/semi_sharp.h"
#include "planish/measure/figures.h"
#include "planish/mend/repair.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/patches/patch_surface.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/surface/evaluate.h"

namespace planish {
namespace {

constexpr std::size_t kDeepGrain = 512, kCornersAtOnce = 128;
constexpr int kDeepLevel = 3;
constexpr int kDeepRounds = 6;
constexpr std::int64_t kCells = 16;  // quads of that level over a corner of a face
// Cosine of a vertex's normal with all its faces from which the fair construction's own places
// speak for all others, as in fair/fold_cure.cpp.
constexpr double kEvenCosine = 0.9;

std::vector<glm::dvec3> unit_normals(const PolygonMesh& mesh) {
  std::vector<glm::dvec3> normals(static_cast<std::size_t>(mesh.face_count()));
  parallel_each(normals.size(), kDeepGrain, [&](std::int32_t f) {
    normals[f] = unit_or_zero(area_vector(mesh.positions, mesh.face(f)));
  });
  return normals;
}

// Faces of any size speak alike.
bool is_even(const MeshTopology& topology, std::span<const glm::dvec3> normals,
             std::int32_t vertex) {
  glm::dvec3 sum(0.0);
  for (const std::int32_t c : topology.corners_at(vertex)) sum += normals[topology.face_of(c)];
  const double least = kEvenCosine * glm::length(sum);
  return std::ranges::all_of(topology.corners_at(vertex), [&](std::int32_t c) {
    return glm::dot(sum, normals[topology.face_of(c)]) >= least;
  });
}

// Also those of faces at curves: what folds at the curve's end of a needle is as wide at the other.
std::vector<std::uint8_t> uneven_vertices(const MeshTopology& topology,
                                          const SharpFeatures& features,
                                          std::span<const glm::dvec3> normals) {
  const auto is_on_curve = [&](std::int32_t v) {
    return features.vertex_kinds[v] != VertexKind::Smooth;
  };
  std::vector<std::uint8_t> is_at_curve(normals.size());  // by face
  parallel_each(is_at_curve.size(), kDeepGrain, [&](std::int32_t f) {
    is_at_curve[f] = std::ranges::any_of(topology.face(f), is_on_curve);
  });
  std::vector<std::uint8_t> uneven(features.vertex_kinds.size(), 0);
  parallel_each(uneven.size(), kDeepGrain, [&](std::int32_t vertex) {
    uneven[vertex] = is_on_curve(vertex) ||
                     std::ranges::any_of(
                         topology.corners_at(vertex),
                         [&](std::int32_t c) { return is_at_curve[topology.face_of(c)] != 0; }) ||
                     !is_even(topology, normals, vertex);
  });
  return uneven;
}

// The vertices of faces at flagged ones, but those that were looked at: polygons of neighbours that
// stay large may reach past a polygon that was made small.
std::vector<std::uint8_t> neighbours_of(const MeshTopology& topology,
                                        std::span<const std::uint8_t> flagged,
                                        std::span<const std::uint8_t> looked_at) {
  std::vector<std::uint8_t> result(flagged.size(), 0);
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    const auto face = topology.face(f);
    if (std::ranges::none_of(face, [&](std::int32_t v) { return flagged[v] != 0; })) continue;
    for (const std::int32_t v : face) result[v] = looked_at[v] == 0;
  }
  return result;
}

// The quads over some corners, many at once: patches of one class are evaluated side by side.
class CornerMeter {
 public:
  CornerMeter(const MeshTopology& topology, std::span<const glm::dvec3> points,
              const Placement& placement, const PatchSurface& surface,
              std::span<const glm::dvec3> normals, std::span<double> folded_areas)
      : topology_(topology),
        points_(points),
        placement_(placement),
        surface_(surface),
        normals_(normals),
        folded_areas_(folded_areas),
        cells_(kDeepLevel) {}

  // Writes the folded area over each of the corners.
  void measure(std::span<const std::int32_t> corners) {
    const PatchSamples& samples = surface_.numbering().samples();
    const auto count = static_cast<std::size_t>(samples.count());
    positions_.resize(corners.size() * count);
    corner_normals_.resize(positions_.size());
    PatchTarget target;
    target.positions = positions_;
    target.normals = corner_normals_;
    (void)surface_.grids(points_, placement_, corners, target);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      folded_areas_[corners[i]] = folded_area(corners[i], i * count);
    }
  }

 private:
  // `first`: where the corner's samples begin.
  [[nodiscard]] double folded_area(std::int32_t corner, std::size_t first) const {
    const PatchSamples& samples = surface_.numbering().samples();
    const std::int32_t side = samples.side() + 1;
    const glm::dvec3& normal = normals_[topology_.face_of(corner)];
    double folded = 0;
    for (const std::array<std::int32_t, 4>& cell : cells_.of(topology_, corner)) {
      std::array<std::size_t, 4> at;
      std::ranges::transform(cell, at.begin(), [&](std::int32_t place) {
        return first + static_cast<std::size_t>(samples.index(place % side, place / side));
      });
      const double share = glm::length(glm::cross(positions_[at[2]] - positions_[at[0]],
                                                  positions_[at[3]] - positions_[at[1]])) /
                           8;
      for (const std::size_t k : at) {
        if (glm::dot(glm::dvec3(corner_normals_[k]), normal) < 0) folded += share;
      }
    }
    return folded;
  }

  const MeshTopology& topology_;
  std::span<const glm::dvec3> points_;
  const Placement& placement_;
  const PatchSurface& surface_;
  std::span<const glm::dvec3> normals_;
  std::span<double> folded_areas_;
  PatchCells cells_;
  std::vector<glm::dvec3> positions_;
  std::vector<glm::vec3> corner_normals_;
};

bool is_anywhere(std::span<const std::uint8_t> flags, FairHalo* halo) {
  return is_in_any_part(halo, std::ranges::find(flags, 1) != flags.end());
}

// Of all faces.
double area_of(const PolygonMesh& mesh, FairHalo* halo) {
  std::vector<double> areas;
  double all = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const double area = glm::length(area_vector(mesh.positions, mesh.face(f)));
    all += area;
    if (halo) areas.push_back(area);
  }
  return halo ? halo->sum_of_faces(areas) : all;
}

// Whether corners of that level can be numbered, of the whole mesh.
bool can_look(const MeshTopology& topology, FairHalo* halo) {
  std::int64_t corners = 0;
  for (std::int32_t f = 0; f < topology.face_count(); ++f)
    if (owns_face(halo, f)) corners += topology.face_size(f);
  return sum_of_parts(halo, corners) <= std::numeric_limits<std::int32_t>::max() / (4 * kCells);
}

}  // namespace

struct DeepLook::Parts {
  Parts(const PolygonMesh& of, const MeshTopology& its, const SharpFeatures& its_features,
        Weights its_weights, FairHalo* its_halo);

  void make_surface();
  void forget_what_changed(std::span<const glm::dvec3> state);
  void look(const LevelOne& level_one, std::span<const std::uint8_t> at,
            std::span<std::uint8_t> at_vertex, LoopProgress& progress);
  [[nodiscard]] double area(std::span<const std::uint8_t> at_vertex) const;

  const PolygonMesh& mesh;
  const MeshTopology& topology;
  const SharpFeatures& features;
  Weights weights;
  FairHalo* halo;
  std::vector<glm::dvec3> normals;
  bool is_any_wanted = false;        // by any part
  std::vector<std::uint8_t> wanted;  // at first
  // Made once there is something to look at. A part of a mesh may have no faces.
  std::optional<PatchMesh> patch_mesh;
  std::optional<PatchSurface> patches;
  FoldedEdges folds;
  double mesh_area = 0;
  std::vector<double> areas, corner_areas;  // folded, per vertex and per corner
  // By corner, of the last look where it found something: another one asks again only for what has
  // changed.
  std::vector<std::uint8_t> is_known;
  std::vector<glm::dvec3> last_state;
};

DeepLook::Parts::Parts(const PolygonMesh& of, const MeshTopology& its,
                       const SharpFeatures& its_features, Weights its_weights, FairHalo* its_halo)
    : mesh(of), topology(its), features(its_features), weights(its_weights), halo(its_halo) {
  if (!can_look(topology, halo)) return;
  normals = unit_normals(mesh);
  wanted = uneven_vertices(topology, features, normals);
  if (halo) halo->exchange_vertices(wanted);
  is_any_wanted = is_anywhere(wanted, halo);
  if (!is_any_wanted) return;
  const std::vector<std::uint8_t> around = neighbours_of(topology, wanted, wanted);
  for (std::size_t v = 0; v < wanted.size(); ++v) wanted[v] |= around[v];
  make_surface();
}

void DeepLook::Parts::make_surface() {
  areas.assign(mesh.positions.size(), 0);
  corner_areas.assign(static_cast<std::size_t>(topology.corner_count()), 0);
  is_known.assign(corner_areas.size(), 0);
  mesh_area = area_of(mesh, halo);
  if (mesh.face_count() == 0) return;
  patch_mesh.emplace(topology, features, ring_columns(topology, weights));
  patches.emplace(*patch_mesh,
                  PatchSurfaceOptions{.level = kDeepLevel, .weights = weights, .hidden = {}});
  folds = folded_edges(mesh, topology);
}

// A corner's patch is of the points around the vertices of its face.
void DeepLook::Parts::forget_what_changed(std::span<const glm::dvec3> state) {
  if (!patch_mesh) return;
  if (last_state.empty()) {
    std::ranges::fill(is_known, 0);
    return;
  }
  std::vector<std::uint8_t> changed(areas.size(), 0);
  const std::int32_t corner_count = topology.corner_count();
  for (std::int32_t c = 0; c < corner_count; ++c)
    if (state[c] != last_state[c]) changed[topology.vertex_of(c)] = 1;
  for (std::int32_t e = 0; features.sharp_edge_count > 0 && e < topology.edge_count(); ++e) {
    if (!patch_mesh->is_sharp_edge(e)) continue;
    const std::int32_t point = corner_count + 2 * features.sharp_of_edge[e];
    if (state[point] == last_state[point] && state[point + 1] == last_state[point + 1]) continue;
    const auto [v0, v1] = topology.edge_vertices(e);
    changed[v0] = changed[v1] = 1;
  }
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    const auto face = topology.face(f);
    if (std::ranges::any_of(face, [&](std::int32_t v) { return changed[v] != 0; }))
      std::fill_n(is_known.begin() + topology.first_corner(f), face.size(), 0);
  }
}

// At these vertices, those of other parts left out.
void DeepLook::Parts::look(const LevelOne& level_one, std::span<const std::uint8_t> at,
                           std::span<std::uint8_t> at_vertex, LoopProgress& progress) {
  if (!patches) return;
  const auto is_meant = [&](std::int32_t vertex) {
    return at[vertex] != 0 && owns_vertex(halo, vertex);
  };
  const RawVector<glm::dvec3> with_sums =
      patch_mesh->has_sums() ? patch_mesh->with_sums(level_one.state) : RawVector<glm::dvec3>();
  const std::span<const glm::dvec3> points =
      patch_mesh->has_sums() ? std::span<const glm::dvec3>(with_sums) : level_one.state;
  parallel_for(corner_areas.size(), kDeepGrain, [&](std::size_t begin, std::size_t end) {
    CornerMeter meter(topology, points, level_one.placement, *patches, normals, corner_areas);
    std::vector<std::int32_t> corners;
    for (std::size_t c = begin; c < end; ++c) {
      const auto corner = static_cast<std::int32_t>(c);
      if (is_known[c] == 0 && is_meant(topology.vertex_of(corner))) {
        is_known[c] = 1;
        if (!folds.is_beside[topology.face_of(corner)]) corners.push_back(corner);
      }
      if (corners.size() < kCornersAtOnce && c + 1 < end) continue;
      meter.measure(corners);
      corners.clear();
    }
    progress.add(static_cast<std::int64_t>(end - begin));
  });
  for (std::size_t v = 0; v < areas.size(); ++v) {
    const auto vertex = static_cast<std::int32_t>(v);
    if (!is_meant(vertex)) continue;
    areas[v] = 0;
    for (const std::int32_t c : topology.corners_at(vertex)) areas[v] += corner_areas[c];
    at_vertex[v] = areas[v] > 0;
  }
}

// As a share of the mesh's.
double DeepLook::Parts::area(std::span<const std::uint8_t> at_vertex) const {
  std::vector<double> found(areas.size(), 0.0);
  for (std::size_t v = 0; v < found.size(); ++v)
    if (at_vertex[v] != 0 && owns_vertex(halo, static_cast<std::int32_t>(v))) found[v] = areas[v];
  const double folded =
      halo ? halo->sum_of_vertices(found) : std::accumulate(found.begin(), found.end(), 0.0);
  return mesh_area > 0 ? folded / mesh_area : folded;
}

DeepLook::DeepLook(const PolygonMesh& mesh, const MeshTopology& topology,
                   const SharpFeatures& features, Weights weights, FairHalo* halo)
    : parts_(std::make_unique<Parts>(mesh, topology, features, weights, halo)) {}
DeepLook::~DeepLook() = default;

DeepFolds DeepLook::at(const LevelOne& level_one, const Callbacks& callbacks) {
  DeepFolds result;
  Parts& parts = *parts_;
  FairHalo* const halo = parts.halo;
  if (!parts.is_any_wanted) return result;
  parts.forget_what_changed(level_one.state);
  result.at_vertex.assign(parts.mesh.positions.size(), 0);
  // Mostly there is nothing to look at once more.
  LoopProgress progress(callbacks, "folds", 0.2, 1, parts.topology.corner_count());
  parts.look(level_one, parts.wanted, result.at_vertex, progress);
  if (halo) halo->exchange_vertices(result.at_vertex);
  if (!is_anywhere(result.at_vertex, halo)) {
    if (!parts.last_state.empty()) parts.last_state = level_one.state;
    return result;
  }
  parts.look(level_one, neighbours_of(parts.topology, result.at_vertex, parts.wanted),
             result.at_vertex, progress);
  if (halo) halo->exchange_vertices(result.at_vertex);
  result.area = parts.area(result.at_vertex);
  parts.last_state = level_one.state;
  return result;
}

FairNet deeply_cured_net(const DeepCure& cure) {
  FairNet net = cure.make_net(nullptr);
  FairRounds rounds = net.rounds;
  const DeepFolds first = cure.folds_of(net);
  const FairDecisions first_decisions = first.area > kNoDeepFolds ? net.decisions : FairDecisions{};
  double least = first.area;
  // Of the rounds without ellipses: those with them are the same until one is chosen.
  std::vector<std::pair<DeepFolds, std::vector<glm::vec2>>> seen;  // folds, leans
  for (const bool with_ellipses : {false, true}) {
    FairDecisions decisions = first_decisions;
    DeepFolds folds = first;
    bool is_seen = with_ellipses;
    for (int round = 0; round < kDeepRounds && least > kNoDeepFolds; ++round) {
      std::vector<std::uint8_t> has_changed(folds.at_vertex.size(), 0);
      if (with_ellipses) has_changed = cure.choose_ellipses(folds.at_vertex, decisions);
      std::vector<std::uint8_t> is_new = has_changed;
      for (std::size_t v = 0; v < folds.at_vertex.size(); ++v) {
        if (folds.at_vertex[v] == 0 || is_new[v] != 0 || decisions.cures[v] >= kMostCures) continue;
        ++decisions.cures[v];
        is_new[v] = 1;
      }
      if (!is_anywhere(is_new, cure.halo)) break;
      is_seen = is_seen && !is_anywhere(has_changed, cure.halo);
      if (is_seen) {
        std::tie(folds, decisions.leans) = std::move(seen[round]);
        continue;
      }
      FairNet next = cure.make_net(&decisions);
      ++rounds.nets;
      folds = cure.folds_of(next);
      // Vertices that this net cures for the first time have chosen how they lean.
      decisions.leans = next.decisions.leans;
      if (!with_ellipses) seen.emplace_back(folds, decisions.leans);
      if (folds.area >= least) continue;
      least = folds.area;
      net = std::move(next);
    }
  }
  net.rounds = rounds;
  return net;
}

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
FairNet make_cured_net(const Fit& result, const SharpFeatures& features, const PolygonMesh& mesh,
                       const Subdivision& subdivision, std::span<const glm::dvec3> given,
                       Backend& backend, const FitOptions& options) {
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
         if (!look) look.emplace(mesh, *result.prepared->topology, features, options.weights);
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
  FairNet net =
      make_cured_net(result, *result.features, mesh, subdivision, given, backend, options);
  result.interpolation = measured(subdivision, net.state, given, options.tolerance);
  net.least_polygon = least_polygon(*result.prepared->topology, *result.features, given, net.state);
  FairFit& fair = result.fair.emplace(
      FairFit{net, {std::move(net.state), result.placement}, std::move(net.decisions), {}});
  if (fair.flagged_edges + fair.flagged_faces > 0)
    options.callbacks.warn(folds_left_warning(fair.flagged_edges, fair.flagged_faces));
  const auto concave = std::ssize(concave_faces(mesh));
  if (concave > 0)
    options.callbacks.warn(
        concave_faces_warning(concave, std::ssize(with_convex_faces(mesh).concave_faces)));
}

void solve_semi_sharp(Fit& result, const PolygonMesh& mesh, const Subdivision& smooth,
                      const SharpFeatures& features, std::span<const glm::dvec3> given,
                      Backend& backend, const FitOptions& options) {
  const PolygonMesh sharp_mesh = with_semi_sharp_as_sharp(mesh);
  const Subdivision sharp(smooth.topology(), features, Weights::DooSabin);
  FitOptions making = options;
  making.fair_decisions = options.sharp_fair_decisions;
  FairNet net = make_cured_net(result, features, sharp_mesh, sharp, given, backend, making);
  std::vector<glm::dvec3>& state = result.fair->level_one.state;
  blend_semi_sharp(smooth, sharp, semi_sharp_tags(mesh, smooth.topology()), given, net.state,
                   state);
  result.fair->sharp_decisions = std::move(net.decisions);
  result.fair->least_polygon = least_polygon(smooth.topology(), smooth.features(), given, state);
  result.interpolation = measured(smooth, state, given, options.tolerance);
}

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
  const SurfaceMeter meter(mesh, fitted, {.weights = options.weights, .sharp = options.sharp});
  double area = 0;
  for (int level = 1; level <= 3; ++level) {
    const Callbacks share = share_of(callbacks, (level - 1) / 3.0, level / 3.0);
    area = std::max(area, meter.at(level, share).folded_area_elsewhere);
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
