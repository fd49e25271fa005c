#include "quality/tables.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "make_scenes/models.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/face_geometry.h"
#include "planish/solve/backend.h"
#include "quality/figures.h"

namespace planish::quality {

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// Two periods of bending in the plane of the arm with one of twisting about its length.
glm::dvec3 moved(const glm::dvec3& p, double time) {
  const double bend = 0.25 * std::sin(2 * 2 * std::numbers::pi * time) * p.x;
  const double twist = 0.5 * std::sin(2 * std::numbers::pi * time) * p.x;
  const glm::dvec3 twisted(p.x, std::cos(twist) * p.y - std::sin(twist) * p.z,
                           std::sin(twist) * p.y + std::cos(twist) * p.z);
  return {std::cos(bend) * twisted.x - std::sin(bend) * twisted.y,
          std::sin(bend) * twisted.x + std::cos(bend) * twisted.y, twisted.z};
}

PolygonMesh scan_of_the_scenes() {
  const std::string path = std::string(PLANISH_SCENES) + "/rocker_arm_scan.obj";
  return read_mesh(path).mesh;
}

// Sum of the area vectors of the faces around each vertex.
std::vector<glm::dvec3> mesh_normals(const PolygonMesh& mesh) {
  std::vector<glm::dvec3> normals(mesh.positions.size(), glm::dvec3(0.0));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const glm::dvec3 area = area_vector(mesh.positions, mesh.face(f));
    for (const std::int32_t v : mesh.face(f)) normals[v] += area;
  }
  return normals;
}

// How far normals turn from one frame to the next.
struct Turns {
  std::vector<glm::dvec3> before;
  double largest = 0, sum_of_squares = 0;
  std::int64_t count = 0, pops = 0;

  // `shape`: how far the mesh's own normals turned; empty to count no pops.
  std::vector<double> advance(std::vector<glm::dvec3> normals, const std::vector<double>& shape) {
    std::vector<double> turns;
    if (!before.empty()) {
      for (std::size_t v = 0; v < normals.size(); ++v) {
        turns.push_back(angle_between(before[v], normals[v]) * kDegrees);
        largest = std::max(largest, turns.back());
        sum_of_squares += turns.back() * turns.back();
        ++count;
        // More than the shape by what an eye sees between two frames.
        constexpr double kVisible = 5.0;
        if (!shape.empty() && turns.back() > shape[v] + kVisible) ++pops;
      }
    }
    before = std::move(normals);
    return turns;
  }
  [[nodiscard]] double rms() const {
    return std::sqrt(sum_of_squares / static_cast<double>(count));
  }
};

}  // namespace

void print_animation(int frame_count) {
  const PolygonMesh rest = scan_of_the_scenes();
  const auto backend = make_cpu_backend({Precision::Double});
  std::vector<Turns> turns(methods().size());
  std::vector<FairDecisions> decisions(methods().size());
  Turns shape;
  for (int frame = 0; frame < frame_count; ++frame) {
    PolygonMesh mesh = rest;
    for (glm::dvec3& p : mesh.positions) p = moved(p, static_cast<double>(frame) / kFrames);
    const std::vector<double> own = shape.advance(mesh_normals(mesh), {});
    for (std::size_t m = 1; m < methods().size(); ++m) {
      FitOptions options = methods()[m].options;
      if (frame > 0) options.fair_decisions = &decisions[m];
      Fit fitted = fit(mesh, *backend, options);
      const SurfaceMesh surface =
          evaluate(mesh, fitted, *backend,
                   {.level = 0, .weights = options.weights, .rest_positions = rest.positions});
      // The first frame is the rest pose.
      if (frame == 0 && fitted.fair) decisions[m] = std::move(fitted.fair->decisions);
      std::vector<glm::dvec3> normals(surface.normals.begin(), surface.normals.end());
      (void)turns[m].advance(std::move(normals), own);
    }
  }
  std::printf(
      "\n%d frames of the scanned rocker arm, %d a second: turn of the normals from frame to "
      "frame\n"
      "| method | largest, degrees | rms | turns 5 degrees beyond the shape's "
      "|\n|---|--:|--:|--:|\n"
      "| the mesh itself | %.2f | %.3f | |\n",
      frame_count, kFrames / 8, shape.largest, shape.rms());
  for (std::size_t m = 1; m < methods().size(); ++m) {
    std::printf("| %s | %.2f | %.3f | %lld of %lld |\n", methods()[m].name.c_str(),
                turns[m].largest, turns[m].rms(), static_cast<long long>(turns[m].pops),
                static_cast<long long>(turns[m].count));
  }
}

}  // namespace planish::quality
