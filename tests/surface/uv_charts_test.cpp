#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <span>
#include <utility>

#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/level_faces.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

constexpr double kApart = 10;

SurfaceMesh cage_surface(const PolygonMesh& mesh, int level) {
  return evaluate(mesh, *make_cpu_backend(), {.level = level});
}

// Where the surface has the vertices of its cage.
std::vector<glm::dvec3> given_points(const PolygonMesh& mesh) {
  const SurfaceMesh surface = cage_surface(mesh, 0);
  std::vector<glm::dvec3> points = mesh.positions;
  for (std::size_t row = 0; row < surface.base_vertices.size(); ++row)
    points[surface.base_vertices[row]] = surface.positions[row];
  return points;
}

glm::dvec2 mapped(const glm::dvec3& p) {
  return {0.3 + 2 * p.x - 0.7 * p.y, 0.1 + p.x + 1.5 * p.y};
}

// Coordinates that are affine in the place; those of every chart lie apart.
PolygonMesh textured(PolygonMesh mesh, std::int32_t charts) {
  const std::vector<glm::dvec3> points = given_points(mesh);
  for (std::int32_t chart = 0; chart < charts; ++chart)
    for (const glm::dvec3& p : points)
      mesh.uvs.push_back(mapped(p) + glm::dvec2(kApart * chart, 0));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (const std::int32_t v : mesh.face(f))
      mesh.face_uvs.push_back(v + (7 * f / 3 % charts) * mesh.vertex_count());
  return mesh;
}

PolygonMesh uneven_triangles(std::uint32_t seed) {
  const PolygonMesh grid = test::flat_grid(6, 5);
  PolygonMesh cut;
  cut.positions = grid.positions;
  for (std::int32_t f = 0; f < grid.face_count(); ++f) {
    const auto quad = grid.face(f);
    const std::size_t from = f % 3 == 0 ? 1 : 0;
    cut.add_face(std::array{quad[from], quad[from + 1], quad[from + 2]});
    cut.add_face(std::array{quad[from], quad[from + 2], quad[(from + 3) % 4]});
  }
  PolygonMesh mesh = test::jittered(cut, 0.2, seed);
  for (glm::dvec3& p : mesh.positions) p.z = 0;
  return mesh;
}

std::vector<test::NamedMesh> flat_meshes() {
  std::vector<test::NamedMesh> meshes = {
      {"triangles", uneven_triangles(1)},          {"other triangles", uneven_triangles(2)},
      {"hole", test::plate_with_hole(5)},          {"polygon", test::single_polygon(7)},
      {"large polygon", test::single_polygon(40)}, {"L", test::l_shaped_plate(2)}};
  PolygonMesh creased = uneven_triangles(3);
  creased = test::with_random_creases(creased, 0.2, 3);
  meshes.push_back({"creased", creased});
  // Around one vertex, so many that their rings go by sums.
  PolygonMesh fan;
  constexpr int kSides = 40;
  fan.positions.emplace_back(0.1, 0.05, 0);
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * M_PI * i / kSides, radius = 1 + 0.3 * std::sin(3 * angle);
    fan.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  for (int i = 0; i < kSides; ++i)
    fan.add_face(std::vector<std::int32_t>{0, 1 + i, 1 + (i + 1) % kSides});
  meshes.push_back({"large fan", fan});
  return meshes;
}

TEST(UvCharts, StayWhereTheyWereOnFlatSurfaces) {
  for (const auto& [name, plain] : flat_meshes()) {
    for (const std::int32_t charts : {1, 3}) {
      const PolygonMesh mesh = textured(plain, charts);
      for (int level = 0; level <= 3; ++level) {
        const SurfaceMesh surface = cage_surface(mesh, level);
        ASSERT_EQ(surface.face_uvs.size(), surface.face_vertices.size());
        double worst = 0;
        std::size_t corner = 0;
        for (std::int64_t f = 0; f < surface.face_count(); ++f) {
          const auto face = surface.face(f);
          const double chart = std::round(
              (surface.uvs[surface.face_uvs[corner]].x - mapped(surface.positions[face[0]]).x) /
              kApart);
          for (const std::int32_t v : face) {
            const glm::dvec2 uv = surface.uvs[surface.face_uvs[corner++]];
            const glm::dvec2 wanted = mapped(surface.positions[v]) + glm::dvec2(kApart * chart, 0);
            worst = std::max(worst, glm::distance(uv, wanted));
          }
        }
        EXPECT_LT(worst, 1e-12) << name << ", charts " << charts << ", level " << level;
      }
    }
  }
}

TEST(UvCharts, GivenVerticesKeepTheirs) {
  PolygonMesh mesh = test::jittered(test::icosphere(2), 0.1, 5);
  for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c) {
    mesh.uvs.emplace_back(std::sin(3.0 * static_cast<double>(c / 5)), 1.0 / (1.0 + c % 7));
    mesh.face_uvs.push_back(static_cast<std::int32_t>(c));
  }
  const SurfaceMesh surface = cage_surface(mesh, 2);
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i) EXPECT_EQ(surface.uvs[i], mesh.uvs[i]);
}

// The straight border of a flat mesh is one of its charts, however uneven the values along it are.
TEST(UvCharts, StraightBordersStayStraight) {
  PolygonMesh mesh = test::flat_grid(5, 4);
  for (const glm::dvec3& p : mesh.positions)
    mesh.uvs.emplace_back(p.x * p.x, p.y + 0.3 * p.y * (4 - p.y) * p.x);
  mesh.face_uvs = mesh.face_vertices;
  const SurfaceMesh surface = evaluate(
      mesh, *make_cpu_backend(), {.level = 3, .sharp = {.boundary = BoundaryRule::EdgeAndCorner}});
  for (std::size_t c = 0; c < surface.face_uvs.size(); ++c) {
    const glm::dvec3& p = surface.positions[surface.face_vertices[c]];
    const glm::dvec2& uv = surface.uvs[surface.face_uvs[c]];
    if (p.x == 0) {
      EXPECT_NEAR(uv.x, 0, 1e-14);
    }
    if (p.x == 5) {
      EXPECT_NEAR(uv.x, 25, 1e-13);
    }
    if (p.y == 0) {
      EXPECT_NEAR(uv.y, 0, 1e-14);
    }
    if (p.y == 4) {
      EXPECT_NEAR(uv.y, 4, 1e-13);
    }
  }
}

// Half of a sheet, moved; and mirrored for the other, with the same coordinates at the axis or
// others.
TEST(UvCharts, StayWhereTheyWereWhereMirroredOrMoved) {
  const std::array<std::function<glm::dvec2(double, double, bool)>, 3> maps = {
      [](double x, double y, bool) { return glm::dvec2(std::abs(x), y); },
      [](double x, double y, bool left) { return glm::dvec2(std::abs(x) + (left ? 3 : 0), y); },
      [](double x, double y, bool left) { return glm::dvec2(x + (left ? 12 : 0), y); }};
  for (std::size_t kind = 0; kind < maps.size(); ++kind) {
    constexpr double kSide = 4;
    PolygonMesh mesh = test::flat_grid(8, 5);
    for (glm::dvec3& p : mesh.positions) p.x -= kSide;
    const std::vector<glm::dvec3> points = given_points(mesh);
    const auto is_left = [](std::span<const std::int32_t> face, const auto& positions) {
      double middle = 0;
      for (const std::int32_t v : face) middle += positions[v].x;
      return middle < 0;
    };
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      for (const std::int32_t v : mesh.face(f)) {
        mesh.face_uvs.push_back(static_cast<std::int32_t>(mesh.uvs.size()));
        mesh.uvs.push_back(maps[kind](points[v].x, points[v].y, is_left(mesh.face(f), points)));
      }
    if (kind == 0) {  // one chart a side
      mesh.face_uvs.clear();
      mesh.uvs.clear();
      for (const bool left : {false, true})
        for (const glm::dvec3& p : points) mesh.uvs.push_back(maps[0](p.x, p.y, left));
      for (std::int32_t f = 0; f < mesh.face_count(); ++f)
        for (const std::int32_t v : mesh.face(f))
          mesh.face_uvs.push_back(v + (is_left(mesh.face(f), points) ? mesh.vertex_count() : 0));
    }
    const SurfaceMesh surface = cage_surface(mesh, 3);
    std::size_t corner = 0;
    for (std::int64_t f = 0; f < surface.face_count(); ++f)
      for (const std::int32_t v : surface.face(f)) {
        const glm::dvec3& p = surface.positions[v];
        const glm::dvec2 wanted = maps[kind](p.x, p.y, is_left(surface.face(f), surface.positions));
        EXPECT_LT(glm::distance(surface.uvs[surface.face_uvs[corner++]], wanted), 1e-12) << kind;
      }
  }
}

// A torus: where its texture begins again, it lies as in the middle.
TEST(UvCharts, ShowNoSeamWhereATextureGoesAround) {
  constexpr int kAround = 12, kAcross = 8;
  // Its first columns are one turn further.
  const auto textured_from = [&](int first) {
    PolygonMesh mesh = test::mapped_grid(kAround, kAcross, true, true, [](double u, double v) {
      const double a = 2 * M_PI * u, b = 2 * M_PI * v, radius = 2 + 0.8 * std::cos(b);
      return glm::dvec3(radius * std::cos(a), radius * std::sin(a), 0.8 * std::sin(b));
    });
    const auto turned = static_cast<std::int32_t>(mesh.uvs.size());
    for (std::int32_t uv = 0; uv < turned; ++uv)
      mesh.uvs.push_back(mesh.uvs[uv] + glm::dvec2(1, 0));
    for (std::size_t c = 0; c < mesh.face_uvs.size(); ++c)
      if (static_cast<int>(c / 4) % kAround < first) mesh.face_uvs[c] += turned;
    return cage_surface(mesh, 3);
  };
  const SurfaceMesh whole = textured_from(0), turned = textured_from(5);
  ASSERT_EQ(whole.face_uvs.size(), turned.face_uvs.size());
  for (std::size_t c = 0; c < whole.face_uvs.size(); ++c) {
    const glm::dvec2 apart = turned.uvs[turned.face_uvs[c]] - whole.uvs[whole.face_uvs[c]];
    EXPECT_NEAR(apart.x, std::round(apart.x), 1e-12);
    EXPECT_NEAR(apart.y, 0, 1e-12);
  }
}

// The least area in the texture of a surface's quads, in shares of their mean.
double least_share(const SurfaceMesh& surface) {
  std::vector<double> areas;
  double sum = 0;
  for (std::size_t c = 0; c < surface.face_uvs.size(); c += 4) {
    double area = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const glm::dvec2& p = surface.uvs[surface.face_uvs[c + i]];
      const glm::dvec2& q = surface.uvs[surface.face_uvs[c + (i + 1) % 4]];
      area += p.x * q.y - p.y * q.x;
    }
    areas.push_back(area);
    sum += area;
  }
  double least = 1;
  for (const double area : areas)
    least = std::min(least, area / sum * static_cast<double>(areas.size()));
  return least;
}

// Steps of very unlike sizes, one behind the other, along both sides.
TEST(UvCharts, DoNotFoldWhereStepsAreUneven) {
  const auto least_of = [](const std::vector<double>& steps, bool turned_over) {
    PolygonMesh mesh = test::flat_grid(8, 8);
    for (const glm::dvec3& p : mesh.positions) {
      const glm::dvec2 uv(steps[static_cast<std::size_t>(p.x)],
                          steps[static_cast<std::size_t>(p.y)]);
      mesh.uvs.push_back(turned_over ? glm::dvec2(uv.y, uv.x) : uv);
    }
    mesh.face_uvs = mesh.face_vertices;
    return least_share(cage_surface(mesh, 4));
  };
  for (const std::vector<double>& steps :
       {std::vector<double>{0, 1, 1.01, 2, 2.5, 2.51, 2.52, 7, 7.1},
        std::vector<double>{0, 1e-6, 1, 1 + 1e-6, 3, 3.001, 3.002, 9, 10}}) {
    EXPECT_GT(least_of(steps, false), -1e-12);
    EXPECT_GT(least_of(steps, true), -1e-12);
  }
}

// A sphere by longitude and latitude: on a fine mesh the texture is nearly that of the sphere.
TEST(UvCharts, GoAroundASphere) {
  const int around = 32, across = 16;
  PolygonMesh mesh;
  for (int j = 0; j <= across; ++j)
    for (int i = 0; i < around; ++i) {
      const double u = 2 * M_PI * (i + 0.3 * (j % 2)) / around, v = M_PI * (j + 1) / (across + 2);
      mesh.positions.emplace_back(std::cos(u) * std::sin(v), std::sin(u) * std::sin(v),
                                  -std::cos(v));
    }
  for (int j = 0; j <= across; ++j)
    for (int i = 0; i <= around; ++i)
      mesh.uvs.emplace_back((i + 0.3 * (j % 2)) / around, (j + 1.0) / (across + 2));
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < around; ++i) {
      const int next = (i + 1) % around;
      for (const auto& tri :
           {std::array{j * around + i, j * around + next, (j + 1) * around + i},
            std::array{j * around + next, (j + 1) * around + next, (j + 1) * around + i}}) {
        mesh.add_face(tri);
        for (const int v : tri) {
          const int column = next == 0 && v % around == 0 ? around : v % around;
          mesh.face_uvs.push_back(v / around * (around + 1) + column);
        }
      }
    }
  const SurfaceMesh surface = cage_surface(mesh, 2);
  double worst = 0;
  for (std::size_t c = 0; c < surface.face_uvs.size(); ++c) {
    const glm::dvec3& p = surface.positions[surface.face_vertices[c]];
    const glm::dvec2& uv = surface.uvs[surface.face_uvs[c]];
    const double turn = std::remainder(std::atan2(p.y, p.x) / (2 * M_PI) - uv.x, 1.0);
    const double radius = std::hypot(p.x, p.y);
    if (std::abs(p.z) < 0.8) worst = std::max(worst, std::abs(turn) * radius);
  }
  EXPECT_LT(worst, 2.5e-3);  // a cell is 1 / 32 wide
}

// Four numbers that are affine in the place, in the range that is given.
TEST(ValueCharts, StayWhereTheyWereOnFlatSurfaces) {
  for (const auto& [name, plain] : flat_meshes()) {
    PolygonMesh mesh = plain;
    const auto value = [](const glm::dvec3& p) {
      return glm::dvec4(mapped(p), mapped(p).y - 3 * mapped(p).x, 0.5);
    };
    glm::dvec4 lowest(1e9), highest(-1e9);
    for (const glm::dvec3& p : given_points(mesh)) {
      mesh.colors.emplace_back(value(p));
      lowest = glm::min(lowest, value(p));
      highest = glm::max(highest, value(p));
    }
    for (int level = 0; level <= 3; ++level) {
      const SurfaceMesh surface = cage_surface(mesh, level);
      double worst = 0;
      for (std::size_t row = 0; row < surface.positions.size(); ++row) {
        const glm::dvec4 wanted = glm::clamp(value(surface.positions[row]), lowest, highest);
        worst = std::max(worst, glm::distance(glm::dvec4(surface.colors[row]), wanted) /
                                    glm::distance(lowest, highest));
      }
      EXPECT_LT(worst, 1e-6) << name << ", level " << level;
    }
  }
}

// Where all neighbours have one value, there is no other; rows lie between the values around them.
TEST(ValueCharts, DoNotSwingOver) {
  for (PolygonMesh mesh :
       {test::jittered(test::icosphere(3), 0.1, 5), test::torus(12, 9, 1.0, 0.4)}) {
    for (const glm::dvec3& p : mesh.positions)
      mesh.colors.emplace_back(p.x > 0.1 ? 0.25f : 0.75f, std::sin(40 * p.y), p.x, p.z > 0 ? 1 : 0);
    std::vector<glm::dvec4> lowest(mesh.positions.size(), glm::dvec4(1e9)), highest(lowest.size());
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      for (const std::int32_t v : mesh.face(f))
        for (const std::int32_t w : mesh.face(f)) {
          lowest[v] = glm::min(lowest[v], glm::dvec4(mesh.colors[w]));
          highest[v] = glm::max(highest[v], glm::dvec4(mesh.colors[w]));
        }
    const SurfaceMesh surface = cage_surface(mesh, 3);
    const std::vector<std::int32_t> ancestors = ancestor_faces(surface, mesh);
    for (std::int64_t f = 0; f < surface.face_count(); ++f) {
      glm::dvec4 low(1e9), high(-1e9);
      for (const std::int32_t v : mesh.face(ancestors[f])) {
        low = glm::min(low, lowest[v]);
        high = glm::max(high, highest[v]);
      }
      for (const std::int32_t row : surface.face(f))
        for (int k = 0; k < 4; ++k) {
          ASSERT_GE(surface.colors[row][k], low[k] - 1e-6);
          ASSERT_LE(surface.colors[row][k], high[k] + 1e-6);
        }
    }
    for (std::size_t row = 0; row < surface.base_vertices.size(); ++row)
      EXPECT_EQ(surface.colors[row], mesh.colors[surface.base_vertices[row]]);
  }
}

// A colour that goes smoothly over the plane: nearer to it than what is linear between vertices.
TEST(ValueCharts, AreNearerToSmoothOnesThanLinearOnes) {
  PolygonMesh mesh = test::flat_grid(12, 12);
  const auto value = [](const glm::dvec3& p) { return std::sin(0.7 * p.x) * std::cos(0.5 * p.y); };
  for (const glm::dvec3& p : given_points(mesh))
    mesh.colors.emplace_back(static_cast<float>(value(p)), 0, 0, 1);
  const SurfaceMesh surface = cage_surface(mesh, 4);
  double worst = 0, of_linear = 0;
  for (std::size_t row = 0; row < surface.positions.size(); ++row) {
    const glm::dvec3& p = surface.positions[row];
    if (p.x < 2 || p.x > 10 || p.y < 2 || p.y > 10) continue;
    worst = std::max(worst, std::abs(surface.colors[row].x - value(p)));
    const double x = std::floor(p.x), y = std::floor(p.y), u = p.x - x, v = p.y - y;
    const auto at = [&](double dx, double dy) { return value({x + dx, y + dy, 0}); };
    const double linear =
        (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
    of_linear = std::max(of_linear, std::abs(linear - value(p)));
  }
  EXPECT_GT(of_linear, 0.05);
  EXPECT_LT(worst, 0.5 * of_linear);
}

}  // namespace
}  // namespace planish
