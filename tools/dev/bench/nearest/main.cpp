// SPDX-License-Identifier: GPL-3.0-or-later
// Times closest points of a surface against CGAL's tree over its triangles. See ../README.md.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <benchmark/benchmark.h>
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "bench/benchmarks.h"
#include "planish/files/mesh_file.h"
#include "planish/queries/surface_queries.h"
#include "planish/surface/surface_blocks.h"

namespace planish::bench {
namespace {

// CGAL's AABB tree over a tessellation, quads cut from their first corner.
class CgalTree {
 public:
  explicit CgalTree(const SurfaceMesh& surface);
  ~CgalTree();

  // From points to the triangles, one after the other.
  void distances(std::span<const glm::dvec3> points, std::span<double> result) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

using Kernel = CGAL::Simple_cartesian<double>;
using CgalTriangle = Kernel::Triangle_3;
using Triangles = std::vector<CgalTriangle>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 cgal_point(const glm::dvec3& p) { return {p.x, p.y, p.z}; }

struct CgalTree::Parts {
  Triangles triangles;
  Tree tree;
};

CgalTree::CgalTree(const SurfaceMesh& surface) : parts_(std::make_unique<Parts>()) {
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    const auto at = [&](std::size_t i) { return cgal_point(surface.positions[face[i]]); };
    for (std::size_t i = 1; i + 1 < face.size(); ++i)
      parts_->triangles.emplace_back(at(0), at(i), at(i + 1));
  }
  parts_->tree.insert(parts_->triangles.begin(), parts_->triangles.end());
  parts_->tree.build();
  parts_->tree.accelerate_distance_queries();
}

CgalTree::~CgalTree() = default;

void CgalTree::distances(std::span<const glm::dvec3> points, std::span<double> result) const {
  for (std::size_t i = 0; i < points.size(); ++i)
    result[i] = std::sqrt(parts_->tree.squared_distance(cgal_point(points[i])));
}

}  // namespace
}  // namespace planish::bench

namespace {

using namespace planish;
using namespace planish::bench;

struct NearestOptions {
  std::vector<std::string> meshes{PLANISH_SOURCE_DIR "/scenes/rocker_arm.obj",
                                  PLANISH_SOURCE_DIR "/scenes/icosphere.obj"};
  int level = 4;
  std::size_t points = 2'000;
  int repetitions = 3;
  bool smoke = false;
  std::filesystem::path json;
};

// Off the surface along its normals, by a normal distribution of that width.
std::vector<glm::dvec3> points_beside(const LimitSurface& surface, double width,
                                      std::size_t count) {
  std::mt19937 random(2);
  std::normal_distribution<double> off(0, width);
  std::uniform_real_distribution<double> within(0, 1);
  const MeshTopology& topology = surface.topology();
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const auto corner =
        static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(topology.corner_count()));
    const double u = within(random), v = within(random);
    const SurfacePoint on = surface.evaluate(surface_parameter(topology, corner, u, v));
    points.push_back(on.position + off(random) * on.normal);
  }
  return points;
}

// The tree's distances are those of triangles, which are off by the difference at most.
void print_error(const std::string& width, const std::vector<ClosestPoint>& ours,
                 const std::vector<double>& peers, double diagonal) {
  double most = 0;
  for (std::size_t i = 0; i < ours.size(); ++i)
    most = std::max(most, std::abs(ours[i].distance - peers[i]));
  std::printf("%s off: the tree's distances differ by up to %.2g of the diagonal\n", width.c_str(),
              most / diagonal);
}

void bench_mesh(const std::string& path, const NearestOptions& options, std::vector<Row>& rows) {
  const PolygonMesh mesh = read_mesh(path).mesh;
  const auto base = std::make_shared<const DooSabinSurface>(mesh, EvaluateOptions{});
  const LimitSurface surface(base);
  const SurfaceMesh level = collect(*base->level(options.level), {});
  const double diagonal = base->placement().diagonal;
  const std::string name = std::filesystem::path(path).filename().string();
  const auto add = [&](const Group& group) {
    const std::vector<Row> measured = run_group(group, options.repetitions);
    rows.insert(rows.end(), measured.begin(), measured.end());
  };
  add({"nearest-set-up",
       name,
       "cgal-tree",
       {{"cgal-tree", [&] { (void)CgalTree(level); }},
        {"planish", [&] { (void)SurfaceQueries(surface); }}}});
  const SurfaceQueries queries(surface);
  const CgalTree tree(level);
  for (const auto& [label, width] :
       {std::pair{"1e-4", 1e-4}, std::pair{"1e-2", 1e-2}, std::pair{"0.3", 0.3}}) {
    const std::vector<glm::dvec3> points = points_beside(surface, width * diagonal, options.points);
    std::vector<ClosestPoint> closest(points.size());
    std::vector<double> distances(points.size());
    add({"nearest-" + std::string(label),
         name + ", " + std::to_string(points.size()) + " points",
         "cgal-tree",
         {{"cgal-tree", [&] { tree.distances(points, distances); }},
          {"planish", [&] { queries.closest(points, closest); }}}});
    print_error(name + ", " + label, closest, distances, diagonal);
  }
}

void run(const NearestOptions& options) {
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const Machine machine = this_machine();
  std::vector<Row> rows;
  for (const std::string& mesh : options.meshes) bench_mesh(mesh, options, rows);
  print_table(machine, rows);
  if (!options.json.empty()) write_json(options.json, machine, rows, {});
}

}  // namespace

int main(int argc, char** argv) {
  NearestOptions options;
  CLI::App app{"Times closest points of surfaces against CGAL's tree of their triangles."};
  app.add_option("--mesh", options.meshes, "cages; our rocker arm and icosphere by default")
      ->check(CLI::ExistingFile);
  app.add_option("--level", options.level, "of the triangles")
      ->check(CLI::Range(1, 6))
      ->capture_default_str();
  app.add_option("--points", options.points, "questions of each distance")
      ->check(CLI::Range(10, 1'000'000))
      ->capture_default_str();
  app.add_option("--repetitions", options.repetitions, "runs of each peer")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--json", options.json, "write the figures to this file");
  app.add_flag("--smoke", options.smoke, "level 1, 50 points, one run: that everything runs");
  CLI11_PARSE(app, argc, argv);
  if (options.smoke) {
    options.level = 1;
    options.points = 50;
    options.repetitions = 1;
  }
  int own = 1;  // none of the flags are Google Benchmark's
  initialize_benchmark(own, argv);
  try {
    run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "planish-nearest-bench: %s\n", error.what());
    return 1;
  }
  return 0;
}
