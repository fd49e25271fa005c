#include <gtest/gtest.h>
#include <petscksp.h>

#include <map>

#include "distributed/rank_runs.h"
#include "planish/distributed/part_rows.h"
#include "planish/distributed/petsc_solve.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/solve/iteration.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

constexpr int kUnusable = static_cast<int>(ErrorCode::UnusableMesh);

MeshPart part_of(const Ranks& ranks, const PolygonMesh& mesh, std::int64_t block) {
  MeshSlice slice = scatter_mesh(ranks, mesh);
  CurveOrder order = order_along_curve(ranks, slice, block);
  FaceStream ring = send_first_ring(ranks, slice, order);
  return make_part(ranks, std::move(ring), slice, std::move(order));
}

using Row = std::vector<std::pair<std::int64_t, double>>;

// By the vertex's number in the file. A sum is named by -1, and its own entries follow.
std::map<std::int64_t, Row> rows_on_one(const PolygonMesh& mesh, const SharpFeatureOptions& sharp) {
  const MeshTopology topology(mesh);
  const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, sharp);
  const Subdivision subdivision(topology, features, Weights::DooSabin);
  const SummedTable table = summed_limit_masks(subdivision);
  std::map<std::int64_t, Row> rows;
  const auto add = [&](const StencilTable& from, std::int32_t i, Row& row,
                       const auto& self) -> void {
    for (std::int32_t k = from.offsets[i]; k < from.offsets[i] + from.sizes[i]; ++k) {
      const bool is_sum = from.indices[k] >= mesh.vertex_count();
      row.emplace_back(is_sum ? -1 : from.indices[k], from.weights[k]);
      if (is_sum) self(table.sums, from.indices[k] - mesh.vertex_count(), row, self);
    }
  };
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    Row row;
    add(table.rows, v, row, add);
    if (!row.empty()) rows[v] = std::move(row);
  }
  return rows;
}

std::map<std::int64_t, Row> rows_of(const MeshPart& part, const PartRows& rows) {
  std::map<std::int64_t, Row> result;
  const auto add = [&](const RowEntries& from, std::int32_t i, Row& row, const auto& self) -> void {
    for (std::int64_t k = from.offsets[i]; k < from.offsets[i + 1]; ++k) {
      const std::int32_t column = from.columns[k];
      if (column >= rows.first_sum()) {
        row.emplace_back(-1, from.weights[k]);
        self(rows.sums, column - rows.first_sum(), row, self);
        continue;
      }
      const std::int32_t local = column < part.owned_count()
                                     ? column
                                     : part.local_of(rows.ghosts[column - part.owned_count()]);
      row.emplace_back(part.file_ids[local], from.weights[k]);
    }
  };
  for (std::int32_t v = 0; v < rows.row_count(); ++v) {
    Row row;
    add(rows, v, row, add);
    if (!row.empty()) result[part.file_ids[v]] = std::move(row);
  }
  return result;
}

std::vector<std::pair<std::string, PolygonMesh>> shapes() {
  std::vector<std::pair<std::string, PolygonMesh>> shapes{{"cube", cube()},
                                                          {"mixed torus", mixed_torus(16, 8)},
                                                          {"bipyramid", bipyramid(40)},
                                                          {"64-gon", single_polygon(64)},
                                                          {"plate with a hole", plate_with_hole(9)},
                                                          {"L", l_shaped_plate(4)},
                                                          {"fan", open_fan(7)},
                                                          {"two components", prism(6)}};
  PolygonMesh& two = shapes.back().second;
  const PolygonMesh other = tetrahedron();
  const std::int32_t first = two.vertex_count();
  for (const glm::dvec3& p : other.positions) two.positions.push_back(p + glm::dvec3(5.0));
  for (std::int32_t f = 0; f < other.face_count(); ++f) {
    std::vector<std::int32_t> face(other.face(f).begin(), other.face(f).end());
    for (std::int32_t& v : face) v += first;
    two.add_face(face);
  }
  for (const std::uint32_t seed : {1u, 2u}) {
    shapes.emplace_back("random closed", random_closed_mesh(seed));
    shapes.emplace_back("random open", random_open_mesh(seed));
    shapes.emplace_back("creased", with_random_creases(random_open_mesh(seed), 0.2, seed));
    shapes.emplace_back(
        "relabelled",
        relabelled(with_random_creases(random_closed_mesh(seed), 0.3, seed), seed).mesh);
  }
  return shapes;
}

// All shapes side by side.
PolygonMesh all_shapes() {
  PolygonMesh all;
  for (const auto& [name, mesh] : shapes()) {
    const std::int32_t first = all.vertex_count();
    for (const glm::dvec3& p : mesh.positions)
      all.positions.push_back(p + glm::dvec3(0.1 * first, 0, 0));
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      std::vector<std::int32_t> face(mesh.face(f).begin(), mesh.face(f).end());
      for (std::int32_t& v : face) v += first;
      all.add_face(face);
    }
    for (const CreaseEdge& c : mesh.creases)
      all.creases.push_back({c.v0 + first, c.v1 + first, c.sharpness});
    for (const CornerVertex& c : mesh.corners)
      all.corners.push_back({c.vertex + first, c.sharpness});
  }
  return all;
}

// Boundaries, creases, corners, darts: the rows of one machine to the last bit, for every rank
// count and for small blocks.
TEST(PartRows, AreThoseOfOneMachine) {
  const PolygonMesh mesh = all_shapes();
  for (const auto& sharp :
       {SharpFeatureOptions{}, SharpFeatureOptions{BoundaryRule::EdgeAndCorner, false}}) {
    const auto expected = rows_on_one(mesh, sharp);
    for (const int count : kRankCounts)
      on_ranks(count, [&](const Ranks& ranks) {
        const MeshPart part = part_of(ranks, mesh, 7);
        const PartRows rows = make_rows(ranks, part, "mesh", mesh.face_count(),
                                        {.sharp = sharp, .block_vertices = 7});
        std::int64_t wrong = 0;
        for (const auto& [vertex, row] : rows_of(part, rows)) wrong += row != expected.at(vertex);
        EXPECT_EQ(wrong, 0) << "on " << count;
        EXPECT_EQ(sum_over(ranks, rows.row_count()), mesh.vertex_count());
      });
  }
}

// Two faces of 30,000 corners, whose masks were 1.8 thousand million entries.
TEST(PartRows, GrowAsTheCorners) {
  const PolygonMesh mesh = prism(30000);
  for (const int count : {1, 3})
    on_ranks(count, [&](const Ranks& ranks) {
      const MeshPart part = part_of(ranks, mesh, 4096);
      const PartRows rows =
          make_rows(ranks, part, "prism", mesh.face_count(), {.block_vertices = 4096});
      EXPECT_LE(rows.columns.size() + rows.sums.columns.size(), 5 * mesh.face_vertices.size());
    });
}

// A cube has fewer blocks and faces than there are ranks.
TEST(PartRows, RanksMayBeEmpty) {
  const PolygonMesh mesh = cube();
  const auto expected = rows_on_one(mesh, {});
  for (const std::int64_t block : {1, 4})
    on_ranks(8, [&](const Ranks& ranks) {
      const MeshPart part = part_of(ranks, mesh, block);
      const PartRows rows = make_rows(ranks, part, "cube", 6, {.block_vertices = block});
      for (const auto& [vertex, row] : rows_of(part, rows)) EXPECT_EQ(row, expected.at(vertex));
      EXPECT_EQ(sum_over(ranks, rows.row_count()), 8);
    });
}

// One ring of faces is what a row needs; without one rows at the rim are others, or the comparison
// would be blind. No row names a vertex with copies where there are two rings.
TEST(SubMesh, OneRingGivesTheBitsAndNoneDoesNot) {
  std::int64_t wrong_without = 0, copies = 0;
  for (const auto& [name, mesh] : shapes()) {
    const auto expected = rows_on_one(mesh, {});
    on_ranks(1, [&](const Ranks& ranks) {
      const MeshPart part = part_of(ranks, mesh, 1);
      SubMeshMaker maker(part);
      for (const Rings rings : {Rings::None, Rings::One, Rings::Two})
        for (std::int32_t begin = 0; begin < part.owned_count(); begin += 6) {
          const std::int32_t end = std::min(begin + 6, part.owned_count());
          const SubMesh sub = maker.make(begin, end, rings);
          if (sub.faces.empty()) continue;
          const auto made = rows_on_one(sub.mesh, {});
          for (const auto& [place, row] : made) {
            const std::int32_t v = sub.vertices[place];
            if (v < begin || v >= end) continue;
            Row named;
            for (const auto& [column, weight] : row)
              named.emplace_back(column < 0 ? -1 : part.file_ids[sub.vertices[column]], weight);
            if (rings == Rings::None) {
              wrong_without += named != expected.at(part.file_ids[v]);
            } else if (rings == Rings::Two) {
              EXPECT_EQ(named, expected.at(part.file_ids[v])) << name;
            } else if (sub.copy_count == 0) {
              EXPECT_EQ(named, expected.at(part.file_ids[v])) << name;
            }
          }
          copies += rings == Rings::Two ? sub.copy_count : 0;
        }
    });
  }
  if (is_first_rank()) {
    EXPECT_GT(wrong_without, 100);
    EXPECT_GT(copies, 0);  // vertices at a rim with several fans were met
  }
}

TEST(PartRows, UnusedVerticesGetNoRow) {
  PolygonMesh mesh = mixed_torus(8, 4);
  mesh.positions.insert(mesh.positions.begin() + 5, glm::dvec3(100.0));
  for (std::int32_t& v : mesh.face_vertices) v += v >= 5;
  mesh.positions.push_back({0, 0, -100});
  for (const int count : {1, 3})
    on_ranks(count, [&](const Ranks& ranks) {
      const MeshPart part = part_of(ranks, mesh, 5);
      const PartRows rows =
          make_rows(ranks, part, "mesh", mesh.face_count(), {.block_vertices = 5});
      std::int64_t empty = 0;
      for (std::int32_t v = 0; v < rows.row_count(); ++v) {
        if (rows.offsets[v] != rows.offsets[v + 1]) continue;
        ++empty;
        EXPECT_TRUE(part.file_ids[v] == 5 || part.file_ids[v] == mesh.vertex_count() - 1);
      }
      EXPECT_EQ(sum_over(ranks, empty), 2);
    });
}

// The messages of one machine, each once, wherever ranks and blocks are cut; the remedy is another.
void expect_refused_as_on_one(const PolygonMesh& mesh) {
  std::string expected = "no error";
  try {
    require_usable(mesh, "mesh");
  } catch (const Error& error) {
    expected = error.what();
  }
  EXPECT_NE(expected, "no error");
  expected = expected.substr(0, expected.find("; repair()")) +
             "; planish-mpi mends nothing, planish fit mends what it can";
  for (const auto& [block, count] : {std::pair{1, 8}, {3, 3}, {1000, 1}})
    on_ranks(count, [&, size = block, most = count](const Ranks& ranks) {
      const MeshPart part = part_of(ranks, mesh, size);
      const Outcome outcome = outcome_of([&] {
        (void)make_rows(ranks, part, "mesh", mesh.face_count(), {.block_vertices = size});
      });
      EXPECT_EQ(outcome.message, expected) << size << " on " << most;
      EXPECT_EQ(outcome.code, kUnusable);
    });
}

TEST(PartRows, ProblemsAreReportedOnceByTheFilesNumbers) {
  // Two cubes that share a vertex: more than one fan.
  PolygonMesh mesh = cube();
  const PolygonMesh other = cube();
  for (std::int32_t v = 1; v < other.vertex_count(); ++v)
    mesh.positions.push_back(other.positions[v] + glm::dvec3(-2.0));
  for (std::int32_t f = 0; f < other.face_count(); ++f) {
    std::vector<std::int32_t> face(other.face(f).begin(), other.face(f).end());
    // The second one's corner 7 is the first one's corner 0.
    for (std::int32_t& v : face) v = v == 7 ? 0 : v == 0 ? 14 : v + 7;
    mesh.add_face(face);
  }
  expect_refused_as_on_one(mesh);
  PolygonMesh third = mixed_torus(8, 4);
  third.positions.push_back({0, 0, 3});
  third.add_face(std::vector<std::int32_t>{0, 1, third.vertex_count() - 1});
  expect_refused_as_on_one(third);  // an edge with three faces
  PolygonMesh turned = mixed_torus(8, 4);
  std::reverse(turned.face_vertices.begin() + turned.face_offsets[5],
               turned.face_vertices.begin() + turned.face_offsets[6]);
  expect_refused_as_on_one(turned);
  PolygonMesh twice = mixed_torus(8, 4);
  const auto face = twice.face(3);
  twice.add_face(std::vector<std::int32_t>(face.begin(), face.end()));
  expect_refused_as_on_one(twice);
  PolygonMesh repeated = mixed_torus(8, 4);
  repeated.face_vertices[1] = repeated.face_vertices[0];
  expect_refused_as_on_one(repeated);
  PolygonMesh small = mixed_torus(8, 4);
  small.add_face(std::vector<std::int32_t>{3, 4});
  expect_refused_as_on_one(small);
  PolygonMesh beyond = mixed_torus(8, 4);
  beyond.positions.push_back({1, -2, HUGE_VAL});  // which no face names
  expect_refused_as_on_one(beyond);
}

TEST(PartRows, TagsAndWholeMeshesAreRefusedAsOnOneMachine) {
  PolygonMesh tagged = mixed_torus(8, 4);
  tagged.creases = {{0, 4, 10.0f}, {0, 9, 10.0f}, {31, 0, 10.0f}};
  tagged.positions.push_back({0, 0, 9});
  tagged.corners = {{1, 10.0f}, {tagged.vertex_count() - 1, 10.0f}};
  expect_refused_as_on_one(tagged);
  PolygonMesh flat = cube();
  for (glm::dvec3& p : flat.positions) p = {1, 2, 3};
  for (const int count : {1, 3})
    on_ranks(count, [&](const Ranks& ranks) {
      const auto refusal = [&](const PolygonMesh& mesh) {
        const MeshPart part = part_of(ranks, mesh, 2);
        return outcome_of([&] {
          (void)make_rows(ranks, part, "mesh", mesh.face_count(), {.block_vertices = 2});
        });
      };
      EXPECT_EQ(refusal(flat).code, kUnusable);
      EXPECT_EQ(refusal({}).message, std::string("mesh: ") + kNoFacesMessage);
    });
}

struct System {
  Layout layout;
  PartRows rows;
  std::vector<glm::dvec3> given;
  std::int64_t vertices = 0;
  std::vector<std::int64_t> file_ids;
};

System system_of(const Ranks& ranks, const PolygonMesh& mesh) {
  MeshSlice slice = scatter_mesh(ranks, mesh);
  CurveOrder order = order_along_curve(ranks, slice, 16);
  FaceStream ring = send_first_ring(ranks, slice, order);
  MeshPart part = make_part(ranks, std::move(ring), slice, std::move(order));
  System system;
  system.rows = make_rows(ranks, part, "mesh", mesh.face_count(), {.block_vertices = 16});
  system.layout = part.layout;
  system.file_ids.assign(part.file_ids.begin(), part.file_ids.begin() + part.owned_count());
  system.given.assign(part.positions.begin(), part.positions.begin() + part.owned_count());
  system.vertices = mesh.vertex_count();
  return system;
}

// The same system by PETSc's own matrices, of which MAIJ takes three columns at once.
std::vector<glm::dvec3> solved_by_maij(const Ranks& ranks, const System& system, int steps) {
  const PartRows& rows = system.rows;
  const PetscInt own = rows.row_count(), first = system.layout[ranks.rank];
  std::vector<PetscInt> offsets(rows.offsets.begin(), rows.offsets.end()), columns;
  for (const std::int32_t column : rows.columns)
    columns.push_back(column < own ? first + column : rows.ghosts[column - own]);
  Mat aij, maij;
  Vec b, d;
  KSP ksp;
  PC pc;
  MatCreateMPIAIJWithArrays(ranks.comm, own, own, PETSC_DETERMINE, PETSC_DETERMINE, offsets.data(),
                            columns.data(), rows.weights.data(), &aij);
  MatCreateMAIJ(aij, 3, &maij);
  VecCreateMPI(ranks.comm, 3 * own, PETSC_DETERMINE, &b);
  VecDuplicate(b, &d);
  double* values = nullptr;
  VecGetArrayWrite(b, &values);
  for (PetscInt v = 0; v < own; ++v) {
    glm::dvec3 sum(0.0);
    for (std::int64_t k = rows.offsets[v]; k < rows.offsets[v + 1]; ++k) {
      const std::int32_t c = rows.columns[k];
      sum += rows.weights[k] *
             (system.given[v] - (c < own ? system.given[c] : rows.ghost_points[c - own]));
    }
    for (int c = 0; c < 3; ++c) values[3 * v + c] = sum[c];
  }
  VecRestoreArrayWrite(b, &values);
  KSPCreate(ranks.comm, &ksp);
  KSPSetOperators(ksp, maij, maij);
  KSPGetPC(ksp, &pc);
  PCSetType(pc, PCNONE);
  KSPSetType(ksp, KSPCHEBYSHEV);
  KSPChebyshevSetEigenvalues(ksp, 1.0, rows.spectral_bound);
  KSPSetNormType(ksp, KSP_NORM_NONE);
  KSPSetConvergenceTest(ksp, KSPConvergedSkip, nullptr, nullptr);
  KSPSetTolerances(ksp, 0, 0, PETSC_DEFAULT, steps);
  KSPSolve(ksp, b, d);
  std::vector<glm::dvec3> result;
  const double* solved = nullptr;
  VecGetArrayRead(d, &solved);
  for (PetscInt v = 0; v < own; ++v)
    result.push_back({solved[3 * v], solved[3 * v + 1], solved[3 * v + 2]});
  VecRestoreArrayRead(d, &solved);
  KSPDestroy(&ksp);
  VecDestroy(&d);
  VecDestroy(&b);
  MatDestroy(&maij);
  MatDestroy(&aij);
  return result;
}

TEST(PetscSolve, AgreesWithPetscsOwnMatrices) {
  const PolygonMesh mesh = mixed_torus(32, 16);
  for (const int count : kRankCounts)
    on_ranks(count, [&](const Ranks& ranks) {
      const System system = system_of(ranks, mesh);
      // Unit coordinates differ from these by less than a factor of 4.
      const PetscSolution solution =
          petsc_solve(ranks, system.layout, system.rows, system.given, system.rows.ghost_points,
                      system.vertices, {.tolerance = 1e-6, .block_vertices = 16});
      EXPECT_TRUE(solution.converged);
      EXPECT_EQ(std::ssize(solution.history), solution.iterations + 1);
      const auto expected = solved_by_maij(ranks, system, solution.iterations);
      for (std::size_t v = 0; v < expected.size(); ++v)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(solution.displacement[v][c], expected[v][c], 1e-15);
    });
}

TEST(PetscSolve, PlainIterationIsThePapers) {
  const PolygonMesh mesh = mixed_torus(16, 8);
  on_ranks(1, [&](const Ranks& ranks) {
    const System system = system_of(ranks, mesh);
    const PetscSolution solution = petsc_solve(
        ranks, system.layout, system.rows, system.given, system.rows.ghost_points, system.vertices,
        {.solver = Solver::Plain, .tolerance = 1e-20, .max_iterations = 8, .block_vertices = 16});
    EXPECT_EQ(solution.iterations, 8);
    EXPECT_EQ(solution.stop_reason, StopReason::IterationLimit);
    // V <- V + (V0 - B V), eight times.
    std::vector<glm::dvec3> control = system.given;
    const PartRows& rows = system.rows;
    for (int step = 0; step < 8; ++step) {
      std::vector<glm::dvec3> next = control;
      for (std::int32_t v = 0; v < rows.row_count(); ++v) {
        glm::dvec3 limit(0.0);
        for (std::int64_t k = rows.offsets[v]; k < rows.offsets[v + 1]; ++k)
          limit += rows.weights[k] * control[rows.columns[k]];
        next[v] += system.given[v] - limit;
      }
      control = next;
    }
    for (std::size_t v = 0; v < control.size(); ++v)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(system.given[v][c] + solution.displacement[v][c], control[v][c], 1e-14);
  });
}

TEST(PetscSolve, AnUnreachableToleranceStagnates) {
  on_ranks(3, [&](const Ranks& ranks) {
    const System system = system_of(ranks, mixed_torus(16, 8));
    const PetscSolution solution =
        petsc_solve(ranks, system.layout, system.rows, system.given, system.rows.ghost_points,
                    system.vertices, {.tolerance = 1e-30, .block_vertices = 16});
    EXPECT_FALSE(solution.converged);
    EXPECT_EQ(solution.stop_reason, StopReason::Stagnated);
    EXPECT_LT(solution.error.max, 1e-15);
    const Outcome refused = outcome_of([&] {
      (void)petsc_solve(ranks, system.layout, system.rows, system.given, system.rows.ghost_points,
                        system.vertices, {.solver = Solver::ConjugateGradients});
    });
    EXPECT_EQ(refused.code, static_cast<int>(ErrorCode::InvalidArgument));
  });
}

}  // namespace
}  // namespace planish::test
