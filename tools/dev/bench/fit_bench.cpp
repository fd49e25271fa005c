#include <benchmark/benchmark.h>
#include <opensubdiv/osd/bufferDescriptor.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/ompEvaluator.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/geometric.hpp>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "bench/benchmarks.h"
#include "planish/core/parallel.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/fair/bending.h"
#include "planish/fair/fair_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/solve/backend.h"
#include "planish/solve/far_tables.h"
#include "planish/solve/progressive.h"
#include "planish/surface/evaluate.h"

#ifdef PLANISH_HAS_VULKAN
#include "planish/vulkan/vulkan_backend.h"
#endif

namespace planish::bench {
namespace {

// A mesh with what stands between it and the solve.
struct PreparedMesh {
  explicit PreparedMesh(PolygonMesh input, Weights weights = Weights::DooSabin)
      : mesh(std::move(input)),
        topology(mesh),
        features(find_sharp_features(mesh, topology, mesh.positions, {})),
        masks(limit_masks(Subdivision(topology, features, weights))),
        bound(spectral_bound(mesh, weights)),
        valence(valences(topology)) {
    const Placement placement = placement_of(mesh);
    for (const glm::dvec3& position : mesh.positions) given.push_back(placement.to_unit(position));
  }

  [[nodiscard]] std::vector<glm::dvec3> limits_of(const std::vector<glm::dvec3>& points) const {
    const StencilView<double> view = masks.view();
    std::vector<glm::dvec3> limits(points.size(), glm::dvec3(0.0));
    for (std::int32_t i = 0; i < view.row_count(); ++i) {
      for (std::int32_t k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
        limits[i] += view.weights[k] * points[view.indices[k]];
      }
    }
    return limits;
  }

  PolygonMesh mesh;
  MeshTopology topology;
  SharpFeatures features;
  StencilTable masks;
  double bound;
  std::vector<double> valence;
  std::vector<glm::dvec3> given;  // unit coordinates
};

std::vector<Row> bench_masks_of(const std::string& name, PolygonMesh mesh, int repetitions) {
  const PreparedMesh prepared(std::move(mesh));
  // The surface's own tables reach the same limit points by another way: one Doo-Sabin step, then
  // the mean of the points around each vertex.
  EvaluateOptions level_0;
  level_0.level = 0;
  const auto backend = make_cpu_backend();
  require_agreement(name, prepared.limits_of(prepared.mesh.positions),
                    evaluate(prepared.mesh, *backend, level_0).positions);

  const Subdivision subdivision(prepared.topology, prepared.features, Weights::DooSabin);
  Group group;
  group.name = name;
  group.size = std::to_string(prepared.mesh.face_count()) + " faces, " +
               std::to_string(prepared.masks.weights.size()) + " entries";
  group.baseline = "topology";
  group.peers = {{"topology", [&] { const MeshTopology topology(prepared.mesh); }},
                 {"sharp-features",
                  [&] {
                    (void)find_sharp_features(prepared.mesh, prepared.topology,
                                              prepared.mesh.positions, {});
                  }},
                 {"limit-masks", [&] { (void)limit_masks(subdivision); }}};
  return run_group(group, repetitions);
}

}  // namespace

std::vector<Row> bench_masks(const Options& options) {
  std::vector<Row> rows =
      bench_masks_of("masks-torus", torus_grid(options.quad_count), options.repetitions);
  const std::vector<Row> sphere =
      bench_masks_of("masks-sphere", rough_icosphere(options.sphere_level), options.repetitions);
  rows.insert(rows.end(), sphere.begin(), sphere.end());
  return rows;
}

namespace {

namespace Osd = OpenSubdiv::Osd;
using Points = std::vector<glm::dvec3>;

// Never reached, so that no update is left out.
constexpr StepCoefficients kPlainStep{0.0, 1.0};

// From zero displacement the second plain step gives 2 r - B r.
void check_solve(const std::string& name, Solve& solve, const PreparedMesh& prepared,
                 const Points& limits) {
  solve.begin(prepared.given);
  const std::array<StepCoefficients, 2> steps = {kPlainStep, kPlainStep};
  (void)solve.run(steps, kNoStop);
  Points images = solve.displacement();
  for (std::size_t i = 0; i < images.size(); ++i) images[i] = 2.0 * prepared.given[i] - images[i];
  require_agreement(name, images, limits);
}

Peer update_peer(const std::string& name, std::shared_ptr<Solve> solve,
                 const PreparedMesh& prepared, const Points& limits) {
  check_solve(name, *solve, prepared, limits);
  solve->begin(prepared.given);
  return {name, [solve] { (void)solve->run(std::span(&kPlainStep, 1), kNoStop); }};
}

// OpenSubdiv's evaluators apply the table and no more.
struct OsdBuffers {
  explicit OsdBuffers(const PreparedMesh& prepared)
      : table(to_far<float>(prepared.masks.view())), target(3 * prepared.given.size()) {
    for (const glm::dvec3& p : prepared.given) {
      for (int k = 0; k < 3; ++k) source.push_back(static_cast<float>(p[k]));
    }
  }

  template <class Evaluator>
  void apply() {
    const Osd::BufferDescriptor xyz(0, 3, 3);
    Evaluator::EvalStencils(source.data(), xyz, target.data(), xyz, table->GetSizes().data(),
                            table->GetOffsets().data(), table->GetControlIndices().data(),
                            table->GetWeights().data(), 0, table->GetNumStencils());
  }

  [[nodiscard]] Points result() const {
    Points points(target.size() / 3);
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i] = {target[3 * i], target[3 * i + 1], target[3 * i + 2]};
    }
    return points;
  }

  std::unique_ptr<const OpenSubdiv::Far::StencilTable> table;
  std::vector<float> source, target;
};

template <class Evaluator>
Peer osd_peer(const std::string& name, std::shared_ptr<OsdBuffers> buffers, const Points& limits) {
  buffers->apply<Evaluator>();
  require_agreement(name, buffers->result(), limits);
  return {name, [buffers] { buffers->apply<Evaluator>(); }};
}

// Every byte of a CSR of the same matrix, read once on all cores: what a step that reads one cannot
// be faster than where that comes from memory.
struct CsrStream {
  explicit CsrStream(const PreparedMesh& prepared) : table(to_far<float>(prepared.masks.view())) {}

  void read() {
    const std::span<const float> weights = table->GetWeights();
    const std::span<const int> indices = table->GetControlIndices(), offsets = table->GetOffsets();
    std::vector<Sums> pieces((weights.size() + kEntries - 1) / kEntries);
    parallel_each(pieces.size(), 4, [&](std::size_t p) {
      const std::size_t first = p * kEntries;
      const std::size_t count = std::min(kEntries, weights.size() - first);
      pieces[p] = sums_of(weights.subspan(first, count), indices.subspan(first, count));
    });
    parallel_for(offsets.size(), kEntries, [&](std::size_t begin, std::size_t end) {
      benchmark::DoNotOptimize(sums_of({}, offsets.subspan(begin, end - begin)));
    });
    benchmark::DoNotOptimize(pieces.data());
    benchmark::ClobberMemory();
  }

  static constexpr std::size_t kEntries = 36 * 1024;
  static constexpr std::size_t kLanes = 8;
  struct Sums {
    std::array<float, kLanes> weights{};
    std::array<std::int32_t, kLanes> indices{};
  };
  // In lanes, so that the compiler reads whole vectors.
  static Sums sums_of(std::span<const float> weights, std::span<const std::int32_t> indices) {
    Sums sums;
    for (std::size_t k = 0; k + kLanes <= weights.size(); k += kLanes)
      for (std::size_t lane = 0; lane < kLanes; ++lane) sums.weights[lane] += weights[k + lane];
    for (std::size_t k = 0; k + kLanes <= indices.size(); k += kLanes)
      for (std::size_t lane = 0; lane < kLanes; ++lane) sums.indices[lane] ^= indices[k + lane];
    return sums;
  }

  std::unique_ptr<const OpenSubdiv::Far::StencilTable> table;
};

struct EigenProduct {
  Eigen::SparseMatrix<float, Eigen::RowMajor> matrix;
  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> source, target;
};

Peer eigen_peer(const PreparedMesh& prepared, const Points& limits) {
  auto product = std::make_shared<EigenProduct>();
  const StencilView<double> view = prepared.masks.view();
  std::vector<Eigen::Triplet<float>> entries;
  for (std::int32_t i = 0; i < view.row_count(); ++i) {
    for (std::int32_t k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
      entries.emplace_back(i, view.indices[k], static_cast<float>(view.weights[k]));
    }
  }
  product->matrix.resize(view.row_count(), view.source_count);
  product->matrix.setFromTriplets(entries.begin(), entries.end());
  product->source.resize(view.source_count, 3);
  for (std::int32_t i = 0; i < view.source_count; ++i) {
    for (int k = 0; k < 3; ++k) product->source(i, k) = static_cast<float>(prepared.given[i][k]);
  }
  const auto apply = [product] { product->target.noalias() = product->matrix * product->source; };
  apply();
  Points result;
  for (std::int32_t i = 0; i < view.row_count(); ++i) {
    const auto row = product->target.row(i);
    result.push_back({row[0], row[1], row[2]});
  }
  require_agreement("eigen", result, limits);
  return {"eigen-float", apply};
}

}  // namespace

std::vector<Row> bench_update(const Options& options) {
  const PreparedMesh prepared(torus_grid(options.quad_count));
  const Points limits = prepared.limits_of(prepared.given);
  const auto osd = std::make_shared<OsdBuffers>(prepared);
  const auto cpu_float = make_cpu_backend({Precision::Float, 0});
  const auto cpu_double = make_cpu_backend({Precision::Double, 0});
  const auto cpu_float_single = make_cpu_backend({Precision::Float, 1});

  Group group;
  group.name = "update";
  group.size = std::to_string(prepared.mesh.face_count()) + " quads, " +
               std::to_string(prepared.masks.weights.size()) + " entries";
  group.baseline = "osd-cpu";
  const auto add = [&](const std::string& name, Backend& backend) {
    group.peers.push_back(
        update_peer(name, backend.make_solve(prepared.masks.view()), prepared, limits));
  };
  add("planish-cpu-float", *cpu_float);
  add("planish-cpu-double", *cpu_double);
  add("planish-cpu-float-1-thread", *cpu_float_single);
#ifdef PLANISH_HAS_VULKAN
  std::unique_ptr<Backend> vulkan;
  if (list_vulkan_devices().best >= 0) {
    vulkan = make_vulkan_backend({.device = options.device});
    add("planish-vulkan", *vulkan);
    group.size += "; vulkan on " + vulkan->description().name;
  }
#endif
  group.peers.push_back(osd_peer<Osd::CpuEvaluator>("osd-cpu", osd, limits));
  group.peers.push_back(osd_peer<Osd::OmpEvaluator>("osd-omp", osd, limits));
  group.peers.push_back(eigen_peer(prepared, limits));
  const auto csr = std::make_shared<CsrStream>(prepared);
  group.peers.push_back({"csr-stream", [csr] { csr->read(); }});
  return run_group(group, options.repetitions);
}

namespace {

constexpr double kTolerance = 1e-6;  // of the maximum error, in unit coordinates
using Matrix = Eigen::SparseMatrix<double>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;
using Cholesky = Eigen::SimplicialLDLT<Matrix>;
using ConjugateGradient = Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>,
                                                   Eigen::Lower | Eigen::Upper>;

// B = A T with A = diag(1 / valence) and T symmetric: B d = r becomes T d = A^-1 r.
struct SymmetricSystem {
  explicit SymmetricSystem(const PreparedMesh& prepared) {
    const StencilView<double> view = prepared.masks.view();
    std::vector<Eigen::Triplet<double>> entries;
    right.resize(view.row_count(), 3);
    for (std::int32_t i = 0; i < view.row_count(); ++i) {
      const double valence = prepared.valence[i];
      glm::dvec3 residual(0.0);
      for (std::int32_t k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
        entries.emplace_back(i, view.indices[k], valence * view.weights[k]);
        residual += view.weights[k] * (prepared.given[i] - prepared.given[view.indices[k]]);
      }
      for (int k = 0; k < 3; ++k) right(i, k) = valence * residual[k];
    }
    matrix.resize(view.row_count(), view.row_count());
    matrix.setFromTriplets(entries.begin(), entries.end());
    rows = matrix;
  }

  Matrix matrix;
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows;
  Columns right;
};

Points control_points(const PreparedMesh& prepared, const Columns& displacement) {
  Points points = prepared.given;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = displacement.row(static_cast<Eigen::Index>(i));
    points[i] += glm::dvec3(row[0], row[1], row[2]);
  }
  return points;
}

double largest_error(const PreparedMesh& prepared, const Points& control) {
  const Points limits = prepared.limits_of(control);
  double largest = 0;
  for (std::size_t i = 0; i < limits.size(); ++i) {
    largest = std::max(largest, glm::length(limits[i] - prepared.given[i]));
  }
  return largest;
}

Points planish_solution(const PreparedMesh& prepared, Backend& backend, Solver solver) {
  InterpolationOptions options;
  options.solver = solver;
  options.tolerance = kTolerance;
  options.spectral_bound = prepared.bound;
  if (solver == Solver::ConjugateGradients) options.row_weights = prepared.valence;
  const Interpolation result = interpolate(backend, prepared.masks.view(), prepared.given, options);
  if (!result.converged) throw std::runtime_error("solve: planish has not converged");
  Points points = prepared.given;
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += result.displacement[i];
  return points;
}

Peer planish_peer(const std::string& name, const PreparedMesh& prepared,
                  std::shared_ptr<Backend> backend, Solver solver, const Points& exact) {
  require_agreement(name, planish_solution(prepared, *backend, solver), exact);
  return {name,
          [&prepared, backend, solver] { (void)planish_solution(prepared, *backend, solver); }};
}

// Eigen stops at a relative residual: the loosest of these that meets our tolerance is used.
Peer conjugate_gradient_peer(const PreparedMesh& prepared, const SymmetricSystem& system,
                             const Points& exact) {
  double tolerance = 0.15;
  while (tolerance > 1e-12) {
    tolerance /= 1.5;
    const auto solution = [&system, tolerance] {
      ConjugateGradient solver;
      solver.setTolerance(tolerance);
      solver.compute(system.rows);
      return Columns(solver.solve(system.right));
    };
    const Points points = control_points(prepared, solution());
    if (largest_error(prepared, points) > kTolerance) continue;
    require_agreement("eigen-cg", points, exact);
    return {"eigen-cg", [solution] { (void)solution(); }};
  }
  throw std::runtime_error("solve: Eigen's conjugate gradients do not converge");
}

std::vector<Row> bench_solves_of(const std::string& name, PolygonMesh mesh, int repetitions) {
  const PreparedMesh prepared(std::move(mesh));
  const SymmetricSystem system(prepared);
  const auto factored = std::make_shared<Cholesky>(system.matrix);
  const Points exact = control_points(prepared, factored->solve(system.right));
  if (largest_error(prepared, exact) > kTolerance) {
    throw std::runtime_error("solve: Eigen's factorisation does not solve the system");
  }

  const auto on_float = std::shared_ptr<Backend>(make_cpu_backend({Precision::Float, 0}));
  const auto on_double = std::shared_ptr<Backend>(make_cpu_backend({Precision::Double, 0}));
  Group group;
  group.name = name;
  group.size = std::to_string(prepared.mesh.vertex_count()) + " vertices, " +
               std::to_string(prepared.masks.weights.size()) + " entries";
  group.baseline = "planish-chebyshev";
  group.peers = {
      planish_peer("planish-chebyshev", prepared, on_double, Solver::Chebyshev, exact),
      planish_peer("planish-chebyshev-float", prepared, on_float, Solver::Chebyshev, exact),
      planish_peer("planish-plain", prepared, on_double, Solver::Plain, exact),
      planish_peer("planish-cg", prepared, on_double, Solver::ConjugateGradients, exact),
      conjugate_gradient_peer(prepared, system, exact),
      {"eigen-ldlt",
       [&system] {
         const Cholesky solver(system.matrix);
         (void)Columns(solver.solve(system.right));
       }},
      {"eigen-ldlt-solve-only",
       [&system, factored] { (void)Columns(factored->solve(system.right)); }}};
  return run_group(group, repetitions);
}

// The factorisation of a larger system takes minutes.
constexpr std::int32_t kMostQuads = 100'000;

}  // namespace

std::vector<Row> bench_solve(const Options& options) {
  std::vector<Row> rows = bench_solves_of(
      "solve-torus", torus_grid(std::min(options.quad_count, kMostQuads)), options.repetitions);
  const std::vector<Row> sphere =
      bench_solves_of("solve-sphere", rough_icosphere(options.sphere_level), options.repetitions);
  rows.insert(rows.end(), sphere.begin(), sphere.end());
  return rows;
}

namespace {

constexpr std::int32_t kPolishSteps = 8;

PolygonMesh triangulated(const PolygonMesh& quads) {
  PolygonMesh mesh;
  mesh.positions = quads.positions;
  mesh.face_offsets = {0};
  for (std::int32_t f = 0; f < quads.face_count(); ++f) {
    const std::int32_t* v = &quads.face_vertices[quads.face_offsets[f]];
    for (const std::int32_t corner : {v[0], v[1], v[2], v[0], v[2], v[3]})
      mesh.face_vertices.push_back(corner);
    for (int triangle = 0; triangle < 2; ++triangle)
      mesh.face_offsets.push_back(mesh.face_offsets.back() + 3);
  }
  return mesh;
}

// Plain steps of the paper's iteration on tables that are on the device.
Peer plain_peer(const std::string& name, Backend& backend, const PreparedMesh& prepared) {
  const std::shared_ptr<Solve> solve = backend.make_solve(prepared.masks.view());
  solve->begin(prepared.given);
  return {name, [solve] {
            const std::array<StepCoefficients, 1> step = {{{0.0, 1.0}}};
            (void)solve->run(step, kNoStop);
          }};
}

// A net before its polish, and what the polish takes.
struct Unpolished {
  Unpolished(const PreparedMesh& prepared, const Subdivision& subdivision)
      : topology(make_fair_topology(prepared.mesh, subdivision)),
        given(prepared.given),
        offsets(fair_net(prepared.mesh, subdivision, given, {.polish_steps = 0}).state) {
    for (std::size_t c = 0; c < offsets.size(); ++c)
      offsets[c] -= given[topology.corner_vertices[c]];  // no curve points: the torus is closed
    const auto face_normals = unit_face_normals(topology, given);
    std::vector<glm::dvec3> normals(given.size());
    for (std::int32_t v = 0; v < topology.vertex_count; ++v)
      normals[v] = angle_weighted_normal(topology, given, face_normals, v, topology.ring(v));
    directions = polish_directions(topology, normals, std::vector<double>(given.size(), 0.0));
  }
  [[nodiscard]] BendingRows rows() const {
    return make_bending_rows(topology, given, directions, offsets);
  }
  void polish(std::int32_t steps) {
    std::vector<glm::dvec3> moved = offsets;
    apply_heights(topology, directions, polish_heights(topology, rows(), steps), moved);
  }

  FairTopology topology;
  std::span<const glm::dvec3> given;
  std::vector<glm::dvec3> offsets, directions;
};

}  // namespace

std::vector<Row> bench_fair(const Options& options) {
  const PreparedMesh prepared(triangulated(torus_grid(options.quad_count)));
  const Subdivision subdivision(prepared.topology, prepared.features, Weights::DooSabin);
  const FairOptions fair{kPolishSteps, {}};
  const auto cpu = make_cpu_backend({Precision::Float, 0});
  Group group;
  group.name = "fair";
  group.size = std::to_string(prepared.mesh.vertex_count()) + " vertices, triangles";
  group.baseline = "planish-cpu-plain-step";
  const FairOptions unpolished{0, {}};
  Unpolished net(prepared, subdivision);
  group.peers = {
      plain_peer("planish-cpu-plain-step", *cpu, prepared),
      {"planish-cpu-fair",
       [&] { (void)fair_net(prepared.mesh, subdivision, prepared.given, fair); }},
      {"planish-cpu-fair-without-polish",
       [&] { (void)fair_net(prepared.mesh, subdivision, prepared.given, unpolished); }},
      {"planish-cpu-topology", [&] { (void)make_fair_topology(prepared.mesh, subdivision); }},
      {"planish-cpu-polish", [&] { net.polish(kPolishSteps); }},
      {"planish-cpu-polish-rows", [&] { (void)net.rows(); }}};
#ifdef PLANISH_HAS_VULKAN
  std::unique_ptr<Backend> vulkan;
  if (list_vulkan_devices().best >= 0) vulkan = make_vulkan_backend({.device = options.device});
  auto* const builder = dynamic_cast<FairBuilder*>(vulkan.get());
  const FairTopology topology = make_fair_topology(prepared.mesh, subdivision);
  if (builder) {
    group.size += ", " + vulkan->description().name;
    group.baseline = "planish-vulkan-plain-step";
    require_agreement("planish-vulkan-fair",
                      builder->build_fair_net(topology, prepared.given, fair).state,
                      fair_net(prepared.mesh, subdivision, prepared.given, fair).state);
    group.peers.push_back(plain_peer("planish-vulkan-plain-step", *vulkan, prepared));
    group.peers.push_back({"planish-vulkan-fair",
                           [&] { (void)builder->build_fair_net(topology, prepared.given, fair); }});
    group.peers.push_back({"planish-vulkan-fair-without-polish", [&] {
                             (void)builder->build_fair_net(topology, prepared.given, unpolished);
                           }});
  }
#endif
  return run_group(group, std::min(options.repetitions, 3));
}

namespace {

// A run takes seconds: its share of noise is small and fewer runs do.
constexpr int kSurfaceRuns = 3;

}  // namespace

std::vector<Row> bench_surface(const Options& options) {
  const PreparedMesh prepared(torus_grid(options.quad_count));
  const auto backend = make_cpu_backend();
  const auto surface_of = [&](int level) {
    EvaluateOptions evaluation;
    evaluation.level = level;
    return evaluate(prepared.mesh, *backend, evaluation);
  };
  // Limit points of the cage's own vertices are the same at every level.
  const std::vector<glm::dvec3> limits = prepared.limits_of(prepared.mesh.positions);
  for (const int level : {1, 2}) {
    const SurfaceMesh surface = surface_of(level);
    require_agreement("surface", std::span(surface.positions).first(limits.size()), limits);
  }

  Group group;
  group.name = "surface";
  group.size = std::to_string(prepared.mesh.face_count()) + " quads";
  group.baseline = "level-1";
  group.peers = {{"level-1", [&] { (void)surface_of(1); }},
                 {"level-2", [&] { (void)surface_of(2); }}};
  return run_group(group, std::min(options.repetitions, kSurfaceRuns));
}

}  // namespace planish::bench
