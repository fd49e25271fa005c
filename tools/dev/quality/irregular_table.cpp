#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "make_scenes/models.h"
#include "make_scenes/sample_points.h"
#include "make_scenes/shapes.h"
#include "planish/core/parallel.h"
#include "planish/files/mesh_file.h"
#include "planish/mend/repair.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/statistics.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/surface_blocks.h"
#include "quality/figures.h"
#include "quality/tables.h"
#include "quality/wild_shapes.h"

namespace planish::quality {
namespace {

constexpr bool kHeldOut = true;

// A closed shape around the origin: its distance from there by direction.
using Radius = std::function<double(const glm::dvec3&)>;

Radius ellipsoid(const glm::dvec3& axes) {
  return [axes](const glm::dvec3& d) { return 1 / glm::length(d / axes); };
}

double bumps(const glm::dvec3& d) { return 1 + 0.15 * std::sin(4 * d.x) * std::cos(3 * d.y + d.z); }

double fine_bumps(const glm::dvec3& d) {
  return 1 + 0.08 * std::sin(6 * d.x + 1) * std::sin(5 * d.y) * std::cos(4 * d.z);
}

// |x|^4 + |y|^4 + |z|^4 = 1.
double superquadric(const glm::dvec3& d) {
  const glm::dvec3 square = d * d;
  return 1 / std::sqrt(std::sqrt(glm::dot(square, square)));
}

// Two balls grown together.
double peanut(const glm::dvec3& d) { return 0.55 + 0.45 * d.x * d.x; }

// At random directions; `noise`: the radius is off by as much, deviation of a normal law, relative.
Case star(const Radius& radius, std::int32_t count, std::uint32_t seed, double noise = 0) {
  Case made;
  shapes::RandomNumbers random(seed + 1000);
  made.mesh = hull_of_directions(count, seed, [&](const glm::dvec3& d) {
    double sum = 0;  // of twelve even numbers: nearly normal, of deviation 1
    for (int i = 0; i < 12; ++i) sum += random.unit() - 0.5;
    return radius(d) * (1 + noise * sum) * d;
  });
  made.truth = true_zero_set([radius](const glm::dvec3& p) {
    const double length = glm::length(p);
    return length - radius(p / length);
  });
  return made;
}

// An ellipsoid's random points are even on the ball that it is stretched from.
Case stretched(const glm::dvec3& axes, std::int32_t count, std::uint32_t seed) {
  Case made;
  made.mesh = hull_of_directions(count, seed, [&](const glm::dvec3& d) { return axes * d; });
  made.truth = true_zero_set([axes](const glm::dvec3& p) {
    // About the distance.
    const glm::dvec3 scaled = p / axes;
    return (glm::length(scaled) - 1) * glm::length(scaled) / glm::length(scaled / axes);
  });
  return made;
}

using Height = std::function<double(double, double)>;

// Over the disc, which is stretched along x; open.
Case sheet(const Height& height, std::int32_t count, std::uint32_t seed, double stretch = 1) {
  Case made;
  const std::int32_t rim = static_cast<std::int32_t>(2 * std::sqrt(std::numbers::pi * count));
  made.mesh = sheet_over_disc(count, rim, seed, [&](const glm::dvec2& p) {
    const double x = stretch * p.x;
    return glm::dvec3(x, p.y, height(x, p.y));
  });
  made.truth = true_zero_set([height](const glm::dvec3& p) { return p.z - height(p.x, p.y); });
  return made;
}

Case ring(std::int32_t count, std::uint32_t seed, double tube_radius) {
  return {"", uneven_torus(count, seed, 1, tube_radius), true_torus(1, tube_radius)};
}

Case simplified_ring(double tube_radius, double tolerance) {
  const shapes::TorusOptions options{
      .ring_count = 300, .tube_count = 120, .radius = 1, .tube_radius = tube_radius};
  return {"", simplified_within(shapes::torus(options), tolerance), true_torus(1, tube_radius)};
}

// The dense mesh is the shape. `noise`: fraction of the diagonal by which what was simplified is
// off it.
Case simplified_scan(PolygonMesh dense, double tolerance, double noise = 0) {
  Case made;
  made.truth = true_mesh(dense);
  if (noise > 0) shapes::add_noise(dense.positions, noise * placement_of(dense).diagonal, 9);
  made.mesh = simplified_within(dense, tolerance);
  made.is_scan = true;
  return made;
}

PolygonMesh dense_bumps() {
  PolygonMesh mesh = shapes::icosphere(5);
  for (glm::dvec3& p : mesh.positions) p *= fine_bumps(p);
  return mesh;
}

}  // namespace

std::vector<NamedCase> irregular_cases() {
  std::vector<NamedCase> cases;
  const auto add = [&](const std::string& name, bool is_held_out,
                       const std::function<Case()>& make) {
    cases.push_back({name, [=] {
                       Case made = make();
                       made.name = name;
                       made.is_held_out = is_held_out;
                       return made;
                     }});
  };
  const Radius ball = ellipsoid(glm::dvec3(1));
  add("ball, 400", !kHeldOut, [=] { return star(ball, 400, 31); });
  add("ball, 1500", kHeldOut, [=] { return star(ball, 1500, 32); });
  add("egg, 2 : 1 : 0.6", !kHeldOut, [] { return stretched({2, 1, 0.6}, 600, 33); });
  add("egg, 1.5 : 1 : 1", kHeldOut, [] { return stretched({1.5, 1, 1}, 500, 34); });
  add("bumpy, 1500", !kHeldOut, [] { return star(bumps, 1500, 35); });
  add("bumpy, 4000", kHeldOut, [] { return star(fine_bumps, 4000, 36); });
  add("saddle, open", !kHeldOut,
      [] { return sheet([](double x, double y) { return 0.5 * (x * x - y * y); }, 500, 37); });
  add("monkey saddle, open", kHeldOut, [] {
    return sheet([](double x, double y) { return 0.4 * x * (x * x - 3 * y * y); }, 700, 38);
  });
  add("wave, open", kHeldOut, [] {
    return sheet([](double x, double y) { return 0.1 * std::sin(4 * x) * std::cos(3 * y); }, 900,
                 39);
  });
  add("torus, Delaunay", !kHeldOut, [] { return ring(600, 40, 0.4); });
  add("torus, simplified", kHeldOut, [] { return simplified_ring(0.4, 2e-3); });
  add("thin ring", kHeldOut, [] { return ring(900, 41, 0.1); });
  add("pancake, 1 : 1 : 0.12", !kHeldOut, [] { return stretched({1, 1, 0.12}, 1200, 42); });
  add("peanut", kHeldOut, [] { return star(peanut, 800, 43); });
  add("superquadric", kHeldOut, [] { return star(superquadric, 1000, 44); });
  add("needle, 5 : 1 : 1", !kHeldOut, [] { return stretched({5, 1, 1}, 1000, 45); });
  add("vault, 5 : 1, open", !kHeldOut, [] {
    return sheet([](double x, double y) { return 0.3 * std::cos(0.8 * x) - 0.4 * y * y; }, 600, 46,
                 5);
  });
  add("roof, 5 : 1 across, open", kHeldOut, [] {
    return sheet([](double x, double y) { return 0.4 * std::sin(1.2 * x) + 0.1 * y * y; }, 700, 47,
                 5);
  });
  add("ball, noise 0.2 %", !kHeldOut, [=] { return star(ball, 1500, 48, 2e-3); });
  add("bumpy, noise 0.1 %", kHeldOut, [] { return star(bumps, 2000, 49, 1e-3); });

  add("arm, simplified 1e-3", !kHeldOut,
      [] { return simplified_scan(shapes::rocker_arm(), 1e-3); });
  add("arm, noisy, simplified 2e-3", kHeldOut,
      [] { return simplified_scan(shapes::rocker_arm(), 2e-3, 2e-4); });
  add("bust, simplified 5e-4", !kHeldOut, [] { return simplified_scan(shapes::bust(), 5e-4); });
  add("bust, simplified 2e-3", kHeldOut, [] { return simplified_scan(shapes::bust(), 2e-3); });
  add("goblet, simplified 1e-3", kHeldOut, [] { return simplified_scan(shapes::goblet(), 1e-3); });
  add("knot, simplified 3e-3", !kHeldOut, [] { return simplified_scan(knot(500, 48), 3e-3); });
  add("knot, simplified 1e-3", kHeldOut, [] { return simplified_scan(knot(500, 48), 1e-3); });
  add("bumps, simplified 1e-3", !kHeldOut, [] { return simplified_scan(dense_bumps(), 1e-3); });
  return cases;
}

NamedCase simplified_file(const std::filesystem::path& path) {
  constexpr double kTolerance = 1e-3;
  const std::string name = path.filename().string();
  return {name, [=] {
            Case made = simplified_scan(repair(read_mesh(path).mesh).mesh, kTolerance);
            made.name = name;
            return made;
          }};
}

namespace {

// How the facets that a file holds follow a shape, by area. Lengths are in the mesh's unit, angles
// in degrees.
struct FacetFigures {
  std::int64_t facets = 0;
  // Of each facet's normal and centre, root of the mean square.
  double normals = 0, distance = 0;
  double folded = 0;   // share of the area that turns by more than 90 degrees from the shape
  double turning = 0;  // share of the edges' length at which facets turn by more than 5 degrees
};

// Of a mesh of triangles.
FacetFigures facet_figures(const PolygonMesh& mesh, const Truth& truth) {
  constexpr double kTurn = 5, kFold = 90;
  FacetFigures figures;
  figures.facets = mesh.face_count();
  const auto count = static_cast<std::size_t>(figures.facets);
  std::vector<glm::dvec3> normals(count);  // twice the area long
  std::vector<double> angles(count), squares(count);
  parallel_each(count, 256, [&](std::size_t f) {
    const auto v = mesh.face(static_cast<std::int32_t>(f));
    const glm::dvec3 &a = mesh.positions[v[0]], &b = mesh.positions[v[1]],
                     &c = mesh.positions[v[2]];
    normals[f] = glm::cross(b - a, c - a);
    const glm::dvec3 centre = (a + b + c) / 3.0;
    const Foot foot = truth(centre);
    angles[f] = glm::degrees(angle_between(normals[f], foot.normal));
    squares[f] = glm::dot(centre - foot.point, centre - foot.point);
  });
  double area = 0;
  for (std::size_t f = 0; f < count; ++f) {
    const double size = glm::length(normals[f]);
    if (!(size > 0)) continue;
    area += size;
    figures.normals += size * angles[f] * angles[f];
    figures.distance += size * squares[f];
    if (angles[f] > kFold) figures.folded += size;
  }
  figures.normals = std::sqrt(figures.normals / area);
  figures.distance = std::sqrt(figures.distance / area);
  figures.folded /= area;

  std::vector<Triangle> triangles(count);
  for (std::size_t f = 0; f < count; ++f) {
    const auto v = mesh.face(static_cast<std::int32_t>(f));
    triangles[f] = {v[0], v[1], v[2]};
  }
  const std::vector<std::int32_t> twins = twins_of(triangles, mesh.positions.size());
  double length = 0;
  for (std::int32_t h = 0; h < std::ssize(twins); ++h) {
    const std::int32_t twin = twins[h];
    if (twin < h) continue;
    const glm::dvec3 &m = normals[h / 3], &n = normals[twin / 3];
    if (glm::dot(m, m) == 0 || glm::dot(n, n) == 0) continue;
    const Triangle& t = triangles[h / 3];
    const double part = glm::distance(mesh.positions[t[h % 3]], mesh.positions[t[(h + 1) % 3]]);
    length += part;
    if (glm::degrees(angle_between(m, n)) > kTurn) figures.turning += part;
  }
  if (length > 0) figures.turning /= length;
  return figures;
}

// A surface's faces cut into triangles, as files hold them.
PolygonMesh facets_of(const SurfaceMesh& surface) {
  PolygonMesh mesh;
  mesh.positions.assign(surface.positions.begin(), surface.positions.end());
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto v = surface.face(f);
    if (v.size() == 3) {
      mesh.add_face(v);
      continue;
    }
    const auto p = [&](std::size_t i) { return mesh.positions[v[i]]; };
    const auto cut = split_quad(p(0), p(1), p(2), p(3));
    for (const std::size_t first : {0, 3})
      mesh.add_face(std::array{v[cut[first]], v[cut[first + 1]], v[cut[first + 2]]});
  }
  return mesh;
}

// Facets that a peer put between the vertices of a mesh.
struct PeerSurface {
  PolygonMesh facets;
  double milliseconds = 0;  // without reading and writing files
};

namespace fs = std::filesystem;

class WorkFolder {
 public:
  WorkFolder() {
    std::string name = (fs::temp_directory_path() / "planish-quality-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  [[nodiscard]] fs::path file(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

// What node says on its output goes into a file.
void run_node(std::vector<std::string> words, const fs::path& said) {
  words.insert(words.begin(), "node");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, said.c_str(), O_WRONLY | O_CREAT, 0600);
  pid_t child = 0;
  const int failed =
      ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (failed != 0) throw std::runtime_error("--manifold needs node, which is not installed");
  if (::waitpid(child, &status, 0) != child || status != 0)
    throw std::runtime_error("manifold-3d failed; is it in the folder (npm install manifold-3d)?");
}

// manifold-3d's surface through all vertices of a closed mesh of triangles: smoothOut(180, 0) and
// refine(n), n^2 facets a triangle, run by node. `folder`: where npm installed manifold-3d. Empty
// where the mesh has a boundary, which it does not take. Throws std::runtime_error where node or
// the package is missing.
std::optional<PeerSurface> smoothed_by_manifold(const PolygonMesh& mesh, int n,
                                                const fs::path& folder) {
  if (statistics(mesh).boundary_loop_count > 0) return std::nullopt;
  const WorkFolder work;
  const fs::path given = work.file("given.obj"), made = work.file("made.obj"),
                 said = work.file("said.txt");
  write_mesh(given, FileFormat::Obj, mesh);
  run_node({PLANISH_QUALITY_SOURCES "/manifold_smooth.mjs", folder.string(), given.string(),
            std::to_string(n), made.string()},
           said);
  PeerSurface surface;
  surface.facets = read_mesh(made).mesh;
  std::ifstream(said) >> surface.milliseconds;
  return surface;
}

// Of the flat triangles', so much is left at most.
constexpr double kOfFlatNormals = 0.5;
// Of manifold's.
constexpr double kOfManifoldNormals = 0.9;

struct Measured {
  FacetFigures figures;
  double milliseconds = 0;
};

Measured by_planish(const Case& what, int more_levels, Backend& backend) {
  Measured measured;
  const auto start = std::chrono::steady_clock::now();
  const FittedMesh fitted = fit_mesh(what.mesh, what.name, backend);
  const SurfaceMesh surface =
      evaluate(fitted.mesh, fitted.fit, backend,
               fitted.evaluate_options(fitted.density.level() + more_levels));
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  measured.milliseconds = took.count();
  measured.figures = facet_figures(facets_of(surface), what.truth);
  return measured;
}

std::optional<Measured> by_manifold(const Case& what, std::int64_t facets,
                                    const std::filesystem::path& folder) {
  if (folder.empty()) return std::nullopt;
  const double share = static_cast<double>(facets) / what.mesh.face_count();
  const int n = std::max(1, static_cast<int>(std::lround(std::sqrt(share))));
  const std::optional<PeerSurface> made = smoothed_by_manifold(what.mesh, n, folder);
  if (!made) return std::nullopt;
  return Measured{facet_figures(made->facets, what.truth), made->milliseconds};
}

void print(const FacetFigures& f, double diagonal) {
  std::printf(" %.2f, %.1e, %.2f |", f.normals, f.distance / diagonal, 100 * f.turning);
}

void print(const Measured& m, double diagonal) {
  std::printf(" %.2f, %.1e, %.2f; %.4f; %lld; %.0f |", m.figures.normals,
              m.figures.distance / diagonal, 100 * m.figures.turning, 100 * m.figures.folded,
              static_cast<long long>(m.figures.facets), m.milliseconds);
}

// What is worse than the peer.
std::string behind(const FacetFigures& own, const FacetFigures& peer) {
  std::string text;
  const auto note = [&](bool is_behind, const char* name) {
    if (is_behind) text += (text.empty() ? "" : ", ") + std::string(name);
  };
  note(own.normals > kOfManifoldNormals * peer.normals, "normals");
  note(own.distance > peer.distance, "distance");
  note(own.turning > peer.turning, "turning");
  note(own.folded > peer.folded, "folds");
  return text;
}

}  // namespace

std::vector<std::string> print_irregular_table(const std::vector<NamedCase>& cases,
                                               const IrregularOptions& options) {
  std::printf(
      "| shape (triangles) | flat: normals, distance, turning %% | planish: the same; folded %%; "
      "facets; ms | manifold | of flat | of manifold | behind |\n|---|--:|--:|--:|--:|--:|---|\n");
  const auto backend = make_cpu_backend();
  std::vector<std::string> wrong;
  for (const NamedCase& named : cases) {
    const Case made = named.make();
    const double diagonal = placement_of(made.mesh).diagonal;
    const FacetFigures flat = facet_figures(made.mesh, made.truth);
    const Measured own = by_planish(made, options.more_levels, *backend);
    const std::optional<Measured> peer = by_manifold(made, own.figures.facets, options.manifold);
    std::printf("| %s%s (%d) |", made.name.c_str(), made.is_held_out ? "*" : "",
                made.mesh.face_count());
    print(flat, diagonal);
    print(own, diagonal);
    if (peer) {
      print(*peer, diagonal);
    } else {
      std::printf(" - |");
    }
    std::printf(" %.2f |", own.figures.normals / flat.normals);
    if (peer) {
      std::printf(" %.2f | %s |\n", own.figures.normals / peer->figures.normals,
                  behind(own.figures, peer->figures).c_str());
    } else {
      std::printf(" - | |\n");
    }
    std::fflush(stdout);
    const auto require = [&](const char* figure, double value, double limit) {
      if (!(value <= limit)) wrong.push_back(shortfall(made, figure, value, limit));
    };
    require("normals", own.figures.normals, kOfFlatNormals * flat.normals);
    require("distance", own.figures.distance, flat.distance);
    require("folded area", own.figures.folded, flat.folded);
    require("turning", own.figures.turning, flat.turning);
  }
  return wrong;
}

}  // namespace planish::quality
