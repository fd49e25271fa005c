#include <gtest/gtest.h>

#include <set>

#include "brep/step_cases.h"
#include "support/expect_error.h"

namespace planish::test {
namespace {

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

}  // namespace
}  // namespace planish::test
