#include <algorithm>
#include <chrono>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/benchmarks.h"
#include "planish/edit/editor.h"

namespace planish::bench {

glm::dvec3 way_of(std::int32_t vertex, double way) {
  const std::uint32_t lot = static_cast<std::uint32_t>(vertex) * 2'654'435'761u;
  return {lot >> 31 == 0 ? way : -way, 0, 0};
}

std::vector<std::int32_t> near_vertices(const PolygonMesh& mesh, std::int32_t vertex) {
  std::vector<std::int32_t> near(mesh.positions.size());
  std::iota(near.begin(), near.end(), 0);
  const auto distance = [&](std::int32_t v) {
    return glm::distance(mesh.positions[v], mesh.positions[vertex]);
  };
  const std::size_t many = std::min(kManyMoves, near.size());
  std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(many) - 1, near.end(),
                   [&](std::int32_t a, std::int32_t b) { return distance(a) < distance(b); });
  near.resize(many);
  return near;
}

std::vector<std::int32_t> scattered_vertices(const PolygonMesh& mesh) {
  const std::size_t count = mesh.positions.size(), many = std::min(kManyMoves, count);
  std::vector<std::int32_t> scattered(many);
  for (std::size_t i = 0; i < many; ++i) scattered[i] = static_cast<std::int32_t>(i * count / many);
  return scattered;
}

namespace {

// As many moves as a mesh has time for between two looks at the clock.
constexpr int kMoves = 64;

class EditBench {
 public:
  EditBench(const PolygonMesh& mesh, std::string size)
      : mesh_(mesh), size_(std::move(size)), fit_(fit(mesh, *make_cpu_backend())) {
    editor_ = std::make_unique<Editor>(mesh_, fit_);
  }

  std::vector<Row> run(int repetitions) {
    const Group group{"edit", size_, "whole", {}};
    std::vector<Row> rows;
    std::vector<std::int32_t> all(mesh_.positions.size());
    for (std::size_t v = 0; v < all.size(); ++v) all[v] = static_cast<std::int32_t>(v);
    const int few = std::clamp(repetitions / 5, 1, 3);
    rows.push_back(timed(group, "whole", few, 1, [&](int) { return all; }));
    rows.push_back(timed(group, "one", repetitions, kMoves,
                         [&](int i) { return std::vector<std::int32_t>{any(i)}; }));
    rows.push_back(
        timed(group, "near-1000", few, 4, [&](int i) { return near_vertices(mesh_, any(i)); }));
    rows.push_back(
        timed(group, "scattered-1000", few, 1, [&](int) { return scattered_vertices(mesh_); }));
    (void)editor_->queries();  // from here on moves keep their tree right
    rows.push_back(timed(group, "one-picked", repetitions, kMoves,
                         [&](int i) { return std::vector<std::int32_t>{any(i)}; }));
    for (Row& row : rows) {
      row.ratio = row.median_ms / rows.front().median_ms;
      row.figures.push_back({"cpu_ratio", row.cpu_ms / rows.front().cpu_ms});
    }
    require_exact();
    return rows;
  }

 private:
  // What was timed has kept the fit's tolerance, measured anew in double.
  void require_exact() const {
    const double error = editor_->measured_error();
    if (error <= FitOptions{}.tolerance) return;
    throw std::runtime_error("after its moves an edited surface is off by " +
                             std::to_string(error) + " of the diagonal");
  }

  [[nodiscard]] std::int32_t any(int i) const {
    std::mt19937 random(static_cast<std::uint32_t>(i));
    return std::uniform_int_distribution<std::int32_t>(0, mesh_.vertex_count() - 1)(random);
  }

  // Moves to and fro: a run of them there, the next one back.
  template <class Choose>
  Row timed(const Group& group, const std::string& peer, int repetitions, int moves,
            const Choose& choose) {
    std::vector<std::vector<std::int32_t>> vertices;
    for (int i = 0; i < moves; ++i) vertices.push_back(choose(i));
    std::vector<double> wall, cpu;
    double row_count = 0, control_count = 0, node_count = 0;
    std::vector<glm::dvec3> to;
    for (int r = -1; r < repetitions; ++r) {
      const double cpu_before = process_cpu_ms();
      const auto before = std::chrono::steady_clock::now();
      for (const auto& chosen : vertices) {
        to.clear();
        const double way = r % 2 == 0 ? 0 : kWayOfEdit * fit_.placement.diagonal;
        for (const std::int32_t v : chosen) to.push_back(mesh_.positions[v] + way_of(v, way));
        const EditChange change = editor_->move(chosen, to);
        row_count += static_cast<double>(change.row_count);
        control_count += static_cast<double>(change.control_points.size());
        node_count += static_cast<double>(change.tree_nodes);
      }
      if (r < 0) continue;  // warms up
      wall.push_back(
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before)
              .count() /
          moves);
      cpu.push_back((process_cpu_ms() - cpu_before) / moves);
    }
    Row row = row_of_times(group, peer, wall);
    row.cpu_ms = median(cpu);
    const double count = static_cast<double>(moves) * (repetitions + 1);
    row.figures = {{"rows_per_move", row_count / count},
                   {"control_points_per_move", control_count / count},
                   {"tree_nodes_per_move", node_count / count},
                   {"error_bound", editor_->error_bound()}};
    return row;
  }

  const PolygonMesh& mesh_;
  std::string size_;
  Fit fit_;
  std::unique_ptr<Editor> editor_;
};

}  // namespace

std::vector<Row> bench_edit(const Options& options) {
  std::vector<Row> rows;
  std::vector<std::int32_t> counts = options.point_counts;
  if (options.quad_count >= 1'000'000) counts.push_back(4 * options.quad_count);
  for (const std::int32_t count : counts) {
    const PolygonMesh mesh = torus_grid(count);
    EditBench bench(mesh, "torus, " + std::to_string(mesh.vertex_count()) + " vertices");
    const std::vector<Row> measured = bench.run(options.repetitions);
    rows.insert(rows.end(), measured.begin(), measured.end());
#ifdef PLANISH_HAS_VULKAN
    const std::vector<Row> on_device = bench_device_edits(options, mesh, rows.back().size);
    rows.insert(rows.end(), on_device.begin(), on_device.end());
#endif
  }
  return rows;
}

}  // namespace planish::bench
