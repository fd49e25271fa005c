#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <numbers>
#include <set>

#include "brep/step_cases.h"
#include "planish/limit/surface_queries.h"

namespace planish::test {
namespace {

double largest_size(const Brep& brep) {
  double size = 0;
  for (const glm::dvec3& p : brep.vertices) size = std::max(size, glm::length(p));
  return size;
}

// Faces and edges of the mesh that are seen.
std::int64_t euler_number(const LimitSurface& limit) {
  const MeshTopology& topology = limit.topology();
  const auto hidden = limit.surface().hidden();
  std::set<std::int32_t> vertices, edges;
  std::int64_t faces = 0;
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    if (!hidden.empty() && hidden[static_cast<std::size_t>(f)] != 0) continue;
    ++faces;
    for (const std::int32_t v : topology.face(f)) vertices.insert(v);
    for (const std::int32_t e : topology.face_edges(f)) edges.insert(e);
  }
  return std::ssize(vertices) - std::ssize(edges) + faces;
}

// A curve on surfaces, or a curve alone where all of them are planes.
std::int64_t curve_of(const StepFile& file, std::int64_t edge) {
  const Part21Value& geometry = file.at(edge).values[3];
  return file.at(geometry).keyword == "SURFACE_CURVE" ? file.at(geometry).values[1].reference
                                                      : geometry.reference;
}
std::vector<Part21Value> surfaces_beside(const StepFile& file, std::int64_t edge) {
  const Part21Entity& geometry = file.at(file.at(edge).values[3]);
  return geometry.keyword == "SURFACE_CURVE" ? geometry.values[2].items
                                             : std::vector<Part21Value>{};
}

// Every edge lies on the surfaces of its faces at the parameters that its lines say, is used once
// each way, and ends at its vertices.
void expect_joined(const StepFile& file, double tolerance, double plane_tolerance,
                   std::int64_t border_count) {
  std::map<std::int64_t, int> forwards, backwards;
  for (const std::int64_t id : file.all("ORIENTED_EDGE"))
    ++(file.at(id).values[4].text == ".T." ? forwards : backwards)[file.at(id).values[3].reference];
  std::int64_t borders = 0;
  for (const std::int64_t id : file.all("EDGE_CURVE")) {
    const auto& edge = file.at(id).values;
    const StepFile::Curve curve = file.curve(curve_of(file, id));
    ASSERT_EQ(forwards[id], 1);
    ASSERT_LE(backwards[id], 1);
    if (backwards[id] == 0) ++borders;
    const std::vector<Part21Value> beside = surfaces_beside(file, id);
    if (!beside.empty()) {
      ASSERT_EQ(std::ssize(beside), 1 + backwards[id]);
    }
    ASSERT_LE(glm::length(file.point(file.at(edge[1]).values[1]) - curve.points.front()),
              tolerance);
    ASSERT_LE(glm::length(file.point(file.at(edge[2]).values[1]) - curve.points.back()), tolerance);
    for (const Part21Value& pcurve : beside) {
      if (file.at(pcurve).keyword == "PLANE") {
        const StepFile::Plane plane = file.plane(pcurve.reference);
        for (const glm::dvec3& p : curve.points)
          ASSERT_LE(std::abs(glm::dot(p - plane.origin, plane.normal)), plane_tolerance);
        continue;
      }
      const StepFile::PlaneLine line = file.plane_line(pcurve);
      const StepFile::Surface& surface = file.surface(line.surface);
      for (int k = 0; k <= 32; ++k) {
        const double t = curve.t.low() + k / 32.0 * (curve.t.high() - curve.t.low());
        const glm::dvec2 uv = line.from + t * line.direction;
        ASSERT_GE(uv.x, surface.u.low());
        ASSERT_LE(uv.x, surface.u.high());
        ASSERT_GE(uv.y, surface.v.low());
        ASSERT_LE(uv.y, surface.v.high());
        ASSERT_LE(glm::length(surface.at(uv.x, uv.y) - curve.at(t)), tolerance) << "#" << id;
      }
    }
  }
  EXPECT_EQ(borders, border_count);
}

// Loops run around [0, a] x [0, b] without a jump.
void expect_loops(const StepFile& file) {
  for (const std::int64_t id : file.all("EDGE_LOOP")) {
    const auto& uses = file.at(id).values[1].items;
    for (std::size_t i = 0; i < uses.size(); ++i) {
      const auto end = [&](std::size_t use, bool is_last) {
        const auto& oriented = file.at(uses[use % uses.size()]).values;
        const bool is_forward = oriented[4].text == ".T.";
        return file.at(oriented[3]).values[is_forward == is_last ? 2 : 1].reference;
      };
      ASSERT_EQ(end(i, true), end(i + 1, false)) << "#" << id;
    }
  }
}

std::vector<NamedMesh> step_meshes() {
  std::vector<NamedMesh> meshes = limit_meshes();
  meshes.push_back({"single triangle", single_polygon(3)});
  meshes.push_back({"300-gon drum", prism(300)});
  meshes.push_back({"hub of 100", bipyramid(100)});
  meshes.push_back({"valence 2", cube_with_split_edges()});
  meshes.push_back({"torus", torus(12, 8, 3, 1)});
  meshes.push_back({"small torus", torus(3, 3, 3, 1)});
  return meshes;
}

TEST(Step, FacesMeetAlongEdges) {
  for (const auto& [name, mesh] : step_meshes()) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    const Brep brep = make_brep(c.limit, {.angle = 2, .deviation = 1e-4});
    const StepFile file = written(c, brep, scratch("joined.step"));
    const auto border_count =
        std::ranges::count_if(brep.edges, [](const Brep::Edge& e) { return e.lines[1].face < 0; });
    // 15 digits of coordinates, which may be larger than the surface.
    const double size = std::max(c.surface->placement().diagonal, largest_size(brep));
    expect_joined(file, 1e-12 * size, 1e-9 * size, border_count);
    expect_loops(file);
    const auto count = [&](const char* keyword) { return std::ssize(file.all(keyword)); };
    EXPECT_EQ(count("VERTEX_POINT") - count("EDGE_CURVE") + count("ADVANCED_FACE"),
              euler_number(c.limit));
    EXPECT_EQ(count("OPEN_SHELL") > 0, border_count > 0);
    EXPECT_EQ(count("B_SPLINE_SURFACE_WITH_KNOTS") + count("PLANE"), count("ADVANCED_FACE"));
    EXPECT_EQ(count("CLOSED_SHELL"), count("MANIFOLD_SOLID_BREP"));
  }
}

// Of places of a file from the surface, of the diagonal: within `reach` of two borders, and others.
struct Distances {
  double inner = 0, outer = 0;
};
Distances distances_from(const SurfaceQueries& queries, const StepFile& file, double reach,
                         double diagonal) {
  Distances worst;
  std::mt19937 random(3);
  const auto surfaces = file.all("B_SPLINE_SURFACE_WITH_KNOTS");
  const std::size_t step = std::max<std::size_t>(1, surfaces.size() / 20);
  for (std::size_t f = 0; f < surfaces.size(); f += step) {
    const StepFile::Surface& surface = file.surface(surfaces[f]);
    std::uniform_real_distribution<double> x(surface.u.low(), surface.u.high()),
        y(surface.v.low(), surface.v.high());
    for (int k = 0; k < 12; ++k) {
      const double u = x(random), v = y(random);
      const double off = queries.closest(surface.at(u, v)).distance / diagonal;
      const auto is_end = [&](const KnotLine& line, double t) {
        return std::min(t - line.low(), line.high() - t) < reach;
      };
      double& of_kind = is_end(surface.u, u) && is_end(surface.v, v) ? worst.inner : worst.outer;
      of_kind = std::max(of_kind, off);
    }
  }
  return worst;
}

// Asked of the surface itself, by closest points. Squares at extraordinary points are at most half
// a quad, and where points beside them are moved a whole one.
TEST(Step, LiesOnTheSurfaceAndKeepsTheTolerance) {
  int moved = 0, unmoved = 0;
  for (const auto& [name, mesh] : step_meshes()) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    for (const double limit : {1.0, 1e-5}) {
      const Brep brep = make_brep(c.limit, {.angle = 90, .deviation = limit});
      const StepFile file = written(c, brep, scratch("places.step"));
      const Distances off =
          distances_from(queries, file, brep.moved > 0 ? 1 : 0.5, c.surface->placement().diagonal);
      EXPECT_LE(off.outer, 1e-12);
      EXPECT_LE(off.inner, brep.max_deviation * 1.5 + 1e-11);
      EXPECT_LE(brep.max_deviation, limit);
      ++(brep.moved > 0 ? moved : unmoved);
    }
  }
  EXPECT_GT(moved, 5);
  EXPECT_GT(unmoved, 15);
}

// Moves let squares be larger within the same limits, and only where all around is smooth.
TEST(Step, PointsBesideExtraordinaryOnesAreMovedWhereItHelps) {
  const LimitCase c(icosphere(2));
  const Brep brep = make_brep(c.limit, {.angle = 1, .deviation = 1e-4});
  EXPECT_GT(brep.moved, 0);
  EXPECT_LT(brep.moved, brep.extraordinary);
  // Each limit alone asks for no less.
  EXPECT_LE(brep.max_angle, 1);
  EXPECT_LE(brep.max_deviation, 1e-4);
  EXPECT_EQ(make_brep(c.limit, {.angle = 90, .deviation = 1}).moved, 0);
  // A pentagon's centre has no edge that is sharp; of the corners of a cube all have.
  EXPECT_EQ(make_brep(LimitCase(creased_cube(true)).limit, {.angle = 1e-3}).moved, 0);
}

// Of both sides of an edge, crowded at its ends where the kinks are, and measured by finite
// differences of the file's own surfaces.
TEST(Step, NormalsAgreeAcrossSmoothEdges) {
  for (const PolygonMesh& mesh : {cube(), torus(7, 5, 3, 1), icosphere(1), prism(5)}) {
    const LimitCase c(mesh);
    const Brep brep = make_brep(c.limit, {});
    EXPECT_LE(brep.max_angle, 0.25);
    const StepFile file = written(c, brep, scratch("angles.step"));
    double worst = 0;
    for (const std::int64_t id : file.all("SURFACE_CURVE")) {
      const auto& values = file.at(id).values;
      const StepFile::Curve curve = file.curve(values[1].reference);
      for (int k = 1; k < 40; ++k) {
        const double x = k / 40.0, near = 0.5 * std::pow(2 * std::min(x, 1 - x), 9);
        const double part = x < 0.5 ? near : 1 - near, t = part * curve.t.high();
        if (std::min(part, 1 - part) < 1e-6) continue;
        std::vector<glm::dvec3> normals;
        for (const Part21Value& pcurve : values[2].items) {
          if (file.at(pcurve).keyword == "PLANE") continue;
          const StepFile::PlaneLine line = file.plane_line(pcurve);
          const StepFile::Surface& surface = file.surface(line.surface);
          const glm::dvec2 uv = line.from + t * line.direction;
          const double h = 1e-7;
          const double x0 = std::max(surface.u.low(), uv.x - h),
                       x1 = std::min(surface.u.high(), uv.x + h);
          const double y0 = std::max(surface.v.low(), uv.y - h),
                       y1 = std::min(surface.v.high(), uv.y + h);
          normals.push_back(glm::normalize(
              glm::cross((surface.at(x1, uv.y) - surface.at(x0, uv.y)) / (x1 - x0),
                         (surface.at(uv.x, y1) - surface.at(uv.x, y0)) / (y1 - y0))));
        }
        if (normals.size() == 2) worst = std::max(worst, glm::length(normals[0] - normals[1]));
      }
    }
    EXPECT_LE(worst * 180 / std::numbers::pi, 0.26);
  }
}

TEST(Step, HasTheSameBytesOnEveryNumberOfThreads) {
  const LimitCase c(random_closed_mesh(7));
  std::array<std::string, 2> bytes;
  for (const std::size_t i : {0u, 1u}) {
    const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                              i == 0 ? 1 : 4);
    const std::string path = scratch("threads.step");
    const std::uint64_t size = write_step(path, make_brep(c.limit), {.name = "it's a \xc3\xa4"});
    bytes[i] = bytes_of(path);
    EXPECT_EQ(size, bytes[i].size());
  }
  EXPECT_EQ(bytes[0], bytes[1]);
  EXPECT_NE(bytes[0].find("PRODUCT('it''s a \\X4\\000000E4\\X0\\'"), std::string::npos);
}

}  // namespace
}  // namespace planish::test
