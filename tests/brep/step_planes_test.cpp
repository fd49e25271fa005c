// Planes of written files, parsed by a reader of its own: of faces with corners of half a turn, of
// outlines of any shape, turned anyhow.
#include <gmock/gmock.h>

#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "brep/step_cases.h"
#include "brep/step_checks.h"
#include "planish/brep/subdivision_splines.h"
#include "planish/queries/surface_queries.h"
#include "support/expect_error.h"
#include "support/temporary_folder.h"

namespace planish::test {
namespace {

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
