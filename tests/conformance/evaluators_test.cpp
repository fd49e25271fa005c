// OpenSubdiv's own evaluators on our tables against our CPU backend.

#include <gtest/gtest.h>
#include <opensubdiv/osd/bufferDescriptor.h>
#include <opensubdiv/osd/cpuEvaluator.h>

#include <glm/geometric.hpp>

#include "conformance/catalogue.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/solve/backend.h"
#include "planish/solve/far_tables.h"
#include "support/doo_sabin_tables.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;
namespace Osd = OpenSubdiv::Osd;

constexpr double kFloat = 1e-6;  // coordinates are about 1

// OpenSubdiv asks a primvar for Clear and AddWithWeight.
struct Primvar {
  dvec3 value{0.0};
  void Clear() { value = dvec3(0.0); }
  void AddWithWeight(const Primvar& source, double weight) { value += weight * source.value; }
};

// A unit-sized closed mesh and an open one with creases, with their sharp features.
struct Case {
  explicit Case(PolygonMesh source)
      : mesh(std::move(source)),
        split(mesh),
        features(
            (split.refine(2), find_sharp_features(mesh, split.topology(), mesh.positions, {}))),
        subdivision(split, features, Weights::DooSabin),
        masks(limit_masks(subdivision)) {}
  PolygonMesh mesh;
  QuadSplit split;
  SharpFeatures features;
  SubdivisionChain subdivision;
  StencilTable masks;
};

std::vector<PolygonMesh> cases() {
  return {random_closed_mesh(5), with_random_creases(random_open_mesh(5), 0.2, 5)};
}

std::vector<dvec3> applied_by_backend(const StencilView<double>& view,
                                      const std::vector<dvec3>& source) {
  const auto backend = make_cpu_backend();
  const auto from = backend->upload(source);
  const auto to = backend->allocate(view.row_count());
  backend->apply(view, *from, *to, 0);
  return backend->download(*to);
}

TEST(Evaluators, UpdateValuesEqualsTheCpuBackend) {
  for (const PolygonMesh& mesh : cases()) {
    const Case c(mesh);
    std::vector<Primvar> source, target(mesh.positions.size());
    for (const dvec3& p : mesh.positions) source.push_back({p});
    to_far<double>(c.masks.view())->UpdateValues(source.data(), target.data());
    const std::vector<dvec3> ours = applied_by_backend(c.masks.view(), mesh.positions);
    ASSERT_EQ(ours.size(), target.size());
    for (std::size_t v = 0; v < ours.size(); ++v) {
      EXPECT_LT(glm::distance(ours[v], target[v].value), 1e-15);
    }
  }
}

TEST(Evaluators, FloatTablesInOsdCpuEvaluatorEqualTheCpuBackend) {
  for (const PolygonMesh& mesh : cases()) {
    const Case c(mesh);
    const auto far = to_far<float>(c.masks.view());
    const OpenSubdiv::Far::StencilTable& table = *far;
    std::vector<float> source, target(3 * std::size_t(table.GetNumStencils()));
    for (const dvec3& p : mesh.positions) {
      source.insert(source.end(), {float(p.x), float(p.y), float(p.z)});
    }
    const Osd::BufferDescriptor xyz(0, 3, 3);
    ASSERT_TRUE(Osd::CpuEvaluator::EvalStencils(
        source.data(), xyz, target.data(), xyz, table.GetSizes().data(), table.GetOffsets().data(),
        table.GetControlIndices().data(), table.GetWeights().data(), 0, table.GetNumStencils()));
    const std::vector<dvec3> ours = applied_by_backend(c.masks.view(), mesh.positions);
    for (std::size_t v = 0; v < ours.size(); ++v) {
      const dvec3 theirs(target[3 * v], target[3 * v + 1], target[3 * v + 2]);
      EXPECT_LT(glm::distance(ours[v], theirs), kFloat);
    }
  }
}

TEST(Evaluators, LimitTablesInOsdCpuEvaluatorEqualTheCpuBackend) {
  for (const PolygonMesh& mesh : cases()) {
    const Case c(mesh);
    const auto first = step_table(c.subdivision, 1);
    const std::vector<dvec3> state = applied_by_backend(first.view(), mesh.positions);
    const LimitRows limit_rows(c.subdivision, 1);
    const auto limit = limit_table(c.subdivision, limit_rows);
    const StencilView<double> view = limit.view();
    const auto far = to_far_limit<float>(view);
    const OpenSubdiv::Far::LimitStencilTable& table = *far;
    std::vector<float> source;
    for (const dvec3& p : state) {
      source.insert(source.end(), {float(p.x), float(p.y), float(p.z)});
    }
    const std::size_t count = 3 * std::size_t(view.row_count());
    std::vector<float> point(count), du(count), dv(count);
    const Osd::BufferDescriptor xyz(0, 3, 3);
    ASSERT_TRUE(Osd::CpuEvaluator::EvalStencils(
        source.data(), xyz, point.data(), xyz, du.data(), xyz, dv.data(), xyz,
        table.GetSizes().data(), table.GetOffsets().data(), table.GetControlIndices().data(),
        table.GetWeights().data(), table.GetDuWeights().data(), table.GetDvWeights().data(), 0,
        table.GetNumStencils()));
    std::vector<dvec3> positions(view.row_count());
    std::vector<glm::vec3> normals(view.row_count());
    const auto backend = make_cpu_backend();
    backend->apply_limit(view, *backend->upload(state), positions, normals);
    const auto at = [](const std::vector<float>& values, std::size_t i) {
      return dvec3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    };
    for (std::size_t i = 0; i < positions.size(); ++i) {
      EXPECT_LT(glm::distance(positions[i], at(point, i)), kFloat);
      const dvec3 u = at(du, i), v = at(dv, i), across = glm::cross(u, v);
      // Rounding of the tangents turns a normal by their error over the sine between them.
      const double sine = glm::length(across) / (glm::length(u) * glm::length(v));
      if (!(sine > 1e-2)) continue;
      const double smaller = std::min(glm::length(u), glm::length(v));
      EXPECT_LT(glm::distance(dvec3(normals[i]), glm::normalize(across)),
                1e-6 + 2e-6 / (sine * smaller));
    }
  }
}

TEST(Evaluators, FloatSolveStaysNearDouble) {
  for (const PolygonMesh& mesh : cases()) {
    const Case c(mesh);
    const auto run = [&](Precision precision) {
      const auto backend = make_cpu_backend({.solve_precision = precision});
      const auto solve = backend->make_solve(c.masks.view());
      solve->begin(mesh.positions);
      solve->run(std::vector<StepCoefficients>(5, {0, 1}), 0);
      return solve->displacement();
    };
    const std::vector<dvec3> in_float = run(Precision::Float), in_double = run(Precision::Double);
    for (std::size_t v = 0; v < in_float.size(); ++v) {
      EXPECT_LT(glm::distance(in_float[v], in_double[v]), 1e-5);  // five steps, sizes up to 5
    }
  }
}

}  // namespace
}  // namespace planish::test
