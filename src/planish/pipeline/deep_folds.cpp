#include "planish/pipeline/deep_folds.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/core/unit_vector.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/folded_edges.h"
#include "planish/patches/patch_surface.h"
#include "planish/surface/doo_sabin_surface.h"

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
  parallel_each(normals.size(), kDeepGrain, [&](std::size_t f) {
    normals[f] = unit_or_zero(area_vector(mesh.positions, mesh.face(static_cast<std::int32_t>(f))));
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

// Those on boundaries and sharp edges.
std::vector<std::uint8_t> curve_vertices(const PolygonMesh& mesh, const MeshTopology& topology,
                                         const SharpFeatureOptions& sharp) {
  std::vector<std::uint8_t> on_curve(mesh.positions.size(), 0);
  for (std::size_t v = 0; v < on_curve.size(); ++v) {
    on_curve[v] = topology.is_boundary_vertex(static_cast<std::int32_t>(v));
  }
  if (!sharp.use_tags) return on_curve;
  for (const CreaseEdge& crease : mesh.creases) {
    if (crease.sharpness >= kInfiniteSharpness) on_curve[crease.v0] = on_curve[crease.v1] = 1;
  }
  for (const CornerVertex& corner : mesh.corners) on_curve[corner.vertex] = 1;
  return on_curve;
}

// Also those of faces at curves: what folds at the curve's end of a needle is as wide at the other.
std::vector<std::uint8_t> uneven_vertices(const PolygonMesh& mesh, const MeshTopology& topology,
                                          std::span<const glm::dvec3> normals,
                                          const SharpFeatureOptions& sharp) {
  const std::vector<std::uint8_t> on_curve = curve_vertices(mesh, topology, sharp);
  std::vector<std::uint8_t> uneven(mesh.positions.size(), 0);
  parallel_each(uneven.size(), kDeepGrain, [&](std::size_t v) {
    const auto vertex = static_cast<std::int32_t>(v);
    const auto is_at_curve = [&](std::int32_t c) {
      return std::ranges::any_of(topology.face(topology.face_of(c)),
                                 [&](std::int32_t w) { return on_curve[w] != 0; });
    };
    uneven[v] = on_curve[v] != 0 || std::ranges::any_of(topology.corners_at(vertex), is_at_curve) ||
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
  CornerMeter(const DooSabinSurface& base, const PatchSurface& surface,
              std::span<const glm::dvec3> normals, std::span<double> folded_areas)
      : base_(base),
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
    (void)surface_.grids(base_.state(), base_.placement(), corners, target);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      folded_areas_[corners[i]] = folded_area(corners[i], i * count);
    }
  }

 private:
  // `first`: where the corner's samples begin.
  [[nodiscard]] double folded_area(std::int32_t corner, std::size_t first) const {
    const PatchSamples& samples = surface_.numbering().samples();
    const std::int32_t side = samples.side() + 1;
    const glm::dvec3& normal = normals_[base_.topology().face_of(corner)];
    double folded = 0;
    for (const std::array<std::int32_t, 4>& cell : cells_.of(base_.topology(), corner)) {
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

  const DooSabinSurface& base_;
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

// The finished surface. A part of a mesh may have no faces: there is nothing to look at then.
class DeepLook {
 public:
  DeepLook(const PolygonMesh& mesh, const std::shared_ptr<const MeshTopology>& topology,
           const LevelOne& level_one, const FitOptions& options, FairHalo* halo)
      : topology_(*topology),
        halo_(halo),
        whole_(mesh.hole_faces.empty() ? mesh : without_holes_.emplace(mesh)),
        areas_(mesh.positions.size(), 0),
        corner_areas_(static_cast<std::size_t>(topology->corner_count()), 0) {
    if (mesh.face_count() == 0) return;
    // Holes shape the surface like all other faces.
    if (without_holes_) without_holes_->hole_faces.clear();
    EvaluateOptions evaluation;
    evaluation.weights = options.weights;
    evaluation.sharp = options.sharp;
    evaluation.rest_positions = whole_.positions;
    evaluation.prepared = prepared_whole(whole_, topology);
    surface_.emplace(whole_, level_one, evaluation);
    patches_.emplace(surface_->patches(),
                     PatchSurfaceOptions{.level = kDeepLevel, .weights = options.weights});
    folds_ = folded_edges(whole_, topology_);
  }

  // At the wanted vertices, those of other parts left out.
  void at(std::span<const std::uint8_t> wanted, std::span<const glm::dvec3> normals,
          std::span<std::uint8_t> at_vertex, LoopProgress& progress) {
    if (!patches_) return;
    const auto is_looked_at = [&](std::int32_t vertex) {
      return wanted[vertex] != 0 && owns_vertex(halo_, vertex);
    };
    parallel_for(corner_areas_.size(), kDeepGrain, [&](std::size_t begin, std::size_t end) {
      CornerMeter meter(*surface_, *patches_, normals, corner_areas_);
      std::vector<std::int32_t> corners;
      for (std::size_t c = begin; c < end; ++c) {
        const auto corner = static_cast<std::int32_t>(c);
        if (is_looked_at(topology_.vertex_of(corner)) &&
            !folds_.is_beside[topology_.face_of(corner)])
          corners.push_back(corner);
        if (corners.size() < kCornersAtOnce && c + 1 < end) continue;
        meter.measure(corners);
        corners.clear();
      }
      progress.add(static_cast<std::int64_t>(end - begin));
    });
    for (std::size_t v = 0; v < areas_.size(); ++v) {
      const auto vertex = static_cast<std::int32_t>(v);
      if (!is_looked_at(vertex)) continue;
      areas_[v] = 0;
      for (const std::int32_t c : topology_.corners_at(vertex)) areas_[v] += corner_areas_[c];
      at_vertex[v] = areas_[v] > 0;
    }
  }

  // As a share of the mesh's.
  [[nodiscard]] double area() const {
    const double folded =
        halo_ ? halo_->sum_of_vertices(areas_) : std::accumulate(areas_.begin(), areas_.end(), 0.0);
    const double all = area_of(whole_, halo_);
    return all > 0 ? folded / all : folded;
  }

 private:
  const MeshTopology& topology_;
  FairHalo* halo_;
  std::optional<PolygonMesh> without_holes_;
  const PolygonMesh& whole_;
  std::optional<DooSabinSurface> surface_;
  std::optional<PatchSurface> patches_;
  FoldedEdges folds_;
  std::vector<double> areas_, corner_areas_;  // folded, per vertex and per corner
};

}  // namespace

DeepFolds deep_folds(const PolygonMesh& mesh, const std::shared_ptr<const MeshTopology>& topology,
                     const LevelOne& level_one, const FitOptions& options, FairHalo* halo) {
  DeepFolds result;
  if (!can_look(*topology, halo)) return result;
  const std::vector<glm::dvec3> normals = unit_normals(mesh);
  std::vector<std::uint8_t> uneven = uneven_vertices(mesh, *topology, normals, options.sharp);
  if (halo) halo->exchange_vertices(uneven);
  if (!is_anywhere(uneven, halo)) return result;
  const std::vector<std::uint8_t> around = neighbours_of(*topology, uneven, uneven);
  for (std::size_t v = 0; v < uneven.size(); ++v) uneven[v] |= around[v];

  DeepLook look(mesh, topology, level_one, options, halo);
  result.at_vertex.assign(mesh.positions.size(), 0);
  // Mostly there is nothing to look at once more.
  LoopProgress progress(options.callbacks, "folds", 0.2, 1, topology->corner_count());
  look.at(uneven, normals, result.at_vertex, progress);
  if (halo) halo->exchange_vertices(result.at_vertex);
  if (!is_anywhere(result.at_vertex, halo)) return result;
  look.at(neighbours_of(*topology, result.at_vertex, uneven), normals, result.at_vertex, progress);
  if (halo) halo->exchange_vertices(result.at_vertex);
  result.area = look.area();
  return result;
}

FairNet deeply_cured_net(const DeepCure& cure) {
  FairNet net = cure.make_net(nullptr);
  const DeepFolds first = cure.folds_of(net);
  const FairDecisions first_decisions = first.area > kNoDeepFolds ? net.decisions : FairDecisions{};
  double least = first.area;
  for (const bool with_ellipses : {false, true}) {
    FairDecisions decisions = first_decisions;
    DeepFolds folds = first;
    for (int round = 0; round < kDeepRounds && least > kNoDeepFolds; ++round) {
      std::vector<std::uint8_t> has_changed(folds.at_vertex.size(), 0);
      if (with_ellipses) has_changed = cure.choose_ellipses(folds.at_vertex, decisions);
      for (std::size_t v = 0; v < folds.at_vertex.size(); ++v)
        decisions.cures[v] += folds.at_vertex[v] != 0 && has_changed[v] == 0 ? 1 : 0;
      FairNet next = cure.make_net(&decisions);
      folds = cure.folds_of(next);
      // Vertices that this net cures for the first time have chosen how they lean.
      decisions.leans = next.decisions.leans;
      if (folds.area >= least) continue;
      least = folds.area;
      net = std::move(next);
    }
  }
  return net;
}

}  // namespace planish
