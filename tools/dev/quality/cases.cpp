#include "quality/tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "make_scenes/models.h"
#include "make_scenes/sample_points.h"
#include "make_scenes/shapes.h"
#include "planish/features/find_features.h"
#include "planish/files/mesh_file.h"
#include "planish/mend/repair.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/quads/pair_triangles.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/solve/backend.h"
#include "quality/wild_shapes.h"

namespace planish::quality {

namespace {

using shapes::Sampling;

// Every quad cut along one of its diagonals, the first or drawn by lot.
PolygonMesh cut_quads(const PolygonMesh& quads, bool by_lot) {
  shapes::RandomNumbers random(5);
  PolygonMesh mesh = quads;
  mesh.face_offsets = {0};
  mesh.face_vertices.clear();
  for (std::int32_t f = 0; f < quads.face_count(); ++f) {
    const auto v = quads.face(f);
    const int first = by_lot ? random.below(2) : 0;
    for (const int k : {first, first + 2}) {
      mesh.add_face(std::array{v[k % 4], v[(k + 1) % 4], v[(k + 2) % 4]});
    }
  }
  return mesh;
}

PolygonMesh cube_sphere(std::int32_t cells) {
  PolygonMesh mesh = shapes::cube(cells);
  for (glm::dvec3& p : mesh.positions) p = glm::normalize(p);
  return mesh;
}

PolygonMesh random_sphere(std::int32_t count, std::uint32_t seed, bool paired) {
  const std::vector<glm::dvec3> points = random_sphere_points(count, seed);
  const std::vector<Triangle> triangles = delaunay_on_sphere(points);
  if (paired) return pair_triangles(points, triangles);
  PolygonMesh mesh = polygons_of(triangles);
  mesh.positions = points;
  return mesh;
}

constexpr double kFlattened = 0.3;

// As uneven as a random sphere, and its faces are squeezed as well.
PolygonMesh flattened(PolygonMesh mesh) {
  for (glm::dvec3& p : mesh.positions) p.z *= kFlattened;
  return mesh;
}

Truth true_flat_ellipsoid() {
  return true_zero_set(
      [](const glm::dvec3& p) { return glm::length(glm::dvec3(p.x, p.y, p.z / kFlattened)) - 1; });
}

PolygonMesh random_polygons_on_sphere(const shapes::RandomMeshOptions& options) {
  PolygonMesh mesh = shapes::random_polygon_mesh(options);
  for (glm::dvec3& p : mesh.positions) p = glm::normalize(p);
  return mesh;
}

PolygonMesh as_mesh(const SurfaceMesh& surface) {
  PolygonMesh fine;
  fine.positions.assign(surface.positions.begin(), surface.positions.end());
  for (std::int64_t f = 0; f < surface.face_count(); ++f) fine.add_face(surface.face(f));
  return fine;
}

// Loop's surface of a triangle mesh: smooth, and none of the methods'.
PolygonMesh loop_surface(const PolygonMesh& mesh) {
  const auto backend = make_cpu_backend({Precision::Double});
  return as_mesh(evaluate(mesh, *backend, {.level = 2, .scheme = Scheme::Loop}));
}

// A shape's own smooth surface in fine quads, to be sampled and to compare with.
PolygonMesh fine_polygons(const PolygonMesh& mesh) {
  const auto backend = make_cpu_backend({Precision::Double});
  return as_mesh(evaluate(mesh, fit(mesh, *backend), *backend, EvaluateOptions{.level = 2}));
}

Case scanned_arm(const Mesher& mesher, const std::string& name,
                 const shapes::ScanOptions& options) {
  Case made{name, shapes::scan(shapes::rocker_arm(), shapes::rocker_arm_field, mesher, options),
            true_zero_set(shapes::rocker_arm_field)};
  made.is_scan = options.tolerance > 0;
  return made;
}

Case scanned_shape(const Mesher& mesher, const std::string& name, const PolygonMesh& shape) {
  Case made{name};
  made.source = fine_polygons(shape);
  made.mesh = shapes::scan(made.source, {}, mesher, {.point_count = 100'000, .tolerance = 2e-4});
  made.has_smooth_source = made.is_scan = made.is_held_out = true;
  return made;
}

// The bearing block in few uneven triangles, its sharp edges tagged or not.
Case simplified_part(const std::string& name, bool creases) {
  Case made{name};
  made.source = shapes::bearing_block();
  const SimplifiedMesh simplified =
      simplify(made.source.positions, quads_as_triangles(made.source.face_vertices),
               {.tolerance = 1e-3 * placement_of(made.source).diagonal});
  PolygonMesh mesh = polygons_of(simplified.triangles);
  mesh.positions = made.source.positions;
  made.mesh = without_unused_vertices(mesh).mesh;
  if (creases) made.mesh.creases = find_features(made.mesh).sharp_edges();
  return made;
}

// In triangles within a fraction of the diagonal, compared with the shape's own smooth surface.
Case decimated(const std::string& name, const PolygonMesh& shape, double tolerance) {
  Case made{name};
  made.source = fine_polygons(shape);
  const SimplifiedMesh simplified =
      simplify(shape.positions, quads_as_triangles(shape.face_vertices),
               {.tolerance = tolerance * placement_of(shape).diagonal});
  PolygonMesh mesh = polygons_of(simplified.triangles);
  mesh.positions = shape.positions;
  made.mesh = without_unused_vertices(mesh).mesh;
  made.has_smooth_source = true;
  return made;
}

Case of(const std::string& name, PolygonMesh mesh, Truth truth, bool is_held_out = false) {
  Case made{name, std::move(mesh), std::move(truth)};
  made.is_held_out = is_held_out;
  return made;
}

PolygonMesh read_obj_mesh(const std::filesystem::path& path) {
  return repair(read_mesh(path).mesh).mesh;
}

// Nobody knows what shape its vertices were taken from: that of triangles is taken to be Loop's
// surface.
Case of_file(const std::filesystem::path& path) {
  Case made = of(path.filename().string(), read_obj_mesh(path), {});
  const std::vector<std::int32_t>& offsets = made.mesh.face_offsets;
  if (offsets.back() == 3 * made.mesh.face_count()) {
    made.source = loop_surface(made.mesh);
    made.has_smooth_source = true;
  }
  return made;
}

}  // namespace

std::vector<NamedCase> analytic_cases() {
  constexpr shapes::TorusOptions kTorus{.ring_count = 24, .tube_count = 12};
  const Truth torus = true_torus(kTorus.radius, kTorus.tube_radius), sphere = true_sphere(1.0);
  const Truth wave = true_zero_set([](const glm::dvec3& p) {
    return p.z - 0.1 * std::sin(2 * std::numbers::pi * p.x) * std::cos(2 * std::numbers::pi * p.y);
  });
  std::vector<NamedCase> cases;
  const auto add = [&](const std::string& name, const Truth& truth, bool is_held_out,
                       const std::function<PolygonMesh()>& make) {
    cases.push_back({name, [=] { return of(name, make(), truth, is_held_out); }});
  };
  add("torus 24 x 12, quads", torus, false, [=] { return shapes::torus(kTorus); });
  add("torus 24 x 12, triangles", torus, false,
      [=] { return cut_quads(shapes::torus(kTorus), false); });
  add("torus 24 x 12, cut by lot", torus, true,
      [=] { return cut_quads(shapes::torus(kTorus), true); });
  add("torus 12 x 48, narrow quads", torus, false, [=] {
    return shapes::torus({12, 48, kTorus.radius, kTorus.tube_radius});
  });
  add("icosphere 3", sphere, false, [] { return shapes::icosphere(3); });
  add("dual of icosphere 2", sphere, false, [] {
    PolygonMesh mesh = shapes::dual(shapes::icosphere(2));
    for (glm::dvec3& p : mesh.positions) p = glm::normalize(p);
    return mesh;
  });
  add("cube sphere 8", sphere, false, [] { return cube_sphere(8); });
  add("pole sphere, 64-gons", sphere, true, [] { return shapes::pole_sphere(64, 30); });
  add("Delaunay sphere 600", sphere, false, [] { return random_sphere(600, 1, false); });
  add("Delaunay sphere 600, paired", sphere, false, [] { return random_sphere(600, 1, true); });
  add("flat ellipsoid, Delaunay", true_flat_ellipsoid(), true,
      [] { return flattened(random_sphere(800, 3, false)); });
  add("mixed polygons", {}, true, [] { return shapes::mixed_polygons(); });
  add("random polygons", {}, false, [] { return shapes::random_polygon_mesh(); });
  add("random polygons, spherical", sphere, false,
      [] { return random_polygons_on_sphere({.seed = 7}); });
  add("L-bracket", {}, false,
      [] { return read_obj_mesh(std::filesystem::path(PLANISH_SCENES) / "l_bracket.obj"); });
  add("wavy patch, open", wave, true, [] { return shapes::wavy_patch(24, 24); });
  add("wavy patch, cut by lot", wave, true,
      [] { return cut_quads(shapes::wavy_patch(24, 24), true); });
  add("bearing block, creased", {}, false, [] { return shapes::bearing_block(); });
  for (const auto& [name, creases] :
       {std::pair("bearing block, simplified", true), {"bearing block, untagged", false}}) {
    cases.push_back(
        {name, [name = name, creases = creases] { return simplified_part(name, creases); }});
  }
  return cases;
}

std::vector<NamedCase> second_held_out_cases() {
  const Truth sphere = true_sphere(1.0);
  std::vector<NamedCase> cases;
  const auto add = [&](const std::string& name, const Truth& truth,
                       const std::function<PolygonMesh()>& make) {
    cases.push_back({name, [=] { return of(name, make(), truth, true); }});
  };
  add("torus 70 x 7, quads", true_torus(1.0, 0.4),
      [] { return shapes::torus({.ring_count = 70, .tube_count = 7}); });
  add("torus 16 x 90, narrow quads", true_torus(1.0, 0.7), [] {
    return shapes::torus({.ring_count = 16, .tube_count = 90, .radius = 1.0, .tube_radius = 0.7});
  });
  add("random polygons 32, spherical", sphere, [] {
    return random_polygons_on_sphere({.seed = 32, .merged_share = 0.5, .largest_face = 10});
  });
  add("random polygons 33, spherical", sphere, [] {
    return random_polygons_on_sphere(
        {.seed = 33, .level = 4, .merged_share = 0.7, .largest_face = 14, .jitter = 0.2});
  });
  add("mixed polygons 9", {}, [] { return shapes::mixed_polygons(9); });
  add("Delaunay sphere 700", sphere, [] { return random_sphere(700, 11, false); });
  add("flat ellipsoid, paired", true_flat_ellipsoid(),
      [] { return flattened(random_sphere(700, 12, true)); });
  return cases;
}

std::vector<NamedCase> dense_cases() {
  std::vector<NamedCase> cases;
  const auto add = [&](const std::string& name, std::int64_t density, const Truth& truth,
                       bool is_held_out, const std::function<PolygonMesh()>& make) {
    const std::string full = name + ", " + std::to_string(density);
    cases.push_back({full, [=] { return of(full, make(), truth, is_held_out); }});
  };
  for (const std::int32_t n : {8, 16, 40, 96}) {
    const shapes::TorusOptions ring{.ring_count = n, .tube_count = n / 2};
    const Truth torus = true_torus(ring.radius, ring.tube_radius);
    add("torus, quads", n, torus, false, [=] { return shapes::torus(ring); });
    add("torus, triangles", n, torus, false, [=] { return cut_quads(shapes::torus(ring), false); });
    add("torus, cut by lot", n, torus, true, [=] { return cut_quads(shapes::torus(ring), true); });
    add("cube sphere", n, true_sphere(1), false, [=] { return cube_sphere(n); });
    add("cube sphere, flat", n, true_flat_ellipsoid(), false,
        [=] { return flattened(cube_sphere(n)); });
    add("pole sphere", n, true_sphere(1), true, [=] { return shapes::pole_sphere(2 * n, n); });
  }
  for (const std::int32_t n : {1, 2, 4, 5}) {
    add("icosphere", n, true_sphere(1), false, [=] { return shapes::icosphere(n); });
    add("icosphere, flat", n, true_flat_ellipsoid(), true,
        [=] { return flattened(shapes::icosphere(n)); });
    add("dual of icosphere", n, true_sphere(1), true, [=] {
      PolygonMesh mesh = shapes::dual(shapes::icosphere(n));
      for (glm::dvec3& p : mesh.positions) p = glm::normalize(p);
      return mesh;
    });
  }
  for (const std::int32_t n : {100, 2000, 8000}) {
    add("random sphere", n, true_sphere(1), false, [=] { return random_sphere(n, 21, false); });
    add("random ellipsoid, paired", n, true_flat_ellipsoid(), true,
        [=] { return flattened(random_sphere(n, 22, true)); });
  }
  return cases;
}

std::vector<NamedCase> decimated_cases() {
  std::vector<NamedCase> cases;
  for (const double tolerance : {2e-4, 1e-3, 4e-3}) {
    const std::string density = ", " + std::to_string(tolerance).substr(0, 6);
    cases.push_back({"arm, decimated" + density, [=] {
                       Case made =
                           decimated("arm, decimated" + density, shapes::rocker_arm(), tolerance);
                       made.truth = true_zero_set(shapes::rocker_arm_field);
                       return made;
                     }});
    cases.push_back({"bust, decimated" + density, [=] {
                       return decimated("bust, decimated" + density, shapes::bust(), tolerance);
                     }});
    cases.push_back({"goblet, decimated" + density, [=] {
                       return decimated("goblet, decimated" + density, shapes::goblet(), tolerance);
                     }});
  }
  return cases;
}

std::vector<NamedCase> scanned_cases(const Mesher& mesher) {
  constexpr std::int32_t kSamples = 18'750;
  std::vector<NamedCase> cases;
  const auto add_arm = [&](const std::string& name, const shapes::ScanOptions& options) {
    cases.push_back({name, [=] { return scanned_arm(mesher, name, options); }});
  };
  add_arm("arm, simplified scan", {});
  add_arm("arm, simplified scan, paired", {.pair_quads = true});
  add_arm("arm, simplified, 15 degrees", {.least_angle = 15});
  add_arm("arm, even spacing",
          {.sampling = Sampling::PoissonDisk, .point_count = kSamples, .tolerance = 0});
  add_arm("arm, uniformly random", {.point_count = kSamples, .tolerance = 0});
  for (const auto& [name, make] :
       {std::pair<std::string, PolygonMesh (*)()>{"bust, simplified scan", shapes::bust},
        {"goblet, simplified scan", shapes::goblet}}) {
    cases.push_back(
        {name, [mesher, name = name, make = make] { return scanned_shape(mesher, name, make()); }});
  }
  return cases;
}

std::vector<NamedCase> file_cases() {
  std::vector<NamedCase> cases;
  const char* folder = std::getenv("PLANISH_TEST_DATA");
  if (folder == nullptr) return cases;
  for (const char* name : {"rocker-arm.obj", "spot.obj", "suzanne.obj"}) {
    cases.push_back(
        {name, [path = std::filesystem::path(folder) / name] { return of_file(path); }});
  }
  return cases;
}

}  // namespace planish::quality
