#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <set>
#include <utility>

#include "brep/step_checks.h"
#include "planish/brep/brep.h"
#include "planish/brep/subdivision_splines.h"
#include "planish/pipeline/write_fitted_step.h"
#include "planish/queries/surface_queries.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish::test {
namespace {

// Whether shells are valid, told of what was damaged by hand.

TEST(CheckBrep, WhatIsMadeIsValid) {
  for (const auto& [name, mesh] : std::vector<NamedMesh>{{"icosphere", icosphere(1)},
                                                         {"cube", creased_cube(true)},
                                                         {"plate", plate_with_hole(5)},
                                                         {"torus", torus(9, 7, 3, 1)},
                                                         {"hub", bipyramid(9)},
                                                         {"closed", random_closed_mesh(4)},
                                                         {"open", random_open_mesh(6)}}) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    const CatmullClarkSplines cubic(mesh, {});
    const std::array<BrepCheck, 2> checks{
        check_brep(make_brep(c.limit), c.surface->placement().diagonal),
        check_brep(make_brep(cubic), cubic.placement().diagonal)};
    for (const BrepCheck& check : checks) {
      EXPECT_TRUE(check.is_valid());
      EXPECT_EQ(check.broken_loops, 0);
      EXPECT_EQ(check.unmatched_edges, 0);
      EXPECT_LE(check.largest_gap, 3e-9);  // planes are within 1e-9 of the points
    }
  }
}

class DamagedBrep : public testing::Test {
 protected:
  template <class Damage>
  [[nodiscard]] BrepCheck after(const Damage& damage) const {
    Brep brep = sound_;
    damage(brep);
    return check_brep(brep, diagonal_);
  }

  const LimitCase case_{icosphere(1)};
  const double diagonal_ = case_.surface->placement().diagonal;
  const Brep sound_ = make_brep(case_.limit);
};

TEST_F(DamagedBrep, LoopsThatDoNotCloseOrRunTheWrongWayAreCounted) {
  BrepCheck check = after([](Brep& b) { b.faces[5].loop.pop_back(); });
  EXPECT_EQ(check.broken_loops, 1);
  EXPECT_EQ(check.unmatched_edges, 1);
  check = after([](Brep& b) { std::swap(b.faces[5].loop[0], b.faces[5].loop[1]); });
  EXPECT_EQ(check.broken_loops, 1);
  EXPECT_EQ(check.unmatched_edges, 0);
  check = after([](Brep& b) { b.faces[5].loop[2].is_reversed ^= true; });
  EXPECT_GE(check.broken_loops, 1);
  EXPECT_EQ(check.unmatched_edges, 1);
  EXPECT_FALSE(check.is_valid());
  // Loops that fit one another but not the parameters: a face that is larger than they enclose.
  check = after([](Brep& b) { b.faces[5].knots_u.back() += 1; });
  EXPECT_EQ(check.broken_loops, 1);
}

TEST_F(DamagedBrep, AnEdgeOfOneFaceThatHasTwoIsNotShared) {
  const BrepCheck check = after([](Brep& b) { b.edges[7].lines[1].face = -1; });
  EXPECT_EQ(check.unmatched_edges, 1);
  EXPECT_FALSE(check.is_valid());
}

TEST_F(DamagedBrep, GapsAreBoundedAndNamed) {
  const auto moved = [&](double by) {
    return after([&](Brep& b) {
      b.edges[9].points[1].x += by * diagonal_;  // between its ends
    });
  };
  // A control point moves the curve by less than itself, and a bound is at most 1.25 times that.
  const BrepCheck wide = moved(1e-3);
  EXPECT_GT(wide.largest_gap, 1e-4);
  EXPECT_LE(wide.largest_gap, 1.25e-3);
  EXPECT_LE(glm::length(wide.largest_gap_at - sound_.edges[9].points[1]), 0.5);
  EXPECT_FALSE(wide.is_valid());
  EXPECT_TRUE(moved(1e-8).is_valid());
  EXPECT_GT(moved(1e-8).largest_gap, 1e-9);
  const BrepCheck off_vertex = after([&](Brep& b) { b.vertices[3].z += 2e-7 * diagonal_; });
  EXPECT_NEAR(off_vertex.largest_gap, 2e-7, 1e-12);
  EXPECT_FALSE(off_vertex.is_valid());
  EXPECT_FALSE(after([](Brep& b) {
                 b.faces[4].points[0].x = std::numeric_limits<double>::quiet_NaN();
               }).is_valid());
}

// Which commands' exit codes go by.
TEST(StepFigures, AskForValidShellsWhateverTheLimits) {
  StepFigures figures;
  EXPECT_TRUE(figures.is_as_asked());
  figures.keeps_limits = false;  // limits that nobody has set
  EXPECT_TRUE(figures.is_as_asked());
  figures.check.broken_loops = 1;
  EXPECT_FALSE(figures.is_as_asked());
  figures.check = {.largest_gap = 2 * Brep::kSamePlace};
  EXPECT_FALSE(figures.is_as_asked());
  figures.check = {};
  figures.keeps_wishes = false;
  EXPECT_FALSE(figures.is_as_asked());
}

TEST_F(DamagedBrep, PlanesAreHeldAgainstTheirEdges) {
  const LimitCase flat(creased_cube(true));
  Brep brep = make_brep(flat.limit);
  const double diagonal = flat.surface->placement().diagonal;
  ASSERT_TRUE(check_brep(brep, diagonal).is_valid());
  const auto face =
      std::ranges::find_if(brep.faces, [](const auto& f) { return f.plane.has_value(); });
  ASSERT_NE(face, brep.faces.end());
  face->plane->normal = glm::normalize(face->plane->normal + 0.01 * face->plane->along);
  const BrepCheck check = check_brep(brep, diagonal);
  EXPECT_GT(check.largest_gap, 1e-4);
  EXPECT_FALSE(check.is_valid());
}

double largest_size(const Brep& brep) {
  double size = 0;
  for (const glm::dvec3& p : brep.vertices) size = std::max(size, glm::length(p));
  return size;
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
              euler_number(c.limit.topology(), c.limit.surface().hidden()));
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

// Of surfaces that leave the given vertices by so much: the file is that surface, and as far off.
TEST(Step, SurfacesWithinATolerancePassVerticesByNoMore) {
  const PolygonMesh mesh = jittered(torus(24, 16, 3, 1), 0.1, 4);
  const auto backend = make_cpu_backend();
  constexpr double kWithin = 0.005;  // of the diagonal
  for (const InterpolationMethod method :
       {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    MeshFitOptions how;
    how.method = method;
    how.fit.within = kWithin;
    const FittedMesh fitted = fit_mesh(mesh, "noisy", *backend, how);
    ASSERT_TRUE(fitted.fit.within);
    const double diagonal = fitted.fit.placement.diagonal;
    const StepFigures figures = write_fitted_step(scratch("within.step"), fitted, {});
    EXPECT_EQ(figures.solids, 1);
    EXPECT_TRUE(figures.keeps_limits);
    EXPECT_LE(figures.largest_distance, 2e-6 * diagonal);
    const StepFile file(scratch("within.step"));
    expect_joined(file, 1e-12 * diagonal, 1e-9 * diagonal, 0);
    const LimitSurface limit(fitted_surface(fitted.mesh, fitted.fit, fitted.evaluate_options()));
    const Distances off = distances_from(SurfaceQueries(limit), file, 1, diagonal);
    EXPECT_LE(std::max(off.inner, off.outer), 1.5 * figures.max_deviation + 1e-11);
    // By the faces of the B-rep, against the given vertices.
    const Brep brep = make_brep(limit);
    double largest = 0;
    for (std::size_t v = 0; v < brep.places.size(); ++v) {
      const Brep::Place& place = brep.places[v];
      const glm::dvec3 there = point_of(brep, brep.faces[place.face], place.at);
      largest = std::max(largest, glm::length(there - mesh.positions[v]) / diagonal);
    }
    EXPECT_LE(largest, kWithin + 2e-6);
    EXPECT_GE(largest, 0.9 * kWithin);
  }
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
  // Around hubs of twelve they spare halvings: a third more points where they go astray.
  std::size_t points = 0;
  for (const Brep::Face& face :
       make_brep(LimitCase(bipyramid(12)).limit, {.angle = 1, .deviation = 1e-4}).faces)
    points += face.points.size();
  EXPECT_LT(points, 2600u);  // 2,304
  // A pentagon's centre has no edge that is sharp; of the corners of a cube all have.
  EXPECT_EQ(make_brep(LimitCase(creased_cube(true)).limit, {.angle = 1e-3}).moved, 0);
}

TEST(Step, NormalsAgreeAcrossSmoothEdges) {
  for (const PolygonMesh& mesh : {cube(), torus(7, 5, 3, 1), icosphere(1), prism(5)}) {
    const LimitCase c(mesh);
    const Brep brep = make_brep(c.limit, {});
    EXPECT_LE(brep.max_angle, 0.25);
    const StepFile file = written(c, brep, scratch("angles.step"));
    EXPECT_LE(worst_jump(file), 0.26);
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

// `scale` below 0 turns it inside out.
void add_scaled(PolygonMesh& to, const PolygonMesh& mesh, double scale, const glm::dvec3& by) {
  const auto first = static_cast<std::int32_t>(to.positions.size());
  for (const glm::dvec3& p : mesh.positions) to.positions.push_back(scale * p + by);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    for (const std::int32_t v : mesh.face(f)) to.face_vertices.push_back(first + v);
    to.face_offsets.push_back(static_cast<std::int32_t>(to.face_vertices.size()));
  }
}

TEST(Step, PartsInsideOutWithinOthersAreVoids) {
  PolygonMesh mesh;
  add_scaled(mesh, icosphere(1), -0.5, {});  // a void of the next one
  add_scaled(mesh, icosphere(1), 1, {});
  add_scaled(mesh, icosphere(1), 0.2, {0.1, 0, 0});  // a part in the void
  add_scaled(mesh, icosphere(1), 10, {});            // around all of them
  add_scaled(mesh, icosphere(1), 1, {30, 0, 0});     // by itself
  add_scaled(mesh, icosphere(1), -1, {-30, 0, 0});   // inside out, in nothing
  const LimitCase c(mesh);
  const Brep brep = make_brep(c.limit, {.angle = 5, .deviation = 1e-3});
  std::vector<std::int32_t> outer;
  std::vector<bool> inside_out;
  for (const Brep::Shell& shell : brep.shells) {
    outer.push_back(shell.outer);
    inside_out.push_back(shell.is_inside_out);
  }
  EXPECT_EQ(outer, (std::vector<std::int32_t>{1, -1, -1, -1, -1, -1}));
  EXPECT_EQ(inside_out, (std::vector<bool>{true, false, false, false, false, true}));
  const StepFile file = written(c, brep, scratch("voids.step"));
  EXPECT_EQ(file.all("CLOSED_SHELL").size(), 6u);
  EXPECT_EQ(file.all("MANIFOLD_SOLID_BREP").size(), 4u);
  ASSERT_EQ(file.all("BREP_WITH_VOIDS").size(), 1u);
  const auto& solid = file.at(file.all("BREP_WITH_VOIDS").front()).values;
  EXPECT_EQ(solid[1].reference, file.all("CLOSED_SHELL")[1]);
  ASSERT_EQ(solid[2].items.size(), 1u);
  const auto& hollow = file.at(solid[2].items.front()).values;
  EXPECT_EQ(hollow[2].reference, file.all("CLOSED_SHELL")[0]);
  EXPECT_EQ(hollow[3].text, ".T.");
}

TEST(Step, FlatFacesArePlanes) {
  const glm::dvec3 x = glm::normalize(glm::dvec3(3, 1, -2)),
                   y = glm::normalize(glm::cross(x, glm::dvec3(0, 1, 0))), z = glm::cross(x, y);
  for (const bool all_around : {false, true}) {
    PolygonMesh mesh = creased_cube(all_around);
    for (glm::dvec3& p : mesh.positions) p = p.x * x + p.y * y + p.z * z;
    const LimitCase c(mesh);
    const StepFile file = written(c, make_brep(c.limit, {}), scratch("flat.step"));
    const auto planes = file.all("PLANE");
    EXPECT_EQ(planes.size(), all_around ? 6u : 1u);
    EXPECT_EQ(file.all("B_SPLINE_SURFACE_WITH_KNOTS").size(), all_around ? 0u : 5u);
    for (const std::int64_t id : planes) {
      const StepFile::Plane plane = file.plane(id);
      EXPECT_NEAR(glm::dot(plane.origin, plane.normal), 1, 1e-12);  // outwards, one from the middle
      const double along_z = std::abs(glm::dot(plane.normal, z));
      EXPECT_TRUE(all_around || along_z > 1 - 1e-12);
    }
  }
  // What is flat and folded is no plane, and what is bent a little is none.
  PolygonMesh bent = flat_grid(2, 2);
  bent.positions[4].z = 1e-6;
  const LimitCase c(bent);
  EXPECT_TRUE(written(c, make_brep(c.limit), scratch("bent.step")).all("PLANE").empty());
}

TEST(Step, GroupsEndFacesAndNameAndColourThem) {
  const PolygonMesh mesh = torus(12, 8, 3, 1);
  const LimitCase c(mesh);
  std::vector<std::int32_t> groups(static_cast<std::size_t>(mesh.face_count()), 0);
  for (std::size_t f = 0; f < groups.size(); ++f) groups[f] = f % 96 < 30 ? 1 : 0;
  const Brep brep = make_brep(c.limit, {}, {}, groups);
  std::set<std::int32_t> seen;
  double area = 0;
  for (const Brep::Face& face : brep.faces) {
    seen.insert(face.group);
    if (face.group == 1) area += face.knots_u.back() * face.knots_v.back();
  }
  EXPECT_EQ(seen, (std::set<std::int32_t>{0, 1}));
  EXPECT_EQ(area, 4 * 30);
  const std::string path = scratch("groups.step");
  write_step(
      path, brep,
      {.name = "part", .diagonal = 8, .groups = {{"red's", glm::dvec3(1, 0, 0.5)}, {"plain", {}}}});
  const StepFile file(path);
  std::map<std::string, int> names;
  for (const std::int64_t id : file.all("ADVANCED_FACE"))
    ++names[std::string(file.at(id).values[0].text)];
  EXPECT_EQ(names.size(), 2u);
  EXPECT_GT(names["'plain'"], 0);
  const auto styled = file.all("STYLED_ITEM");
  EXPECT_EQ(std::ssize(styled), std::ranges::count(brep.faces, 0, &Brep::Face::group));
  for (const std::int64_t id : styled)
    EXPECT_EQ(file.at(file.at(id).values[2]).keyword, "ADVANCED_FACE");
  ASSERT_EQ(file.all("COLOUR_RGB").size(), 1u);
  const auto& color = file.at(file.all("COLOUR_RGB").front()).values;
  EXPECT_EQ(color[1].number(), 1);
  EXPECT_EQ(color[3].number(), 0.5);
  // A solid of one group is named and coloured whole.
  write_step(path, make_brep(c.limit), {.diagonal = 8, .groups = {{"all", glm::dvec3(1)}}});
  const StepFile whole(path);
  ASSERT_EQ(whole.all("STYLED_ITEM").size(), 1u);
  const auto& solid = whole.at(whole.at(whole.all("STYLED_ITEM").front()).values[2]);
  EXPECT_EQ(solid.keyword, "MANIFOLD_SOLID_BREP");
  EXPECT_EQ(solid.values[0].text, "'all'");
}

// Points in space that several entities refer to stand once.
TEST(Step, PointsOfBordersStandOnce) {
  const LimitCase c(torus(7, 5, 3, 1));
  const StepFile file = written(c, make_brep(c.limit, {}), scratch("once.step"));
  std::set<std::vector<double>> points;
  for (const std::int64_t id : file.all("CARTESIAN_POINT")) {
    const auto& xyz = file.at(id).values[1].items;
    if (xyz.size() < 3) continue;
    std::vector<double> point;
    for (const Part21Value& value : xyz) point.push_back(value.number());
    EXPECT_TRUE(points.insert(point).second) << "#" << id;
  }
}

// Digits are counted from the diagonal: what is larger or far away has no more of them than doubles
// have, and what is small has as many as it needs.
TEST(Step, CoordinatesHaveTheDigitsThatTheDiagonalNeeds) {
  for (const double scale : {1e-9, 1.0, 3e5}) {
    for (const double away : {0.0, 1e6}) {
      PolygonMesh mesh = cube();
      for (glm::dvec3& p : mesh.positions) p = scale * (p + away);
      const LimitCase c(mesh);
      const double diagonal = c.surface->placement().diagonal;
      const Brep brep = make_brep(c.limit, {});
      const StepFile file = written(c, brep, scratch("digits.step"));
      const auto vertices = file.all("VERTEX_POINT");
      ASSERT_EQ(vertices.size(), brep.vertices.size());
      for (std::size_t v = 0; v < vertices.size(); ++v) {
        const Part21Value& point = file.at(vertices[v]).values[1];
        EXPECT_LE(glm::length(file.point(point) - brep.vertices[v]), 3e-13 * diagonal);
        for (const Part21Value& value : file.at(point).values[1].items)
          EXPECT_LE(value.text.size(), 22u) << value.text;
      }
      if (away == 0) {
        const std::string text = bytes_of(scratch("digits.step"));
        EXPECT_LT(text.size(), 140'000u);
      }
    }
  }
}

TEST(Step, FacesHaveAtMostTheSizeAskedFor) {
  const LimitCase c(torus(20, 12, 3, 1));
  for (const std::int32_t size : {1, 5, 16}) {
    for (const Brep::Face& face : make_brep(c.limit, {.face_size = size}).faces) {
      EXPECT_LE(face.knots_u.back(), size);
      EXPECT_LE(face.knots_v.back(), size);
    }
  }
  const std::string message =
      message_of(ErrorCode::InvalidArgument, [&] { (void)make_brep(c.limit, {.face_size = 0}); });
  EXPECT_NE(message.find("1 to 4096"), std::string::npos);
}

// Planes of written files, parsed by a reader of its own: of faces with corners of half a turn, of
// outlines of any shape, turned anyhow.

using Outline = std::vector<glm::dvec2>;

// All edges sharp: what is flat stays flat.
PolygonMesh sharp(PolygonMesh mesh) {
  const MeshTopology topology(mesh);
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto ends = topology.edge_vertices(e);
    mesh.creases.push_back({ends.first, ends.second});
  }
  return mesh;
}

// A solid between two copies of an outline.
PolygonMesh extruded(const Outline& outline, double height) {
  const auto n = static_cast<std::int32_t>(outline.size());
  std::vector<glm::dvec3> points;
  for (const double z : {0.0, height})
    for (const glm::dvec2& p : outline) points.emplace_back(p, z);
  FaceList faces(2);
  for (std::int32_t i = 0; i < n; ++i) {
    faces[0].push_back(n - 1 - i);
    faces[1].push_back(n + i);
    const std::int32_t next = (i + 1) % n;
    faces.push_back({i, next, n + next, n + i});
  }
  return make_mesh(std::move(points), faces);
}

Outline regular(int n, double inner = 1) {
  Outline outline;
  for (int i = 0; i < n; ++i) {
    const double turn = 2 * std::numbers::pi * i / n, r = i % 2 == 0 ? 1 : inner;
    outline.emplace_back(r * std::cos(turn), r * std::sin(turn));
  }
  return outline;
}

// With further vertices on the edges, off them by rounding or a little more.
template <class Random>
Outline with_straight_corners(const Outline& outline, int most, double noise, Random& random) {
  std::uniform_int_distribution<int> count(0, most);
  std::uniform_real_distribution<double> within(0, 1), off(-noise, noise);
  Outline result;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const glm::dvec2 from = outline[i], to = outline[(i + 1) % outline.size()];
    result.push_back(from);
    std::vector<double> places(static_cast<std::size_t>(count(random)));
    for (double& place : places) place = 0.05 + 0.9 * within(random);
    std::ranges::sort(places);
    for (const double t : places)
      result.push_back(from + t * (to - from) + glm::dvec2(off(random), off(random)));
  }
  return result;
}

// Star-shaped about the middle.
template <class Random>
Outline any_outline(Random& random) {
  std::uniform_int_distribution<int> count(3, 9);
  std::uniform_real_distribution<double> radius(0.5, 1.5);
  Outline outline = regular(count(random));
  for (glm::dvec2& p : outline) p *= radius(random);
  return outline;
}

template <class Random>
void turn(PolygonMesh& mesh, Random& random) {
  std::normal_distribution<double> any(0, 1);
  const glm::dquat by =
      glm::normalize(glm::dquat(any(random), any(random), any(random), any(random)));
  const glm::dvec3 away(any(random), any(random), any(random));
  const double scale = std::exp(2 * any(random));
  for (glm::dvec3& p : mesh.positions) p = scale * (by * p + away);
}

// Each direction is finite and of unit length, placements have right angles, and around each plane
// the loop, whose edges are evaluated, is counter-clockwise and lies in it. Returns how many.
std::ptrdiff_t expect_sound_planes(const StepFile& file, double diagonal) {
  for (const std::int64_t id : file.all("DIRECTION")) {
    const glm::dvec3 d = file.point(Part21Value{{}, id, {}});
    EXPECT_NEAR(glm::length(d), 1, 1e-12) << "#" << id;
  }
  for (const std::int64_t id : file.all("AXIS2_PLACEMENT_3D")) {
    const auto& values = file.at(id).values;
    EXPECT_NEAR(glm::dot(file.point(values[2]), file.point(values[3])), 0, 1e-12) << "#" << id;
  }
  std::ptrdiff_t count = 0;
  for (const std::int64_t id : file.all("ADVANCED_FACE")) {
    const auto& face = file.at(id).values;
    if (file.at(face[2]).keyword != "PLANE") continue;
    ++count;
    const StepFile::Plane plane = file.plane(face[2].reference);
    std::vector<glm::dvec3> around;
    for (const Part21Value& use : file.at(file.at(face[1].items[0]).values[1]).values[1].items) {
      const auto& oriented = file.at(use).values;
      const StepFile::Curve curve = file.curve(curve_of(file, oriented[3].reference));
      for (int k = 0; k < 16; ++k) {
        const double part = (oriented[4].text == ".T." ? k : 16 - k) / 16.0;
        around.push_back(curve.at(curve.t.low() + part * (curve.t.high() - curve.t.low())));
      }
    }
    glm::dvec3 area(0.0);
    for (std::size_t i = 0; i < around.size(); ++i) {
      area += glm::cross(around[i] - around[0], around[(i + 1) % around.size()] - around[0]);
      EXPECT_LE(std::abs(glm::dot(around[i] - plane.origin, plane.normal)), 2e-9 * diagonal)
          << "#" << id;
    }
    EXPECT_GT(glm::dot(glm::normalize(area), plane.normal), 1 - 1e-6) << "#" << id;
  }
  return count;
}

template <class Random>
void expect_flat_faces(PolygonMesh mesh, Random& random) {
  turn(mesh, random);
  const PolygonMesh cage = sharp(mesh);
  const LimitCase c(cage);
  const double diagonal = c.surface->placement().diagonal;
  for (const bool is_cubic : {false, true}) {
    const Brep brep = is_cubic ? make_brep(CatmullClarkSplines(cage, {})) : make_brep(c.limit);
    // No jump is seen where none is.
    EXPECT_LE(brep.max_angle, 1e-3);
    write_step(scratch("planes.step"), brep, {.diagonal = diagonal});
    const StepFile file(scratch("planes.step"));
    EXPECT_EQ(expect_sound_planes(file, diagonal), std::ssize(brep.faces));
  }
}

TEST(StepPlanes, CornersOfHalfATurnLeaveThemAsTheyAre) {
  std::mt19937 random(5);
  expect_flat_faces(extruded({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}, 2),
                    random);
  // A hexagon with vertices in the middle of two edges, and the same by rounding noise.
  for (const double noise : {0.0, 1e-16, 1e-12})
    expect_flat_faces(extruded({{0, 0}, {1, 0}, {2, noise}, {2, 1}, {1, 1 - noise}, {0, 1}}, 0.5),
                      random);
}

TEST(StepPlanes, OfPrismsStarsAndAnyOutlines) {
  std::mt19937 random(11);
  for (const double noise : {0.0, 1e-15, 1e-13}) {
    for (int i = 0; i < 6; ++i) {
      SCOPED_TRACE(std::to_string(noise) + " " + std::to_string(i));
      for (const Outline& outline :
           {regular(3 + i), regular(2 * (i + 3), 0.6), any_outline(random)})
        expect_flat_faces(extruded(with_straight_corners(outline, 2, noise, random), 0.7), random);
    }
  }
}

TEST(StepPlanes, OfPlatesWithHoles) {
  std::mt19937 random(3);
  for (const PolygonMesh& plate : {plate_with_hole(5), l_shaped_plate(3), flat_grid(3, 2)}) {
    PolygonMesh mesh = plate;
    turn(mesh, random);
    const LimitCase c(mesh);
    const StepFile file = written(c, make_brep(c.limit), scratch("plates.step"));
    EXPECT_GT(expect_sound_planes(file, c.surface->placement().diagonal), 0);
  }
}

// Of places between those that are looked at, too: from the surface by closest points, and across
// edges by the file's own normals.
TEST(StepPlanes, FiguresHoldAtAnyPlace) {
  std::mt19937 random(7);
  for (const auto& [name, mesh] : std::vector<NamedMesh>{{"icosphere", icosphere(1)},
                                                         {"cube", cube()},
                                                         {"hub", bipyramid(9)},
                                                         {"closed", random_closed_mesh(4)},
                                                         {"open", random_open_mesh(6)}}) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const double diagonal = c.surface->placement().diagonal;
    for (const double limit : {1e-3, 1e-6}) {
      const Brep brep = make_brep(c.limit, {.angle = 90, .deviation = limit});
      EXPECT_LE(brep.max_deviation, limit);
      double farthest = 0;
      const std::size_t step = std::max<std::size_t>(1, brep.faces.size() / 24);
      for (std::size_t f = 0; f < brep.faces.size(); f += step) {
        const Brep::Face& face = brep.faces[f];
        std::uniform_real_distribution<double> within(0, 1);
        for (int k = 0; k < 40; ++k) {
          // Every other one near a corner, where the squares are.
          const double near = k % 2 == 0 ? 1 : std::min(1.0, std::ldexp(1.0, -brep.deepest + 1));
          glm::dvec2 at(near * within(random), near * within(random));
          if (k % 4 < 2) at.x = face.knots_u.back() - at.x;
          if (k % 8 < 4) at.y = face.knots_v.back() - at.y;
          at = glm::clamp(at, glm::dvec2(0), glm::dvec2(face.knots_u.back(), face.knots_v.back()));
          farthest = std::max(farthest, queries.closest(point_of(brep, face, at)).distance);
        }
      }
      EXPECT_LE(farthest / diagonal, brep.max_deviation + 1e-12);
      EXPECT_GE(farthest / diagonal, 0.1 * brep.max_deviation);
    }
    const Brep brep = make_brep(c.limit, {.angle = 1, .deviation = 1e-3});
    write_step(scratch("jumps.step"), brep, {.diagonal = diagonal});
    EXPECT_LE(worst_jump(StepFile(scratch("jumps.step"))), brep.max_angle + 1e-3);
  }
}

// Of a vertex between sharp edges the one side may be regular, where the surface is one polynomial,
// and the other not: the squares that meet there are looked at, not the whole polynomial.
TEST(StepPlanes, NoJumpIsSeenWhereTheSurfaceHasNone) {
  for (const int seed : {1, 2, 3, 4, 5, 6}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(static_cast<unsigned>(seed));
    std::normal_distribution<double> any(0, 1);
    PolygonMesh mesh = icosphere(1);
    const glm::dvec3 up(any(random), any(random), any(random));
    const MeshTopology topology(mesh);
    const auto is_above = [&](std::int32_t face) {
      glm::dvec3 sum(0.0);
      for (const std::int32_t v : topology.face(face)) sum += mesh.positions[v];
      return glm::dot(sum, up) > 0;
    };
    for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
      const std::int32_t other = topology.twin(c);
      if (other > c && is_above(topology.face_of(c)) != is_above(topology.face_of(other)))
        mesh.creases.push_back({topology.vertex_of(c), topology.vertex_of(topology.next(c))});
    }
    const LimitCase c(mesh);
    const Brep brep = make_brep(c.limit);
    EXPECT_LE(brep.max_angle, 0.25);
    EXPECT_LT(brep.deepest, 12);
  }
}

// Of triangles squares at the faces' centres leave half of what those at vertices do: where these
// are moved nothing is halved, else these alone.
TEST(StepPlanes, FacesAreNotHalvedForWhatTheirVerticesLeave) {
  const LimitCase c(icosphere(2));
  const double most = make_brep(c.limit, {.angle = 90, .deviation = 1}).max_deviation;
  const auto with = [&](double limit) {
    const Brep brep = make_brep(c.limit, {.angle = 90, .deviation = limit * most});
    EXPECT_LE(brep.max_deviation, limit * most);
    return brep;
  };
  EXPECT_EQ(with(0.7).deepest, 1);
  const Brep brep = with(0.6);
  EXPECT_EQ(brep.deepest, 2);
  for (const Brep::Face& face : brep.faces)
    for (const auto* knots : {&face.knots_u, &face.knots_v})
      EXPECT_EQ(std::max((*knots)[1] - knots->front(), knots->back() - (*knots)[knots->size() - 2]),
                0.5);
}

// What cannot be kept is told, with its place.
TEST(StepPlanes, JumpsThatAreThereAreFoundAndNamed) {
  const LimitCase c(bipyramid(12));
  const Brep brep = make_brep(c.limit, {.angle = 1e-7, .deviation = 1});
  EXPECT_EQ(brep.deepest, 12);
  EXPECT_GT(brep.max_angle, 1e-7);
  write_step(scratch("jump.step"), brep, {.diagonal = c.surface->placement().diagonal});
  EXPECT_GE(brep.max_angle_at.face, 0);
  EXPECT_LT(brep.max_angle_at.face, c.limit.topology().face_count());
  double nearest = 1;
  for (const glm::dvec3& p : brep.vertices)
    nearest = std::min(nearest, glm::length(p - brep.max_angle_at.position));
  EXPECT_LT(nearest, 1e-2);
}

TEST(StepPlanes, NumbersThatAreNotFiniteAreRefused) {
  const TemporaryFolder folder;
  const Brep sound = make_brep(LimitCase(creased_cube(true)).limit);
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               inf = std::numeric_limits<double>::infinity();
  const auto refusal = [&](const auto& spoil) {
    Brep brep = sound;
    StepOptions options;
    spoil(brep, options);
    const std::string message = message_of(
        ErrorCode::InvalidArgument, [&] { write_step(folder.path() / "p.step", brep, options); });
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
    return message;
  };
  EXPECT_EQ(refusal([&](Brep& b, StepOptions&) {
              b.vertices[3].y = nan;
            }).find("p.step: vertex 3 is not finite: ("),
            0u);
  const auto says = [](const char* text) { return testing::HasSubstr(text); };
  EXPECT_THAT(refusal([&](Brep& b, StepOptions&) { b.edges[2].points[1].x = inf; }),
              says("edge 2: control point 1 is not finite: (inf, "));
  EXPECT_THAT(refusal([&](Brep& b, StepOptions&) { b.edges[2].knots[1] = -inf; }),
              says("edge 2: knot 1 is not finite: -inf"));
  EXPECT_THAT(refusal([&](Brep& b, StepOptions&) { b.faces[4].points[5].z = nan; }),
              says("face 4: control point 5 is not finite"));
  EXPECT_THAT(refusal([&](Brep& b, StepOptions&) { b.faces[1].knots_v[0] = nan; }),
              says("face 1: knot 0 is not finite"));
  EXPECT_THAT(refusal([&](Brep& b, StepOptions&) { b.faces[1].plane->normal.x = nan; }),
              says("a direction of the plane of face 1 is not finite"));
  EXPECT_THAT(refusal([&](Brep&, StepOptions& o) {
                o.groups = {{"red", glm::dvec3(1, nan, 0)}};
              }),
              says("the colour of group 0 is not finite: (1, nan, 0)"));
  EXPECT_THAT(refusal([&](Brep&, StepOptions& o) { o.diagonal = inf; }),
              says("the diagonal is not finite: inf"));
}

}  // namespace
}  // namespace planish::test
