// SPDX-License-Identifier: GPL-3.0-or-later
// Times the way from points to a mesh against CGAL and meshoptimizer. See ../README.md.
#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <benchmark/benchmark.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <exception>
#include <glm/vec3.hpp>
#include <iterator>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "bench/benchmarks.h"
#include "bench/points/peers.h"
#include "make_scenes/sample_points.h"
#include "make_scenes/scene_list.h"
#include "planish/core/output_file.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/reconstruct/mesher_process.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/reconstruct/spatial_search.h"

namespace planish::bench {
namespace {

// CGAL's advancing front surface reconstruction as its manual calls it, without anything of ours.
std::vector<Triangle> mesh_by_cgal_alone(std::span<const glm::dvec3> points) {
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::vector<Point> sites;
  sites.reserve(points.size());
  for (const glm::dvec3& p : points) sites.emplace_back(p.x, p.y, p.z);
  std::vector<std::array<std::size_t, 3>> facets;
  CGAL::advancing_front_surface_reconstruction(sites.begin(), sites.end(),
                                               std::back_inserter(facets));
  std::vector<Triangle> triangles;
  triangles.reserve(facets.size());
  for (const auto& f : facets)
    triangles.push_back({static_cast<std::int32_t>(f[0]), static_cast<std::int32_t>(f[1]),
                         static_cast<std::int32_t>(f[2])});
  return triangles;
}

}  // namespace
}  // namespace planish::bench

namespace {

using namespace planish;
using namespace planish::bench;

struct PointOptions {
  std::string mesh;  // a file of triangles; our rocker arm where empty
  int loop_rounds = 2;
  std::int32_t points = 203'904;
  double tolerance = 1e-4;  // of the diagonal
  int repetitions = 5;
  bool uniform = false, smoke = false;
  std::filesystem::path json, save;
};

PolygonMesh sampled_mesh(const PointOptions& options) {
  if (options.mesh.empty()) return shapes::scene_mesh(shapes::scenes().at(2));
  return loop_subdivided(read_mesh(options.mesh).mesh, options.loop_rounds);
}

std::vector<glm::dvec3> cloud_of(const PolygonMesh& mesh, const PointOptions& options) {
  return options.uniform ? shapes::sample_uniform(mesh, options.points, 1)
                         : shapes::sample_poisson_disk(mesh, options.points, 1);
}

void save(const std::filesystem::path& folder, const PolygonMesh& mesh,
          std::span<const glm::dvec3> points) {
  std::filesystem::create_directories(folder);
  const auto write = [&](const char* name, const std::string& bytes) {
    OutputFile file(folder / name);
    file.write(bytes);
    file.commit();
  };
  write("source.obj", shapes::obj_text(mesh, "sampled by planish-point-bench"));
  write("cloud.ply", shapes::ply_text(points));
}

std::vector<Triangle> mesh_step(std::span<const glm::dvec3> points, const Mesher& mesher) {
  return repair_triangles(points, mesher(points, {}), {.longest_filled_loop = 16}).triangles;
}

std::vector<Row> bench_mesh_step(std::span<const glm::dvec3> points, const PointOptions& options,
                                 const Mesher& mesher) {
  const double tolerance = options.tolerance * diagonal_of(points);
  Group group{.name = "points-mesh",
              .size = std::to_string(points.size()) + " points",
              .baseline = "cgal-alone"};
  group.peers = {{"cgal-alone", [&] { (void)mesh_by_cgal_alone(points); }},
                 {"planish-mesh", [&] { (void)mesher(points, {}); }},
                 {"planish-mesh-repair", [&] { (void)mesh_step(points, mesher); }},
                 {"planish-mesh-repair-simplify", [&] {
                    (void)simplify(points, mesh_step(points, mesher), {.tolerance = tolerance});
                  }}};
  return run_group(group, options.repetitions);
}

std::size_t used_vertices(std::span<const Triangle> triangles) {
  std::set<std::int32_t> used;
  for (const Triangle& t : triangles) used.insert(t.begin(), t.end());
  return used.size();
}

void print_result(const char* name, std::span<const glm::dvec3> points,
                  std::span<const Triangle> triangles, double diagonal) {
  const PointDistances distances = measure_distances(points, points, triangles);
  std::printf("%s: %zu vertices, farthest point %.3g, rms %.3g of the diagonal\n", name,
              used_vertices(triangles), distances.max / diagonal, distances.rms / diagonal);
}

std::vector<Row> bench_simplify(std::span<const glm::dvec3> points, const PointOptions& options,
                                const Mesher& mesher) {
  const std::vector<Triangle> triangles = mesh_step(points, mesher);
  const double diagonal = diagonal_of(points), tolerance = options.tolerance * diagonal;
  const MeshoptimizerMesh peer(points, triangles);
  const SimplifyTarget target = target_error_for(peer, points, tolerance);
  const auto simplify_within = [&](double limit) {
    return simplify(points, triangles, {.tolerance = limit}).triangles;
  };
  print_result("planish-simplify", points, simplify_within(tolerance), diagonal);
  print_result("meshoptimizer", points, peer.simplified(target.target_error), diagonal);
  print_result("meshoptimizer with the tolerance as its target", points,
               peer.simplified(options.tolerance), diagonal);
  Group group{.name = "points-simplify",
              .size = std::to_string(points.size()) + " points",
              .baseline = "meshoptimizer"};
  group.peers = {{"meshoptimizer", [&] { (void)peer.simplified(target.target_error); }},
                 {"planish-simplify", [&] { (void)simplify_within(tolerance); }}};
  if (target.distance > tolerance) {
    std::printf("meshoptimizer comes no nearer to every point than %.3g of the diagonal\n",
                target.distance / diagonal);
    print_result("planish-simplify-as-near", points, simplify_within(target.distance), diagonal);
    group.peers.push_back(
        {"planish-simplify-as-near", [&] { (void)simplify_within(target.distance); }});
  }
  return run_group(group, options.repetitions);
}

void run(const PointOptions& options) {
  const PolygonMesh mesh = sampled_mesh(options);
  const std::vector<glm::dvec3> points = cloud_of(mesh, options);
  if (!options.save.empty()) {
    save(options.save, mesh, points);
    return;
  }
  const auto program = find_mesher_program();
  if (!program) throw std::runtime_error("planish-reconstruct is not beside this program");
  const Mesher mesher = mesher_process(*program);
  const Machine machine = this_machine();
  std::vector<Row> rows = bench_mesh_step(points, options, mesher);
  const std::vector<Row> simplified = bench_simplify(points, options, mesher);
  rows.insert(rows.end(), simplified.begin(), simplified.end());
  print_table(machine, rows);
  if (!options.json.empty()) write_json(options.json, machine, rows, {});
}

}  // namespace

int main(int argc, char** argv) {
  PointOptions options;
  CLI::App app{"Times points to mesh against CGAL alone and against meshoptimizer."};
  app.add_option("--mesh", options.mesh, "triangles to sample; our rocker arm by default")
      ->check(CLI::ExistingFile);
  app.add_option("--loop", options.loop_rounds, "Loop subdivisions of --mesh before sampling")
      ->check(CLI::Range(1, 4))
      ->capture_default_str();
  app.add_option("--points", options.points, "points")
      ->check(CLI::Range(100, 4'000'000))
      ->capture_default_str();
  app.add_option("--tolerance", options.tolerance, "of the simplification, of the diagonal")
      ->check(CLI::Range(1e-6, 1e-1))
      ->capture_default_str();
  app.add_option("--repetitions", options.repetitions, "runs of each peer")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--json", options.json, "write the figures to this file");
  app.add_option("--save", options.save,
                 "write source.obj and cloud.ply to this folder, and time nothing");
  app.add_flag("--uniform", options.uniform, "independent points; Poisson-disk by default");
  app.add_flag("--smoke", options.smoke, "2,000 points, one run: checks that everything runs");
  CLI11_PARSE(app, argc, argv);
  if (options.smoke) {
    options.points = 2'000;
    options.tolerance = 1e-3;
    options.repetitions = 1;
  }
  int own = 1;  // none of the flags are Google Benchmark's
  initialize_benchmark(own, argv);
  try {
    run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "planish-point-bench: %s\n", error.what());
    return 1;
  }
  return 0;
}
