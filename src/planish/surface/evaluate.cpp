#include "planish/surface/evaluate.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/primal/primal_stencils.h"
#include "planish/solve/iteration.h"
#include "planish/solve/stencil_builder.h"
#include "planish/solve/stencil_table.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/level_faces.h"
#include "planish/surface/level_one_mesh.h"
#include "planish/surface/memory_need.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

void require_state_size(std::int64_t size, const LevelOne& level_one) {
  if (static_cast<std::int64_t>(level_one.state.size()) == size) return;
  throw Error(
      ErrorCode::InvalidArgument,
      formatted("level 1 of this mesh with these creases has {} control points, and {} are given",
                size, level_one.state.size()));
}

std::vector<glm::dvec3> limit_points(const Subdivision& subdivision,
                                     std::span<const glm::dvec3> state) {
  const auto count = static_cast<std::size_t>(subdivision.topology().vertex_count());
  std::vector<glm::dvec3> limits(count);
  parallel_for(count, 1024, [&](std::size_t begin, std::size_t end) {
    VertexRing ring;
    for (std::size_t v = begin; v < end; ++v) {
      gather_ring(subdivision, static_cast<std::int32_t>(v), ring);
      if (ring.kind == VertexKind::Corner) {
        limits[v] = state[ring.corner_point];
      } else if (ring.kind == VertexKind::Crease) {
        const VertexRing::Sector& sector = ring.sectors.front();
        limits[v] = 0.5 * (state[sector.curve0] + state[sector.curve1]);
      } else {
        // About one of the points: far from the origin the sum would lose digits.
        const glm::dvec3 origin = state[ring.faces.front()];
        glm::dvec3 sum(0.0);
        for (const std::int32_t face : ring.faces) sum += state[face] - origin;
        limits[v] = origin + sum / static_cast<double>(ring.faces.size());
      }
    }
  });
  return limits;
}

std::vector<glm::dvec3> limit_positions(const PolygonMesh& mesh, const LevelOne& level_one,
                                        const SharpFeatureOptions& sharp) {
  const SubdividedMesh base(mesh, sharp);
  require_state_size(base.subdivision.state_size(), level_one);
  const auto points = limit_points(base.subdivision, level_one.state);
  std::vector<glm::dvec3> limits = mesh.positions;
  for (std::size_t v = 0; v < points.size(); ++v) {
    limits[base.used.vertices[v]] = level_one.placement.to_model(points[v]);
  }
  return limits;
}

struct VertexStar;

namespace {

// A primal scheme on one mesh down to one level, as a chain of stencil tables: control points
// -> state of level 1 -> ... -> state of state_level() -> limit points and tangents. Tables are
// made in slices of rows.
class PrimalTables {
 public:
  // Throws Error{UnusableMesh} for Loop on other faces than triangles and Error{OutOfMemory}
  // before memory is taken.
  PrimalTables(const UsedPart& used, PrimalScheme scheme, const EvaluateOptions& options);

  // The level whose state gives the output's limit points: the output's, but at least 1.
  [[nodiscard]] int state_level() const { return std::max(level_, 1); }
  [[nodiscard]] std::int64_t state_size(int level) const {
    return split_.level(level).GetNumVertices();
  }
  // Rows of the state of `level` >= 1 from that of level - 1, the control points for level 1.
  [[nodiscard]] StencilTable step(int level, RowRange rows) const;

  // The output's vertices.
  [[nodiscard]] const SectorRows& rows() const { return rows_; }
  [[nodiscard]] StencilTable limit(RowRange rows) const;
  // The corners of the output's faces, one face after another. From level 1 on all faces have
  // corners_per_face() of them.
  [[nodiscard]] std::vector<std::int32_t> face_vertices() const;
  [[nodiscard]] int corners_per_face() const {
    return split_.scheme() == PrimalScheme::Loop ? 3 : 4;
  }

  // The topology of the output, which is its level `level`.
  [[nodiscard]] const OpenSubdiv::Far::TopologyRefiner& refiner() const { return split_.refiner(); }

 private:
  [[nodiscard]] std::int32_t row_of(std::int32_t face, int corner, std::int32_t vertex,
                                    VertexStar& star) const;

  int level_;
  PrimalSplit split_;
  SectorRows rows_;
};

PrimalTables::PrimalTables(const UsedPart& used, PrimalScheme scheme,
                           const EvaluateOptions& options)
    : level_(options.level),
      split_(used.mesh, {scheme, options.sharp, used.prepared->topology.get()}) {
  const std::vector<LevelCounts> counts = split_.counts_to(state_level());
  require_memory(counts, LastLevel::Full, RefinedAttributes::of(used.mesh),
                 options.memory_limit_bytes);
  split_.refine(state_level());
  rows_ = primal_sector_rows(split_, state_level(), counts[level_].vertices);
}

StencilTable PrimalTables::step(int level, RowRange rows) const {
  return primal_refinement_table(split_, level - 1, rows);
}

StencilTable PrimalTables::limit(RowRange rows) const {
  return primal_limit_table(split_, state_level(), rows_, rows);
}

std::vector<std::int32_t> PrimalTables::face_vertices() const {
  const auto& topology = split_.level(level_);
  const auto face_count = static_cast<std::size_t>(topology.GetNumFaces());
  std::vector<std::size_t> first(face_count + 1, 0);
  for (std::size_t f = 0; f < face_count; ++f) {
    first[f + 1] = first[f] + topology.GetFaceVertices(static_cast<int>(f)).size();
  }
  std::vector<std::int32_t> result(first.back());
  parallel_for(face_count, 4096, [&](std::size_t begin, std::size_t end) {
    VertexStar star;
    for (std::size_t f = begin; f < end; ++f) {
      const auto vertices = topology.GetFaceVertices(static_cast<int>(f));
      for (int k = 0; k < vertices.size(); ++k) {
        result[first[f] + k] = row_of(static_cast<std::int32_t>(f), k, vertices[k], star);
      }
    }
  });
  return result;
}

// The row of a vertex as seen from a face of the output, of which it is corner `corner`.
std::int32_t PrimalTables::row_of(std::int32_t face, int corner, std::int32_t vertex,
                                  VertexStar& star) const {
  if (!rows_.is_split(vertex)) return vertex;
  const std::int32_t state_face =
      level_ == 0 ? split_.level(0).GetFaceChildFaces(face)[corner] : face;
  const int place = split_.level(state_level()).GetVertexFaces(vertex).FindIndex(state_face);
  PLANISH_ASSERT(place >= 0);
  gather_star(split_, state_level(), vertex, star);
  return rows_.row(vertex, sector_of(star, place));
}

// Doo-Sabin surfaces are collected from blocks of patches. Those of the other schemes come from the
// chain of small stencil tables of PrimalTables, made and used in slices of rows, so that the
// tables of the last level never stand in memory whole.

// Rows of a slice: large enough for all threads or a device, small enough that the allocator
// serves the next slice from the last one's memory (measured: asking the system for fresh pages
// costs more than filling them).
constexpr std::int64_t kSliceRows = 1 << 17;

template <class Body>
void for_slices(std::int64_t count, const Body& body) {
  for (std::int64_t first = 0; first < count; first += kSliceRows) {
    check_stop();
    body(RowRange{first, std::min(kSliceRows, count - first)});
  }
}

// The state of the level that gives the output's limit points, from control points.
std::vector<glm::dvec3> refined_points(std::vector<glm::dvec3> points, const PrimalTables& tables,
                                       const Callbacks& callbacks) {
  for (int l = 1; l <= tables.state_level(); ++l) {
    std::vector<glm::dvec3> target(static_cast<std::size_t>(tables.state_size(l)));
    for_slices(std::ssize(target), [&](RowRange rows) {
      apply(tables.step(l, rows).view(), points,
            std::span(target).subspan(static_cast<std::size_t>(rows.first),
                                      static_cast<std::size_t>(rows.count)));
    });
    points = std::move(target);
    callbacks.report("evaluate", 0.4 * l / tables.state_level());
  }
  return points;
}

// The output's faces, whose size is not stored where all are quads.
void connect(const PolygonMesh& mesh, const PrimalTables& tables, SurfaceMesh& surface) {
  const std::vector<std::int32_t> corners = tables.face_vertices();
  surface.face_vertices.assign(corners.begin(), corners.end());
  if (surface.level == 0) {
    surface.face_offsets = mesh.face_offsets;
  } else if (const int size = tables.corners_per_face(); size != 4) {
    const auto corner_count = static_cast<std::int32_t>(surface.face_vertices.size());
    for (std::int32_t c = 0; c <= corner_count; c += size) surface.face_offsets.push_back(c);
  }
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
  warn_of({static_cast<std::int64_t>(degenerate.size()), degenerate.front()}, callbacks);
}

// On the caller's threads, whatever the backend.
SurfaceMesh primal_surface(const PolygonMesh& cage, PrimalScheme scheme,
                           const EvaluateOptions& options) {
  const UsedPart used = usable_part(cage, options.prepared);
  const PrimalTables tables(used, scheme, options);
  const Placement placement = placement_of(used.mesh);
  std::vector<glm::dvec3> unit(used.mesh.positions.size());
  std::transform(used.mesh.positions.begin(), used.mesh.positions.end(), unit.begin(),
                 [&](const glm::dvec3& p) { return placement.to_unit(p); });
  const auto state = refined_points(std::move(unit), tables, options.callbacks);
  SurfaceMesh surface;
  surface.level = options.level;
  surface.base_vertices.assign(used.vertices.begin(), used.vertices.end());
  const SectorRows& rows = tables.rows();
  surface.positions.resize(static_cast<std::size_t>(rows.count()));
  surface.normals.resize(surface.positions.size());
  for_slices(rows.count(), [&](RowRange range) {
    const StencilTable table = tables.limit(range);
    const auto first = static_cast<std::size_t>(range.first);
    const auto count = static_cast<std::size_t>(range.count);
    apply_limit(table.view(), state, std::span(surface.positions).subspan(first, count),
                std::span(surface.normals).subspan(first, count));
    options.callbacks.report(
        "evaluate", 0.4 + 0.6 * static_cast<double>(range.first + range.count) / rows.count());
  });
  for (glm::dvec3& position : surface.positions) position = placement.to_model(position);
  connect(used.mesh, tables, surface);
  carry_attributes(used.mesh, tables.refiner(), rows, surface);
  replace_degenerate_normals(surface, options.callbacks);
  remove_holes(used.mesh, surface);
  return surface;
}

SurfaceMesh doo_sabin_surface(const PolygonMesh& mesh, const LevelOne* level_one, Backend& backend,
                              const EvaluateOptions& options) {
  options.callbacks.report("evaluate", 0);
  const DooSabinSurface base = level_one != nullptr ? DooSabinSurface(mesh, *level_one, options)
                                                    : DooSabinSurface(mesh, options);
  auto* const evaluator = dynamic_cast<PatchEvaluator*>(&backend);
  base.require_whole(options.level, options.memory_limit_bytes, evaluator);
  // What comes before takes about as long as level 1.
  const double made = 1 / (1 + std::ldexp(1.0, 2 * std::max(options.level - 1, 0)));
  return collect(*base.level(options.level, options.memory_limit_bytes, evaluator),
                 share_of(options.callbacks, made, 1));
}

// On the backend's threads, for its callers.
template <class Make>
SurfaceMesh evaluated(Backend& backend, const EvaluateOptions& options, const Make& make) {
  require_level(options.level);
  const HostScope host(options.callbacks);
  SurfaceMesh surface;
  backend.run_on_host([&] { surface = make(); });
  options.callbacks.report("evaluate", 1);
  return surface;
}

SummedTable primal_masks(const UsedPart& used, PrimalScheme scheme, const LimitOptions& options) {
  PrimalSplit split(used.mesh, {scheme, options.sharp, used.prepared->topology.get()});
  split.refine(1);
  return {primal_limit_masks(split), {}};
}

SummedTable doo_sabin_masks(const UsedPart& used, const LimitOptions& options) {
  const MeshTopology& topology = *used.prepared->topology;
  const SharpFeatures features =
      find_sharp_features(used.mesh, topology, used.mesh.positions, options.sharp);
  return summed_limit_masks(Subdivision(topology, features, options.weights));
}

}  // namespace

void require_level(int level) {
  if (level >= 0 && level <= kMaxLevel) return;
  throw Error(ErrorCode::InvalidArgument,
              formatted("level {} is outside 0 to {}", level, kMaxLevel));
}

SurfaceMesh evaluate(const PolygonMesh& cage, Backend& backend, const EvaluateOptions& options) {
  PLANISH_ASSERT(options.rest_positions.empty() ||
                 options.rest_positions.size() == cage.positions.size());
  return evaluated(backend, options, [&] {
    const auto scheme = primal_scheme(options.scheme);
    return scheme ? primal_surface(cage, *scheme, options)
                  : doo_sabin_surface(cage, nullptr, backend, options);
  });
}

SurfaceMesh evaluate(const PolygonMesh& mesh, const LevelOne& level_one, Backend& backend,
                     const EvaluateOptions& options) {
  PLANISH_ASSERT(options.scheme == Scheme::DooSabin);
  PLANISH_ASSERT(options.rest_positions.empty() ||
                 options.rest_positions.size() == mesh.positions.size());
  return evaluated(backend, options,
                   [&] { return doo_sabin_surface(mesh, &level_one, backend, options); });
}

std::vector<glm::dvec3> limit_positions(const PolygonMesh& cage, const LimitOptions& options) {
  const UsedPart used = usable_part(cage);
  const auto scheme = primal_scheme(options.scheme);
  const SummedTable masks =
      scheme ? primal_masks(used, *scheme, options) : doo_sabin_masks(used, options);
  const RawVector<glm::dvec3> residual = initial_residual(masks.view(), used.mesh.positions);
  std::vector<glm::dvec3> limits = cage.positions;
  for (std::size_t i = 0; i < residual.size(); ++i)
    limits[used.vertices[i]] = used.mesh.positions[i] - residual[i];
  return limits;
}

}  // namespace planish
