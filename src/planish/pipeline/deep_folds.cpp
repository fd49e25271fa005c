#include "planish/pipeline/deep_folds.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/folded_edges.h"
#include "planish/patches/patch_surface.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish {

namespace {

constexpr std::size_t kDeepGrain = 512, kCornersAtOnce = 128;
constexpr int kDeepLevel = 3;
constexpr std::int64_t kCells = 16;  // quads of that level over a corner of a face
// Cosine of a vertex's normal with all its faces from which the fair construction's own places
// speak for all others, as in fair/fold_cure.cpp.
constexpr double kEvenCosine = 0.9;

std::vector<glm::dvec3> unit_normals(const PolygonMesh& mesh) {
  std::vector<glm::dvec3> normals(static_cast<std::size_t>(mesh.face_count()));
  parallel_for(normals.size(), kDeepGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const glm::dvec3 area = area_vector(mesh.positions, mesh.face(static_cast<std::int32_t>(f)));
      const double length = glm::length(area);
      normals[f] = length > 0 ? area / length : glm::dvec3(0.0);
    }
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
  parallel_for(uneven.size(), kDeepGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const auto vertex = static_cast<std::int32_t>(v);
      const auto is_at_curve = [&](std::int32_t c) {
        return std::ranges::any_of(topology.face(topology.face_of(c)),
                                   [&](std::int32_t w) { return on_curve[w] != 0; });
      };
      uneven[v] = on_curve[v] != 0 ||
                  std::ranges::any_of(topology.corners_at(vertex), is_at_curve) ||
                  !is_even(topology, normals, vertex);
    }
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

std::shared_ptr<const PreparedMesh> prepared_of_used(
    const PolygonMesh& mesh, const std::shared_ptr<const MeshTopology>& topology) {
  auto prepared = std::make_shared<PreparedMesh>();
  prepared->given_vertex_count = mesh.vertex_count();
  prepared->vertices.resize(mesh.positions.size());
  std::iota(prepared->vertices.begin(), prepared->vertices.end(), 0);
  prepared->topology = topology;
  return prepared;
}

}  // namespace

DeepFolds deep_folds(const PolygonMesh& mesh,
                     const std::shared_ptr<const MeshTopology>& topology_of,
                     const LevelOne& level_one, const FitOptions& options) {
  const MeshTopology& topology = *topology_of;
  DeepFolds result;
  if (topology.corner_count() > std::numeric_limits<std::int32_t>::max() / (4 * kCells))
    return result;  // that level's corners cannot be numbered
  const std::vector<glm::dvec3> normals = unit_normals(mesh);
  const std::vector<std::uint8_t> uneven = uneven_vertices(mesh, topology, normals, options.sharp);
  if (std::ranges::find(uneven, 1) == uneven.end()) return result;

  // Holes shape the surface like all other faces.
  std::optional<PolygonMesh> without_holes;
  if (!mesh.hole_faces.empty()) without_holes.emplace(mesh).hole_faces.clear();
  const PolygonMesh& whole = without_holes ? *without_holes : mesh;
  EvaluateOptions evaluation;
  evaluation.weights = options.weights;
  evaluation.sharp = options.sharp;
  evaluation.rest_positions = whole.positions;
  evaluation.prepared = prepared_of_used(whole, topology_of);
  const DooSabinSurface surface(whole, level_one, evaluation);
  const PatchSurface patches(surface.patches(), {.level = kDeepLevel, .weights = options.weights});
  const FoldedEdges folds = folded_edges(whole, topology);
  result.at_vertex.assign(mesh.positions.size(), 0);
  std::vector<double> areas(mesh.positions.size(), 0);
  std::vector<double> corner_areas(static_cast<std::size_t>(topology.corner_count()), 0);
  const auto look_at = [&](std::span<const std::uint8_t> wanted) {
    parallel_for(corner_areas.size(), kDeepGrain, [&](std::size_t begin, std::size_t end) {
      CornerMeter meter(surface, patches, normals, corner_areas);
      std::vector<std::int32_t> corners;
      for (std::size_t c = begin; c < end; ++c) {
        const auto corner = static_cast<std::int32_t>(c);
        if (wanted[topology.vertex_of(corner)] && !folds.is_beside[topology.face_of(corner)])
          corners.push_back(corner);
        if (corners.size() < kCornersAtOnce && c + 1 < end) continue;
        meter.measure(corners);
        corners.clear();
      }
    });
    for (std::size_t v = 0; v < areas.size(); ++v) {
      if (!wanted[v]) continue;
      areas[v] = 0;
      for (const std::int32_t c : topology.corners_at(static_cast<std::int32_t>(v)))
        areas[v] += corner_areas[c];
      result.at_vertex[v] = areas[v] > 0;
    }
  };
  look_at(uneven);
  if (std::ranges::find(result.at_vertex, 1) == result.at_vertex.end()) return result;
  look_at(neighbours_of(topology, result.at_vertex, uneven));
  double all = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    all += glm::length(area_vector(mesh.positions, mesh.face(f)));
  }
  for (const double area : areas) result.area += area;
  if (all > 0) result.area /= all;
  return result;
}

}  // namespace planish
