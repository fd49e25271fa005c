#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "brep/step_file.h"
#include "limit/limit_case.h"
#include "planish/brep/brep.h"
#include "planish/brep/write_step.h"
#include "planish/mesh/mesh_topology.h"

namespace planish::test {

inline std::string scratch(const std::string& name) {
  return (std::filesystem::path(testing::TempDir()) / name).string();
}

inline std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline StepFile written(const LimitCase& c, const Brep& brep, const std::string& path) {
  write_step(path, brep, {.name = "part", .diagonal = c.surface->placement().diagonal});
  return StepFile(path);
}

inline PolygonMesh creased_cube(bool all_around) {
  PolygonMesh mesh = cube();
  // Of the cube's faces those at z = 1 have all edges sharp, or all faces have.
  for (std::int32_t a = 0; a < 8; ++a)
    for (const std::int32_t bit : {1, 2, 4})
      if ((a & bit) == 0 && (all_around || ((a & 4) != 0 && bit != 4)))
        mesh.creases.push_back({a, a | bit});
  return mesh;
}

inline std::vector<NamedMesh> step_meshes() {
  std::vector<NamedMesh> meshes = limit_meshes();
  meshes.push_back({"single triangle", single_polygon(3)});
  meshes.push_back({"300-gon drum", prism(300)});
  meshes.push_back({"hub of 100", bipyramid(100)});
  meshes.push_back({"valence 2", cube_with_split_edges()});
  meshes.push_back({"torus", torus(12, 8, 3, 1)});
  meshes.push_back({"small torus", torus(3, 3, 3, 1)});
  return meshes;
}

/// Of the mesh's faces that are seen.
inline std::int64_t euler_number(const MeshTopology& topology,
                                 std::span<const std::uint8_t> hidden) {
  std::set<std::int32_t> vertices, edges;
  std::int64_t faces = 0;
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    if (!hidden.empty() && hidden[f] != 0) continue;
    ++faces;
    for (const std::int32_t v : topology.face(f)) vertices.insert(v);
    for (const std::int32_t e : topology.face_edges(f)) edges.insert(e);
  }
  return std::ssize(vertices) - std::ssize(edges) + faces;
}

/// A curve on surfaces, or a curve alone where all of them are planes.
inline std::int64_t curve_of(const StepFile& file, std::int64_t edge) {
  const Part21Value& geometry = file.at(edge).values[3];
  return file.at(geometry).keyword == "SURFACE_CURVE" ? file.at(geometry).values[1].reference
                                                      : geometry.reference;
}
inline std::vector<Part21Value> surfaces_beside(const StepFile& file, std::int64_t edge) {
  const Part21Entity& geometry = file.at(file.at(edge).values[3]);
  return geometry.keyword == "SURFACE_CURVE" ? geometry.values[2].items
                                             : std::vector<Part21Value>{};
}

/// Every edge lies on the surfaces of its faces at the parameters that its lines say, is used once
/// each way, and ends at its vertices.
inline void expect_joined(const StepFile& file, double tolerance, double plane_tolerance,
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

/// Loops run around [0, a] x [0, b] without a jump.
inline void expect_loops(const StepFile& file) {
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

/// Degrees between normals of both sides of an edge, crowded at its ends where the kinks are, and
/// measured by finite differences of the file's own surfaces.
inline double worst_jump(const StepFile& file) {
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
        normals.push_back(
            glm::normalize(glm::cross((surface.at(x1, uv.y) - surface.at(x0, uv.y)) / (x1 - x0),
                                      (surface.at(uv.x, y1) - surface.at(uv.x, y0)) / (y1 - y0))));
      }
      if (normals.size() == 2) worst = std::max(worst, glm::length(normals[0] - normals[1]));
    }
  }
  return worst * 180 / std::numbers::pi;
}

}  // namespace planish::test
