#include <benchmark/benchmark.h>
#include <opensubdiv/osd/bufferDescriptor.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/ompEvaluator.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <memory>
#include <span>

#include "bench/agreement.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "bench/prepared_mesh.h"
#include "planish/backend/cpu_backend.h"
#include "planish/core/parallel.h"
#include "planish/stencil/far_tables.h"
#ifdef PLANISH_HAS_VULKAN
#include "planish/vulkan/vulkan_backend.h"
#endif

namespace planish::bench {

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

}  // namespace planish::bench
