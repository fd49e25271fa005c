#include "planish/vulkan/host/system.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <optional>
#include <string>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/raw_vector.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/fair/fair_net.h"
#include "planish/mesh/check.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/doo_sabin_step.h"
#include "planish/solve/backend.h"
#include "planish/solve/iteration.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/fair/gpu_fair.h"
#include "planish/vulkan/host/file_rows.h"
#include "planish/vulkan/solve/gpu_given.h"

namespace planish::vulkan {

SurfaceRecords::SurfaceRecords(const PolygonMesh& mesh, const SystemOptions& options)
    : topology(std::make_shared<const MeshTopology>(mesh)),
      features(find_sharp_features(mesh, *topology, mesh.positions, options.sharp)),
      patch_mesh(*topology, features, ring_columns(*topology, options.weights)),
      weights(options.weights),
      uvs(options.textured ? std::optional<CornerUvs>(mesh) : std::nullopt),
      uv_values(options.textured ? mesh.uvs : std::vector<glm::dvec2>()),
      file_faces(mesh),
      patches(patch_mesh, patch_options(options.level)) {}

const PatchSurface& SurfaceRecords::at_level(int level) const {
  if (patches.numbering().level() == level) return patches;
  for (const LevelRecords& of_set : levels.levels)
    if (of_set.patches.numbering().level() == level) return of_set.patches;
  throw Error(ErrorCode::InvalidArgument,
              formatted("level {} is neither the System's level {} nor one of its levels; give "
                        "SystemOptions it",
                        level, patches.numbering().level()));
}

void SurfaceRecords::take_uv_field(std::span<const glm::dvec3> rest) {
  if (!uvs) return;
  uv_field.emplace(patch_mesh, rest, corner_uvs(), std::span<const glm::dvec2>(uv_values));
  frames = row_frames(patches, weights, *uv_field);
}

void SurfaceRecords::take_sharp_rows(const Subdivision& subdivision) {
  const std::int32_t first = subdivision.first_sharp();
  sharp_rows.emplace(first_step_table(subdivision, {first, subdivision.state_size() - first}));
}

namespace {

// Based on: the paper, section 3.2, for the system B P = V0.

constexpr int kMostLevels = 6;

// Steps of one batch while the rest pose's are counted, and where counting ends: a spectrum that
// slow is none of ours.
constexpr std::int32_t kCountedSteps = 64;
constexpr std::uint32_t kMostCountedSteps = 4096;

void check_options(const SystemOptions& options) {
  if (options.level < 0 || options.level > kMostLevels)
    throw Error(ErrorCode::InvalidArgument,
                formatted("level {} is outside 0 to {}", options.level, kMostLevels));
  int last = 0;
  for (const int level : options.levels) {
    if (level <= last || level > int{shared::kMostLevels})
      throw Error(ErrorCode::InvalidArgument,
                  formatted("levels to choose from ascend from 1 to {}, but {} stands {}",
                            shared::kMostLevels, level,
                            last > 0 ? formatted("behind {}", last) : std::string("first")));
    last = level;
  }
  if (!(options.tolerance > 0))
    throw Error(ErrorCode::InvalidArgument,
                "tolerance " + std::to_string(options.tolerance) + " is not above 0");
}

void check_texture(const PolygonMesh& mesh, const SystemOptions& options) {
  if (options.textured && mesh.face_uvs.empty())
    throw Error(ErrorCode::InvalidArgument,
                "the mesh has no texture coordinates (face_uvs are empty), but SystemOptions say "
                "textured; give it some, or leave textured out");
}

// How a pose is solved in double from a cold start.
struct RestSolve {
  std::uint32_t iterations = 0;  // until it is within the tolerance
  std::vector<glm::dvec3> displacement;
};
// As fit() does: files of the rest pose have this surface.
RestSolve solve_rest(const StencilView<double>& masks, std::span<const glm::dvec3> initial,
                     double bound, double tolerance) {
  const auto backend = make_cpu_backend();
  const auto solve = backend->make_solve(masks);
  solve->begin(initial);
  ChebyshevSequence sequence(bound);
  std::vector<StepCoefficients> steps(kCountedSteps);
  RestSolve rest;
  bool is_within = false;
  for (std::uint32_t count = 0; count < kMostCountedSteps; count += kCountedSteps) {
    for (StepCoefficients& step : steps) step = sequence.next();
    const StepLog log = solve->run(steps, kStopMargin * tolerance);
    for (const ErrorNorms& error : log.errors) {
      is_within = is_within || error.max <= tolerance;
      if (!is_within) ++rest.iterations;
    }
    if (log.steps_taken < kCountedSteps) break;
  }
  rest.displacement = solve->displacement();
  return rest;
}

// The surface's points in the rest pose, in unit coordinates.
struct RestPoints {
  std::vector<glm::dvec3> hull;  // of all of it: the cage, or a fair net's points of level 1
  RawVector<glm::dvec3> state;   // those of level 1, with their sums
};

}  // namespace

struct System::Parts {
  Parts(const PolygonMesh& rest, const SystemOptions& options);

  void copy_rows();
  void build_faces(const PolygonMesh& mesh, const RestPoints& rest, const Placement& placement,
                   std::span<const int> levels);
  void build_method(const PolygonMesh& mesh, const Subdivision& subdivision,
                    const SystemOptions& options);
  void bend_least(std::span<glm::dvec3> unit, const SystemOptions& options);
  /// Returns the control points.
  std::vector<glm::dvec3> measure_rest(std::span<const glm::dvec3> unit, double relative_tolerance);
  RestPoints rest_points(const PolygonMesh& mesh, std::span<const glm::dvec3> unit,
                         const SystemOptions& options);

  int level;
  std::int32_t given_count;
  std::vector<std::int32_t> used_vertices, copied_vertices;
  std::vector<std::uint32_t> triangles, quads;
  std::optional<SurfaceRecords> surface;
  StencilTable masks;  // none of the fair method
  std::optional<FairRecords> fair;
  std::optional<BendingRecords> bending;
  double diagonal = 1, tolerance = 0, within = 0, spectral_bound = 0, rest_error = 0;
  double valence_spread = 1;  // of all valences, their sum over the smallest
  std::uint32_t rest_iterations = 0;
};

System::Parts::Parts(const PolygonMesh& rest, const SystemOptions& options)
    : level(options.level), given_count(rest.vertex_count()) {
  check_options(options);
  const HostScope host(options.callbacks);
  options.callbacks.report("tables", 0);
  require_usable(rest, "mesh");
  check_texture(rest, options);
  UsedMesh used = without_unused_vertices(rest);
  used_vertices = std::move(used.vertices);
  const PolygonMesh& mesh = used.mesh;
  surface.emplace(mesh, options);
  check_stop();
  {
    const Subdivision subdivision(*surface->topology, surface->features, options.weights);
    build_method(mesh, subdivision, options);
    options.callbacks.report("tables", 0.5);
    if (!fair) surface->take_sharp_rows(subdivision);
  }
  check_stop();
  copy_rows();
  const Placement placement = placement_of(mesh);
  diagonal = placement.diagonal;
  tolerance = options.tolerance * diagonal;
  std::vector<glm::dvec3> unit(mesh.positions.size());
  std::ranges::transform(mesh.positions, unit.begin(),
                         [&](const glm::dvec3& p) { return placement.to_unit(p); });
  if (options.within != 0.0) bend_least(unit, options);
  if (fair) fair->placement = placement;
  build_faces(mesh, rest_points(mesh, unit, options), placement, options.levels);
  options.callbacks.report("tables", 1);
}

// Across a cut the further side's rows stand where the first side's do.
void System::Parts::copy_rows() {
  using Part = PatchNumbering::Part;
  const PatchNumbering& numbering = surface->patches.numbering();
  copied_vertices.resize(static_cast<std::size_t>(numbering.row_count()));
  std::iota(copied_vertices.begin(), copied_vertices.end(), 0);
  const std::int32_t count = numbering.samples().trailing_count();
  std::int64_t row = numbering.first_row(Part::Trailing);
  for (std::int64_t i = 0; i < numbering.item_count(Part::Trailing); ++i, row += count) {
    const std::int32_t other = surface->topology->ccw(numbering.item_corner(Part::Trailing, i));
    for (std::int32_t k = 0; other >= 0 && k < count; ++k)
      copied_vertices[row + k] = static_cast<std::int32_t>(numbering.corner_row(other)) + k;
  }
  row = numbering.first_row(Part::Further);
  for (std::int64_t i = 0; i < numbering.item_count(Part::Further); ++i, ++row) {
    const std::int32_t first = numbering.further_first(i);
    copied_vertices[row] =
        numbering.is_further_edge(i) ? numbering.edge_row(first) : numbering.vertex_row(first);
  }
}

// What the solve goes by.
void System::Parts::build_method(const PolygonMesh& mesh, const Subdivision& subdivision,
                                 const SystemOptions& options) {
  if (options.method == InterpolationMethod::Fair) {
    const FairDecisions* decisions = options.fair_decisions;
    if (decisions) require_valid(*decisions, mesh.vertex_count(), mesh.face_count());
    fair.emplace(planish::vulkan::fair_records(make_fair_topology(mesh, subdivision), decisions,
                                               planes_of({.decisions = decisions})));
    return;
  }
  masks = planish::limit_masks(subdivision);
  spectral_bound = planish::spectral_bound(mesh, options.weights);
  const std::vector<double> valence = valences(subdivision.topology());
  if (!valence.empty())
    valence_spread = std::accumulate(valence.begin(), valence.end(), 0.0) /
                     *std::min_element(valence.begin(), valence.end());
}

void System::Parts::build_faces(const PolygonMesh& mesh, const RestPoints& rest,
                                const Placement& placement, std::span<const int> levels) {
  const PosedSurface pose{rest.state, placement};
  surface->take_uv_field(rest.state);
  KeptFaces faces = kept_faces(mesh, surface->patches, pose);
  triangles = std::move(faces.triangles);
  quads = std::move(faces.quads);
  if (!levels.empty()) surface->levels = make_levels(mesh, *surface, rest.hull, pose, levels);
}

// The tables for it; and moves the rest pose's points.
void System::Parts::bend_least(std::span<glm::dvec3> unit, const SystemOptions& options) {
  const BendingTable table = make_bending_table(*surface->topology, surface->features, unit);
  const LeaveWithin allowed = leave_within(options.within, table, unit);
  const double bound = allowed.bound(options.tolerance);
  if (!(bound > 0)) return;
  within = allowed.within * diagonal;
  bending = planish::vulkan::bending_records(table, diagonal, bound * diagonal);
  const LeastBending least = least_bending_moves(table, unit, bound);
  for (std::size_t v = 0; v < unit.size(); ++v) unit[v] += least.moves[v];
}

RestPoints System::Parts::rest_points(const PolygonMesh& mesh, std::span<const glm::dvec3> unit,
                                      const SystemOptions& options) {
  const PatchMesh& patch_mesh = surface->patch_mesh;
  if (!fair) {
    std::vector<glm::dvec3> cage = measure_rest(unit, options.tolerance);
    RawVector<glm::dvec3> state = first_step(patch_mesh, options.weights, cage);
    return {std::move(cage), std::move(state)};
  }
  const Subdivision subdivision(*surface->topology, surface->features, Weights::DooSabin);
  FairOptions fair_options;
  fair_options.decisions = options.fair_decisions;
  std::vector<glm::dvec3> net = fair_net(mesh, subdivision, unit, fair_options).state;
  RawVector<glm::dvec3> state = patch_mesh.with_sums(net);
  return {std::move(net), std::move(state)};
}

std::vector<glm::dvec3> System::Parts::measure_rest(std::span<const glm::dvec3> unit,
                                                    double relative_tolerance) {
  const RawVector<glm::dvec3> initial = initial_residual(masks.view(), unit);
  double largest = 0;
  for (const glm::dvec3& residual : initial) largest = std::max(largest, glm::length(residual));
  rest_error = largest * diagonal;
  std::vector<glm::dvec3> cage(unit.begin(), unit.end());
  if (largest <= relative_tolerance) return cage;
  const RestSolve solved = solve_rest(masks.view(), initial, spectral_bound, relative_tolerance);
  rest_iterations = solved.iterations;
  for (std::size_t v = 0; v < cage.size(); ++v) cage[v] += solved.displacement[v];
  return cage;
}

System::System(const PolygonMesh& rest, const SystemOptions& options)
    : parts_(std::make_unique<const Parts>(rest, options)) {}
System::~System() = default;
System::System(System&&) noexcept = default;
System& System::operator=(System&&) noexcept = default;

int System::level() const { return parts_->level; }
std::int32_t System::given_count() const { return parts_->given_count; }
std::span<const std::int32_t> System::used_vertices() const { return parts_->used_vertices; }
std::int32_t System::vertex_count() const {
  return static_cast<std::int32_t>(parts_->copied_vertices.size());
}
std::span<const std::int32_t> System::copied_vertices() const { return parts_->copied_vertices; }
std::vector<SurfacePlace> System::places() const { return places(level()); }
std::vector<SurfacePlace> System::places(int level) const {
  return row_places(parts_->surface->at_level(level));
}
std::vector<glm::vec2> System::uvs() const { return uvs(level()); }
std::vector<glm::vec2> System::uvs(int level) const {
  const SurfaceRecords& surface = *parts_->surface;
  const PatchSurface& patches = surface.at_level(level);
  if (!surface.uvs) return {};
  return row_uvs(patches, *surface.uv_field);
}
std::vector<std::int32_t> System::file_vertices() const { return file_vertices(level()); }
std::vector<std::int32_t> System::file_vertices(int level) const {
  const SurfaceRecords& surface = *parts_->surface;
  return planish::vulkan::file_vertices(surface.at_level(level), surface.file_faces);
}
std::span<const std::uint32_t> System::triangles() const { return parts_->triangles; }
std::span<const std::uint32_t> System::quads() const { return parts_->quads; }
std::vector<double> System::chord_errors() const {
  const LevelSet& set = parts_->surface->levels;
  std::vector<double> errors;
  for (const LevelRecords& level : set.levels)
    errors.push_back(level.chord * set.radius * parts_->diagonal);
  return errors;
}
StencilView<double> System::limit_masks() const { return parts_->masks.view(); }
const SurfaceRecords& System::surface_records() const { return *parts_->surface; }
const FairRecords* System::fair_records() const { return parts_->fair ? &*parts_->fair : nullptr; }
const BendingRecords* System::bending_records() const {
  return parts_->bending ? &*parts_->bending : nullptr;
}
double System::within() const { return parts_->within; }
double System::diagonal() const { return parts_->diagonal; }
double System::tolerance() const { return parts_->tolerance; }
double System::spectral_bound() const { return parts_->spectral_bound; }
double System::rest_error() const { return parts_->rest_error; }
std::uint32_t System::rest_iterations() const { return parts_->rest_iterations; }

std::uint32_t System::sufficient_iterations(double initial_error) const {
  if (parts_->fair || !(initial_error > parts_->tolerance)) return 0;
  // With M the valences: max |r_k| sqrt(min M) <= |r_k|_M <= 2 sigma^k |r_0|_M and
  // |r_0|_M <= sqrt(sum M) max |r_0|.
  const double factor = parts_->tolerance / initial_error / std::sqrt(parts_->valence_spread);
  return static_cast<std::uint32_t>(
      std::min(chebyshev_step_count(parts_->spectral_bound, factor), double(kMostCountedSteps)));
}

}  // namespace planish::vulkan
