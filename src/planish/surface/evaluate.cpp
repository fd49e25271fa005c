// The chain of small stencil tables: control points -> state of level 1 -> ... -> state of the
// last level -> limit points and tangents. Tables are made and used in slices of rows, so that the
// tables of the last level never stand in memory whole.
#include "planish/surface/evaluate.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <string>

#include "planish/core/assert.h"
#include "planish/doosabin/face_rows.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/surface_stencils.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/placement.h"
#include "planish/surface/attributes.h"
#include "planish/surface/subdivided_mesh.h"

namespace planish {

namespace {

// Rows of a slice: large enough for all threads or a device, small enough that the allocator
// serves the next slice from the last one's memory (measured: asking the system for fresh pages
// costs more than filling them).
constexpr std::int64_t kSliceRows = 1 << 17;

template <class Body>
void for_slices(std::int64_t count, const Callbacks& callbacks, const Body& body) {
  for (std::int64_t first = 0; first < count; first += kSliceRows) {
    callbacks.check_cancelled();
    body(RowRange{first, std::min(kSliceRows, count - first)});
  }
}

// Control points of a level, or of the cage itself at level 0.
struct Source {
  std::unique_ptr<DevicePoints> points;
  int level;
};

// The state of the level whose rings give the output's limit points.
std::unique_ptr<DevicePoints> refine_points(Source source, const SubdividedMesh& cage, int level,
                                            Backend& backend, const Callbacks& callbacks) {
  for (int l = source.level + 1; l <= level; ++l) {
    const std::int64_t size = cage.subdivision.state_layout(l).size;
    auto target = backend.allocate(static_cast<std::int32_t>(size));
    for_slices(size, callbacks, [&](RowRange rows) {
      const StencilTable<double> table =
          l == 1 ? first_step_table(cage.used.mesh, cage.subdivision, rows)
                 : refinement_table(cage.subdivision, l - 1, rows);
      backend.apply(table.view(), *source.points, *target, static_cast<std::int32_t>(rows.first));
    });
    source.points = std::move(target);
    callbacks.report("evaluate", 0.4 * l / level);
  }
  return std::move(source.points);
}

// Area vectors of the faces around the given vertices, summed.
std::vector<glm::dvec3> facet_normals(const SurfaceMesh& surface,
                                      const std::vector<std::int32_t>& place_of_vertex,
                                      std::size_t place_count) {
  std::vector<glm::dvec3> normals(place_count, glm::dvec3(0.0));
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto vertices = surface.face(f);
    const bool touched = std::any_of(vertices.begin(), vertices.end(),
                                     [&](std::int32_t v) { return place_of_vertex[v] >= 0; });
    if (!touched) continue;
    const glm::dvec3 area = area_vector(surface.positions, vertices);
    for (const std::int32_t v : vertices) {
      if (place_of_vertex[v] >= 0) normals[place_of_vertex[v]] += area;
    }
  }
  return normals;
}

// Zero normals mark parallel tangents: take the facets' normal there, else +Z.
void replace_degenerate_normals(SurfaceMesh& surface, const Callbacks& callbacks) {
  std::vector<std::int32_t> degenerate;
  for (std::size_t v = 0; v < surface.normals.size(); ++v) {
    if (surface.normals[v] == glm::vec3(0.0f)) degenerate.push_back(static_cast<std::int32_t>(v));
  }
  if (degenerate.empty()) return;
  std::vector<std::int32_t> place_of_vertex(surface.normals.size(), -1);
  for (std::size_t i = 0; i < degenerate.size(); ++i) {
    place_of_vertex[degenerate[i]] = static_cast<std::int32_t>(i);
  }
  const auto normals = facet_normals(surface, place_of_vertex, degenerate.size());
  for (std::size_t i = 0; i < degenerate.size(); ++i) {
    const double length = glm::length(normals[i]);
    surface.normals[degenerate[i]] =
        length > 0 ? glm::vec3(normals[i] / length) : glm::vec3(0.0f, 0.0f, 1.0f);
  }
  callbacks.warn({"degenerate-normals",
                  std::to_string(degenerate.size()) +
                      " vertices have parallel tangents; their normals are those of the facets",
                  static_cast<std::int64_t>(degenerate.size()), degenerate.front()});
}

void require_level(const EvaluateOptions& options) {
  if (options.level >= 0 && options.level <= kMaxLevel) return;
  throw Error(ErrorCode::InvalidArgument, "level " + std::to_string(options.level) +
                                              " is outside 0 to " + std::to_string(kMaxLevel));
}

SurfaceMesh surface_from(Source source, const Placement& placement, const SubdividedMesh& cage,
                         Backend& backend, const EvaluateOptions& options) {
  // The input's own vertices have their limit points on every level: level 0 reads them off the
  // state of level 1.
  const int state_level = std::max(options.level, 1);
  const auto state =
      refine_points(std::move(source), cage, state_level, backend, options.callbacks);
  const Subdivision& subdivision = cage.subdivision;
  SurfaceMesh surface;
  surface.level = options.level;
  surface.base_vertices = cage.used.vertices;
  const LimitRows rows(subdivision, state_level, cage.split.counts(options.level).vertices);
  surface.positions.resize(static_cast<std::size_t>(rows.count()));
  surface.normals.resize(surface.positions.size());
  for_slices(rows.count(), options.callbacks, [&](RowRange range) {
    const LimitStencilTable<double> table = limit_table(subdivision, state_level, rows, range);
    const auto first = static_cast<std::size_t>(range.first);
    const auto count = static_cast<std::size_t>(range.count);
    backend.apply_limit(table.view(), *state, std::span(surface.positions).subspan(first, count),
                        std::span(surface.normals).subspan(first, count));
    options.callbacks.report(
        "evaluate", 0.4 + 0.6 * static_cast<double>(range.first + range.count) / rows.count());
  });
  for (glm::dvec3& position : surface.positions) position = placement.to_model(position);
  if (surface.level == 0) surface.face_offsets = cage.used.mesh.face_offsets;
  surface.face_vertices = face_rows(cage.used.mesh, cage.split, surface.level, rows);
  carry_attributes(cage.used.mesh, cage.split, rows, surface);
  replace_degenerate_normals(surface, options.callbacks);
  remove_holes(cage.used.mesh, surface);
  return surface;
}

}  // namespace

SurfaceMesh evaluate(const PolygonMesh& cage, Backend& backend, const EvaluateOptions& options) {
  require_level(options);
  PLANISH_ASSERT(options.rest_positions.empty() ||
                 options.rest_positions.size() == cage.positions.size());
  const SubdividedMesh subdivided(cage, options);
  const Placement placement = placement_of(subdivided.used.mesh);
  std::vector<glm::dvec3> unit(subdivided.used.mesh.positions.size());
  std::transform(subdivided.used.mesh.positions.begin(), subdivided.used.mesh.positions.end(),
                 unit.begin(), [&](const glm::dvec3& p) { return placement.to_unit(p); });
  return surface_from({backend.upload(unit), 0}, placement, subdivided, backend, options);
}

SurfaceMesh evaluate(const PolygonMesh& mesh, const LevelOne& level_one, Backend& backend,
                     const EvaluateOptions& options) {
  require_level(options);
  PLANISH_ASSERT(options.rest_positions.empty() ||
                 options.rest_positions.size() == mesh.positions.size());
  const SubdividedMesh subdivided(mesh, options);
  require_state_of(subdivided.subdivision, level_one);
  return surface_from({backend.upload(level_one.state), 1}, level_one.placement, subdivided,
                      backend, options);
}

std::vector<glm::dvec3> limit_positions(const PolygonMesh& cage, Weights weights,
                                        const SharpFeatureOptions& sharp) {
  EvaluateOptions options{.level = 0, .weights = weights};
  options.sharp = sharp;
  const SubdividedMesh subdivided(cage, options);
  const UsedMesh& used = subdivided.used;
  const StencilTable<double> masks = limit_masks(used.mesh, subdivided.subdivision);
  const StencilView<double> view = masks.view();
  std::vector<glm::dvec3> limits = cage.positions;
  for (std::int32_t i = 0; i < view.row_count(); ++i) {
    // About the vertex itself: far from the origin the sum would lose digits.
    const glm::dvec3 centre = used.mesh.positions[i];
    glm::dvec3 sum(0.0);
    for (std::int32_t k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
      sum += view.weights[k] * (used.mesh.positions[view.indices[k]] - centre);
    }
    limits[used.vertices[i]] = centre + sum;
  }
  return limits;
}

}  // namespace planish
