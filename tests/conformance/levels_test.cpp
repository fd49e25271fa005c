#include <gtest/gtest.h>
#include <opensubdiv/osd/bufferDescriptor.h>
#include <opensubdiv/osd/cpuEvaluator.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <vector>

#include "planish/doosabin/limit_masks.h"
#include "planish/files/mesh_file.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/solve/far_tables.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/surface_blocks.h"
#include "support/doo_sabin_oracles.h"
#include "support/doo_sabin_tables.h"
#include "support/mesh_catalogue.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

// Which of the oracle's faces and vertices are the library's, found level by level: children of a
// matched face are tried in every order and rotation until all four limit points are close.
class LevelMatch {
 public:
  // To be called with levels 1, 2, ... in turn, `oracle` at the same level. Reports a test
  // failure where a face has no counterpart or a vertex two.
  void advance(const SurfaceMesh& surface, const QuadSplitOracle& oracle);

  [[nodiscard]] std::int32_t face_of(std::int32_t library_face) const {
    return faces_[library_face].face;
  }
  // Largest distance between limit points of the latest level.
  [[nodiscard]] double worst_position() const { return worst_position_; }
  // Largest distance between unit normals, face corner by face corner, so that each side of a
  // crease is held against its own sector. Degenerate tangents are left out.
  [[nodiscard]] double worst_normal() const { return worst_normal_; }

 private:
  struct Match {
    std::int32_t face, rotation;
  };
  [[nodiscard]] Match find(const SurfaceMesh& surface, const QuadSplitOracle& oracle,
                           std::int64_t library_face) const;
  void compare(const SurfaceMesh& surface, const QuadSplitOracle& oracle);

  std::vector<Match> faces_;
  double worst_position_ = 0, worst_normal_ = 0;
};

}  // namespace

using glm::dvec3;
using std::int32_t;

namespace {

// Far above rounding, far below the distances of neighbouring limit points at level 4.
constexpr double kClose = 1e-9;

// A ring of two has tangents on one line; its second one is rounding noise of no direction.
bool is_degenerate(const QuadSplitOracle& oracle, int32_t vertex, std::size_t sector) {
  const QuadSplitOracle::Sector& around = oracle.sectors(vertex)[sector];
  if (around.is_ring && around.faces.size() == 2) return true;
  const auto& [t1, t2] = oracle.tangents(vertex, sector);
  return glm::length(glm::cross(t1, t2)) < 1e-5 * glm::length(t1) * glm::length(t2);
}

LevelMatch::Match LevelMatch::find(const SurfaceMesh& surface, const QuadSplitOracle& oracle,
                                   std::int64_t library_face) const {
  const auto corners = surface.face(library_face);
  const auto fits = [&](int32_t candidate, int32_t rotation) {
    for (int32_t i = 0; i < 4; ++i) {
      const int32_t vertex = oracle.faces()[candidate][(i + rotation) % 4];
      const dvec3 position = surface.positions[corners[i]];
      if (glm::distance(position, oracle.limit_point(vertex)) > kClose) return false;
    }
    return true;
  };
  // Level 1: one child a corner of the input, in the same order on both sides.
  const bool first = surface.level == 1;
  const auto from = int32_t(first ? library_face : 4 * faces_[library_face / 4].face);
  for (int32_t candidate = from; candidate < from + (first ? 1 : 4); ++candidate) {
    for (int32_t rotation = 0; rotation < 4; ++rotation) {
      if (fits(candidate, rotation)) return {candidate, rotation};
    }
  }
  ADD_FAILURE() << "face " << library_face << " of level " << surface.level
                << " has no counterpart";
  return {from, 0};
}

void LevelMatch::advance(const SurfaceMesh& surface, const QuadSplitOracle& oracle) {
  ASSERT_EQ(surface.face_count(), std::int64_t(oracle.faces().size()));
  std::vector<Match> matches;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    matches.push_back(find(surface, oracle, f));
  }
  faces_ = matches;
  std::set<int32_t> taken;
  for (const Match& match : faces_) taken.insert(match.face);
  EXPECT_EQ(taken.size(), faces_.size()) << "two faces have the same counterpart";
  compare(surface, oracle);
}

void LevelMatch::compare(const SurfaceMesh& surface, const QuadSplitOracle& oracle) {
  worst_position_ = worst_normal_ = 0;
  std::map<int32_t, int32_t> vertex_of;
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const auto corners = surface.face(std::int64_t(f));
    for (int32_t i = 0; i < 4; ++i) {
      const int32_t q = faces_[f].face, v = oracle.faces()[q][(i + faces_[f].rotation) % 4];
      EXPECT_EQ(vertex_of.try_emplace(corners[i], v).first->second, v);
      worst_position_ = std::max(
          worst_position_, glm::distance(surface.positions[corners[i]], oracle.limit_point(v)));
      const std::size_t sector = oracle.sector_of(v, q);
      if (is_degenerate(oracle, v, sector)) continue;
      const dvec3 normal(surface.normals[corners[i]]);
      worst_normal_ = std::max(worst_normal_, glm::distance(normal, oracle.normal(v, sector)));
    }
  }
}

// The library's limit points, normals and control points of every level against the oracles.

constexpr double kRounding = 1e-12;
// Normals are stored in float.
constexpr double kFloatNormal = 5e-7;

struct Rules {
  Weights weights;
  BoundaryRule boundary;
};

// Limit points and normals by evaluate(), control points by the chain of stencil tables.
void expect_levels_agree(const PolygonMesh& mesh, Rules rules, int levels) {
  const auto backend = make_cpu_backend();
  QuadSplitOracle oracle(mesh, rules.weights, rules.boundary);
  LevelMatch match;
  const ChainCase c(mesh, rules.weights, levels, {.boundary = rules.boundary});
  std::vector<dvec3> state = mesh.positions;
  for (int level = 1; level <= levels; ++level) {
    SCOPED_TRACE("level " + std::to_string(level));
    state = applied(step_table(c.subdivision, level), state);
    const SurfaceMesh surface =
        evaluate(mesh, *backend,
                 {.level = level, .weights = rules.weights, .sharp = {.boundary = rules.boundary}});
    match.advance(surface, oracle);
    EXPECT_LT(match.worst_position(), kRounding);
    EXPECT_LT(match.worst_normal(), kFloatNormal);
    double worst = 0;
    for (int32_t q = 0; q < surface.face_count(); ++q) {
      worst = std::max(worst, glm::distance(state[q], oracle.face_point(match.face_of(q))));
    }
    EXPECT_LT(worst, kRounding) << "control points";
    if (level < levels) oracle.refine();
  }
}

void expect_levels_agree(const std::vector<NamedMesh>& meshes, BoundaryRule boundary) {
  for (const auto& [name, mesh] : meshes) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      expect_levels_agree(mesh, {weights, boundary}, 3);
    }
  }
}

TEST(Levels, ClosedMeshesAgreeWithTheOracle) {
  expect_levels_agree(closed_meshes(), BoundaryRule::Edge);
}

TEST(Levels, OpenMeshesAgreeWithTheOracle) {
  for (BoundaryRule boundary : {BoundaryRule::Edge, BoundaryRule::EdgeAndCorner})
    expect_levels_agree(open_meshes(), boundary);
}

TEST(Levels, SharpMeshesAgreeWithTheOracle) {
  expect_levels_agree(sharp_meshes(), BoundaryRule::Edge);
}

void expect_same_points(const std::vector<dvec3>& points, const std::vector<dvec3>& expected) {
  ASSERT_EQ(points.size(), expected.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT(glm::distance(points[i], expected[i]), kRounding);
}

TEST(Levels, ControlPointsAndLimitsAreThoseOfExplicitSubdivision) {
  for (const auto& [name, mesh] : closed_meshes()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const ChainCase c(mesh, weights, 1);
      expect_same_points(applied(step_table(c.subdivision, 1), mesh.positions),
                         explicit_levels(mesh, weights, 1).points);
      expect_same_points(limit_positions(mesh, weights, {}),
                         explicit_limit_points(explicit_levels(mesh, weights, 3)));
    }
  }
}

TEST(Levels, OpenGridsAreTensorProductBSplines) {
  const int columns = 5, rows = 4;
  const PolygonMesh mesh = jittered(flat_grid(columns, rows), 0.3, 1);
  const BSplineOracle spline(mesh, columns, rows);
  const auto backend = make_cpu_backend();
  for (Weights weights : kBothWeights) {
    for (int level = 0; level <= 5; ++level) {
      EvaluateOptions options{.level = level, .weights = weights};
      options.sharp.boundary = BoundaryRule::EdgeAndCorner;
      const SurfaceMesh surface = evaluate(mesh, *backend, options);
      // A grid whose positions are its parameters is reproduced: it tells each vertex's place.
      const SurfaceMesh where = evaluate(flat_grid(columns, rows), *backend, options);
      ASSERT_EQ(surface.positions.size(), where.positions.size());
      double worst = 0, worst_normal = 0;
      for (std::size_t v = 0; v < surface.positions.size(); ++v) {
        const dvec3 uv = where.positions[v];
        worst = std::max(worst, glm::distance(surface.positions[v], spline.point(uv.x, uv.y)));
        worst_normal = std::max(
            worst_normal, glm::distance(dvec3(surface.normals[v]), spline.normal(uv.x, uv.y)));
      }
      EXPECT_LT(worst, kRounding) << "level " << level;
      EXPECT_LT(worst_normal, kFloatNormal) << "level " << level;
    }
  }
}

// The project's own scenes: first level against the oracle, and the fitted surface through the
// given vertices.

std::vector<NamedMesh> scene_files() {
  std::vector<NamedMesh> meshes;
  for (const auto& entry : std::filesystem::directory_iterator(PLANISH_SCENES)) {
    if (entry.path().extension() != ".obj") continue;
    const std::string name = entry.path().filename().string();
    meshes.push_back({name, read_mesh(entry.path()).mesh});
    // Faces that are left out change nothing about the others, and the oracle knows none.
    meshes.back().mesh.hole_faces.clear();
  }
  return meshes;
}

TEST(SceneFiles, FirstLevelAgreesWithTheOracle) {
  const auto backend = make_cpu_backend();
  const std::vector<NamedMesh> meshes = scene_files();
  ASSERT_GE(meshes.size(), 10u);
  for (const auto& [name, mesh] : meshes) {
    if (mesh.vertex_count() > 5000) continue;  // the oracle is slow
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const QuadSplitOracle oracle(mesh, weights, BoundaryRule::Edge);
      LevelMatch match;
      match.advance(evaluate(mesh, *backend, {.level = 1, .weights = weights}), oracle);
      const double diagonal = placement_of(mesh).diagonal;
      EXPECT_LT(match.worst_position(), 1e-12 * diagonal);
      EXPECT_LT(match.worst_normal(), 1e-6);
    }
  }
}

TEST(SceneFiles, FittedSurfacesPassThroughTheVertices) {
  const auto backend = make_cpu_backend();
  constexpr double kTolerance = 1e-8;
  for (const auto& [name, mesh] : scene_files()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const Fit result = fit(mesh, *backend, {.weights = weights, .tolerance = kTolerance});
      EXPECT_TRUE(result.interpolation.converged);
      const std::vector<dvec3> limits = limit_positions(result.cage, weights, {});
      double worst = 0;
      for (std::size_t v = 0; v < limits.size(); ++v) {
        worst = std::max(worst, glm::distance(limits[v], mesh.positions[v]));
      }
      EXPECT_LT(worst, 1.01 * kTolerance * result.placement.diagonal);
    }
  }
}

// OpenSubdiv's own evaluators on our tables against our own.
namespace Osd = OpenSubdiv::Osd;

constexpr double kFloat = 1e-6;  // coordinates are about 1

// OpenSubdiv asks a primvar for Clear and AddWithWeight.
struct Primvar {
  dvec3 value{0.0};
  void Clear() { value = dvec3(0.0); }
  void AddWithWeight(const Primvar& source, double weight) { value += weight * source.value; }
};

struct Case : ChainCase {
  explicit Case(const PolygonMesh& source)
      : ChainCase(source, Weights::DooSabin, 2), masks(limit_masks(subdivision)) {}
  StencilTable masks;
};

// A unit-sized closed mesh and an open one with creases.
std::vector<PolygonMesh> cases() {
  return {random_closed_mesh(5), with_random_creases(random_open_mesh(5), 0.2, 5)};
}

std::vector<dvec3> image_of(const StencilView<double>& view, const std::vector<dvec3>& source) {
  std::vector<dvec3> target(view.row_count());
  apply(view, source, target);
  return target;
}

TEST(Evaluators, UpdateValuesEqualsOurOwn) {
  for (const PolygonMesh& mesh : cases()) {
    const Case c(mesh);
    std::vector<Primvar> source, target(mesh.positions.size());
    for (const dvec3& p : mesh.positions) source.push_back({p});
    to_far<double>(c.masks.view())->UpdateValues(source.data(), target.data());
    const std::vector<dvec3> ours = image_of(c.masks.view(), mesh.positions);
    ASSERT_EQ(ours.size(), target.size());
    for (std::size_t v = 0; v < ours.size(); ++v) {
      EXPECT_LT(glm::distance(ours[v], target[v].value), 1e-15);
    }
  }
}

TEST(Evaluators, FloatTablesInOsdCpuEvaluatorEqualOurOwn) {
  for (const PolygonMesh& mesh : cases()) {
    const Case c(mesh);
    const auto far = to_far<float>(c.masks.view());
    const OpenSubdiv::Far::StencilTable& table = *far;
    std::vector<float> source, target(3 * std::size_t(table.GetNumStencils()));
    for (const dvec3& p : mesh.positions)
      source.insert(source.end(), {float(p.x), float(p.y), float(p.z)});
    const Osd::BufferDescriptor xyz(0, 3, 3);
    ASSERT_TRUE(Osd::CpuEvaluator::EvalStencils(
        source.data(), xyz, target.data(), xyz, table.GetSizes().data(), table.GetOffsets().data(),
        table.GetControlIndices().data(), table.GetWeights().data(), 0, table.GetNumStencils()));
    const std::vector<dvec3> ours = image_of(c.masks.view(), mesh.positions);
    for (std::size_t v = 0; v < ours.size(); ++v) {
      const dvec3 theirs(target[3 * v], target[3 * v + 1], target[3 * v + 2]);
      EXPECT_LT(glm::distance(ours[v], theirs), kFloat);
    }
  }
}

TEST(Evaluators, LimitTablesInOsdCpuEvaluatorEqualOurOwn) {
  for (const PolygonMesh& mesh : cases()) {
    const Case c(mesh);
    const auto first = step_table(c.subdivision, 1);
    const std::vector<dvec3> state = image_of(first.view(), mesh.positions);
    const LimitRows limit_rows(c.subdivision, 1);
    const auto limit = limit_table(c.subdivision, limit_rows);
    const StencilView<double> view = limit.view();
    const auto far = to_far_limit<float>(view);
    const OpenSubdiv::Far::LimitStencilTable& table = *far;
    std::vector<float> source;
    for (const dvec3& p : state) source.insert(source.end(), {float(p.x), float(p.y), float(p.z)});
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
    apply_limit(view, state, positions, normals);
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
