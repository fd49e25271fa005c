#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <memory>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "limit/limit_case.h"
#include "planish/edit/editor.h"

namespace planish::test {

inline constexpr double kTolerance = 1e-6;

/// A progressive fit that is edited.
struct EditCase {
  explicit EditCase(PolygonMesh given, int level = 2, Weights weights = Weights::DooSabin)
      : mesh(std::move(given)), backend(make_cpu_backend()) {
    options.level = level;
    options.fit.weights = weights;
    options.fit.tolerance = kTolerance;
    first = fit(mesh, *backend, options.fit);
  }
  // The surface of a fit from scratch, far beyond the tolerance, with the rules of the first pose.
  [[nodiscard]] std::pair<Fit, SurfaceMesh> from_scratch(const PolygonMesh& moved) const {
    FitOptions tight = options.fit;
    tight.tolerance = 1e-12;
    Fit result = fit(moved, *backend, tight);
    return {result, surface_of(moved, result)};
  }
  [[nodiscard]] SurfaceMesh surface_of(const PolygonMesh& moved, const Fit& of) const {
    EvaluateOptions evaluate;
    evaluate.level = options.level;
    evaluate.weights = options.fit.weights;
    evaluate.rest_positions = mesh.positions;
    return planish::evaluate(moved, of, *backend, evaluate);
  }

  PolygonMesh mesh;
  std::unique_ptr<Backend> backend;
  EditorOptions options;
  Fit first;
};

inline double farthest(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b) {
  EXPECT_EQ(a.size(), b.size());
  double result = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    result = std::max(result, glm::length(a[i] - b[i]));
  return result;
}

/// Moves by lot.
class Mover {
 public:
  explicit Mover(std::uint32_t seed) : random_(seed) {}
  // Vertices that faces name, by up to a part of the diagonal.
  void choose(const Editor& editor, const EditCase& c, std::size_t count, double part) {
    vertices.clear();
    positions.clear();
    const auto used = c.first.prepared->vertices;
    std::uniform_int_distribution<std::size_t> any(0, used.size() - 1);
    std::uniform_real_distribution<double> way(-part, part);
    for (std::size_t i = 0; i < count; ++i) {
      vertices.push_back(used[any(random_)]);
      positions.push_back(editor.points()[vertices.back()] +
                          c.first.placement.diagonal *
                              glm::dvec3(way(random_), way(random_), way(random_)));
    }
  }
  std::vector<std::int32_t> vertices;
  std::vector<glm::dvec3> positions;

 private:
  std::mt19937 random_;
};

inline std::vector<NamedMesh> edited_meshes() {
  std::vector<NamedMesh> meshes = limit_meshes();
  meshes.push_back({"torus", torus(30, 20, 1, 0.4)});
  meshes.push_back({"sphere", jittered(icosphere(3), 0.2, 4)});
  meshes.push_back({"large faces", prism(45)});
  meshes.push_back({"hubs", bipyramid(50)});
  meshes.push_back({"large open face", single_polygon(40)});
  return meshes;
}

}  // namespace planish::test
