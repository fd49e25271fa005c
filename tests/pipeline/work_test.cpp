// Every mesh takes work of the order of its corners: counts, not times, of hubs and large faces at
// two sizes each. Whatever asks all of a ring for each of its corners is caught by the larger one.
#include "planish/core/work.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include "planish/measure/figures.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;

constexpr int kSmall = 300, kLarge = 3000;

using Counts = std::array<double, kWorkKinds>;  // products, points and pairs

dvec3 on_circle(int i, int n, double radius, double z) {
  const double angle = 2 * std::numbers::pi * i / n;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

// n quads between two fans of n triangles.
PolygonMesh fans(int n) {
  PolygonMesh mesh;
  for (const double z : {0.0, 1.0})
    for (int i = 0; i < n; ++i) mesh.positions.push_back(on_circle(i, n, 1, z));
  mesh.positions.insert(mesh.positions.end(), {dvec3(0, 0, -0.2), dvec3(0, 0, 1.2)});
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    mesh.add_face(std::array{i, next, n + next, n + i});
    mesh.add_face(std::array{next, i, 2 * n});
    mesh.add_face(std::array{n + i, n + next, 2 * n + 1});
  }
  return mesh;
}

// A face of n corners with triangles on its edges, as many again between these.
PolygonMesh wreath(int n) {
  PolygonMesh mesh;
  std::vector<std::int32_t> face;
  for (int i = 0; i < n; ++i) {
    mesh.positions.push_back(on_circle(i, n, 1, 0));
    face.push_back(i);
  }
  for (int i = 0; i < n; ++i) mesh.positions.push_back(on_circle(2 * i + 1, 2 * n, 1.2, 0.1));
  mesh.add_face(face);
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    mesh.add_face(std::array{next, i, n + i});
    mesh.add_face(std::array{next, n + i, n + next});
  }
  return mesh;
}

// The hub of n faces on a crease that runs over two of its edges.
PolygonMesh creased_hub(int n) {
  PolygonMesh mesh = bipyramid(n);
  const std::int32_t hub = mesh.vertex_count() - 1;
  std::vector<std::int32_t> ring;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const auto at = std::ranges::find(face, hub);
    if (at == face.end()) continue;
    ring.push_back(face[static_cast<std::size_t>(at - face.begin() + 1) % face.size()]);
  }
  for (const std::size_t i : {std::size_t{0}, ring.size() / 2})
    mesh.creases.push_back({hub, ring[i], kInfiniteSharpness});
  return mesh;
}

// k x k fans of 100 triangles, each over a square with 25 edges a side.
PolygonMesh hubs_of_a_hundred(int k) {
  constexpr int kSide = 25;
  const int side = k * kSide;
  PolygonMesh mesh;
  std::vector<std::int32_t> at((side + 1) * (side + 1), -1);
  const auto vertex = [&](int x, int y) {
    std::int32_t& v = at[y * (side + 1) + x];
    if (v < 0) {
      v = mesh.vertex_count();
      mesh.positions.emplace_back(x, y, 3 * std::sin(0.1 * x) * std::cos(0.1 * y));
    }
    return v;
  };
  for (int j = 0; j < k; ++j) {
    for (int i = 0; i < k; ++i) {
      std::vector<std::int32_t> ring;
      const int x = i * kSide, y = j * kSide;
      for (int s = 0; s < kSide; ++s) ring.push_back(vertex(x + s, y));
      for (int s = 0; s < kSide; ++s) ring.push_back(vertex(x + kSide, y + s));
      for (int s = 0; s < kSide; ++s) ring.push_back(vertex(x + kSide - s, y + kSide));
      for (int s = 0; s < kSide; ++s) ring.push_back(vertex(x, y + kSide - s));
      const std::int32_t hub = mesh.vertex_count();
      mesh.positions.emplace_back(x + kSide / 2.0, y + kSide / 2.0, 1);
      for (std::size_t s = 0; s < ring.size(); ++s)
        mesh.add_face(std::array{ring[s], ring[(s + 1) % ring.size()], hub});
    }
  }
  return mesh;
}

// Three parts with hubs of n slivers that cross each other, as unions of solids leave them.
PolygonMesh crossing_slivers(int n) {
  PolygonMesh mesh;
  for (int part = 0; part < 3; ++part) {
    const PolygonMesh one = fans(n);
    for (std::int32_t f = 0; f < one.face_count(); ++f) {
      std::vector<std::int32_t> face;
      for (const std::int32_t v : one.face(f)) face.push_back(v + mesh.vertex_count());
      mesh.add_face(face);
    }
    for (dvec3 p : one.positions) {
      // Hubs beside the middle: slivers of all lengths.
      if (p.x == 0 && p.y == 0) p.x = 0.9;
      std::array<double, 3> c{p.x, p.y, p.z - 0.5};
      std::ranges::rotate(c, c.begin() + part);
      mesh.positions.emplace_back(c[0] + 0.1 * part, c[1], c[2]);
    }
  }
  return mesh;
}

// A wavy polygon as the two faces of a drum: concave.
PolygonMesh gear(int n) {
  PolygonMesh mesh = prism(n);
  for (dvec3& p : mesh.positions) {
    const double factor = 1 + 0.2 * std::cos(7 * std::atan2(p.y, p.x));
    p.x *= factor;
    p.y *= factor;
  }
  return mesh;
}

// One face of n corners, each at its boundary.
PolygonMesh leaf(int n) {
  PolygonMesh mesh;
  std::vector<std::int32_t> face;
  for (int i = 0; i < n; ++i) {
    mesh.positions.push_back(on_circle(i, n, 1 + 0.1 * std::cos(6.0 * i / n), 0));
    face.push_back(i);
  }
  mesh.add_face(face);
  return mesh;
}

// A hub of n quads whose neighbours, all of four quads, are out of balance.
PolygonMesh hub_of_quads(int n) {
  PolygonMesh mesh;
  mesh.positions.emplace_back(0, 0, 0);
  const auto add_ring = [&](int count, const auto& at) {
    const std::int32_t first = mesh.vertex_count();
    for (int i = 0; i < count; ++i) mesh.positions.push_back(at(i));
    return first;
  };
  const std::int32_t rim = add_ring(n, [&](int i) {
    const double turned = 2 * std::numbers::pi * (i % 2 == 0 ? i : i + 0.9) / n;
    const double radius = i % 2 == 0 ? 0.3 : 1;
    return dvec3(radius * std::cos(turned), radius * std::sin(turned), 0.02 * (i % 3));
  });
  const std::int32_t middle =
      add_ring(n, [&](int i) { return on_circle(2 * i + 1, 2 * n, 1.02, 0.01); });
  const std::int32_t inner = add_ring(2 * n, [&](int i) { return on_circle(i, 2 * n, 1.2, 0); });
  const std::int32_t outer = add_ring(2 * n, [&](int i) { return on_circle(i, 2 * n, 1.5, 0); });
  for (int i = 0; i < n; ++i) mesh.add_face(std::array{0, rim + i, middle + i, rim + (i + 1) % n});
  const auto around = [&](int i) { return i % 2 == 0 ? rim + i / 2 % n : middle + i / 2; };
  for (int i = 0; i < 2 * n; ++i) {
    const int next = (i + 1) % (2 * n);
    mesh.add_face(std::array{around(i), inner + i, inner + next, around(next)});
    mesh.add_face(std::array{inner + i, outer + i, outer + next, inner + next});
  }
  return mesh;
}

// Two hubs whose edges all turn, up and down in turns: a square where each is held against all.
PolygonMesh folded_hubs(int n) {
  PolygonMesh mesh = bipyramid(n);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    dvec3& p = mesh.positions[v];
    const double wave = (v % 2 == 0 ? 3 : -3) * std::numbers::pi / n;
    if (p.x != 0 || p.y != 0) p = {p.x * (1 + wave), p.y * (1 + wave), wave};
  }
  return mesh;
}

// A plate whose outline is a comb of n / 4 teeth, a strip of long needles.
PolygonMesh comb(int n) {
  const int teeth = n / 4;
  std::vector<std::array<double, 2>> outline{{0, 0}};
  for (int i = 0; i < teeth; ++i)
    for (const auto& [x, y] : {std::array{0.0, 1.0}, {0.4, 1.0}, {0.4, 0.2}, {1.0, 0.2}})
      outline.push_back({(i + x) / teeth, y});
  outline.push_back({1, 0});
  const auto count = static_cast<std::int32_t>(outline.size());
  PolygonMesh mesh;
  std::vector<std::int32_t> bottom, top;
  for (const double z : {0.0, 0.2})
    for (const auto& [x, y] : outline) mesh.positions.emplace_back(x, y, z);
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t next = (i + 1) % count;
    mesh.add_face(std::array{next, i, count + i, count + next});
    bottom.push_back(i);
    top.push_back(2 * count - 1 - i);
  }
  mesh.add_face(bottom);
  mesh.add_face(top);
  return mesh;
}

struct Case {
  const char* name;
  PolygonMesh (*make)(int);
  // For a corner of the mesh, twice to four times what there is: the nets that are made again where
  // a surface folds, 13 at most, come and go with small changes.
  Counts most;
  int small = kSmall, large = kLarge;
};
std::ostream& operator<<(std::ostream& out, const Case& of) { return out << of.name; }

// For a corner of the mesh, of all that the default does up to the rows of level 2.
Counts work_of(const PolygonMesh& mesh) {
  Counts work{};
  for (std::size_t k = 0; k < kWorkKinds; ++k) work[k] = -static_cast<double>(work_counts[k]);
  const auto backend = make_cpu_backend();
  const FittedMesh fitted = fit_mesh(mesh, "mesh", *backend);
  EXPECT_TRUE(fitted.fit.interpolation.converged);
  if (fitted.fit.fair) {
    const FairRounds& rounds = fitted.fit.fair->rounds;
    EXPECT_LE(rounds.nets, 13);
    EXPECT_LE(rounds.repair.value_or(0), 6);
    EXPECT_LE(rounds.cure.value_or(0), 6);
  }
  const auto surface = fitted_surface(fitted.mesh, fitted.fit, fitted.evaluate_options());
  (void)surface_quality(*surface->level(2), fitted.mesh,
                        folded_edges(fitted.mesh, *fitted.fit.prepared->topology).is_beside, {});
  for (std::size_t k = 0; k < kWorkKinds; ++k)
    work[k] = (work[k] + static_cast<double>(work_counts[k])) /
              static_cast<double>(mesh.face_vertices.size());
  return work;
}

class WorkOf : public testing::TestWithParam<Case> {};

TEST_P(WorkOf, GrowsAsTheCornersDo) {
  for (const int n : {GetParam().small, GetParam().large}) {
    const auto work = work_of(GetParam().make(n));
    for (std::size_t k = 0; k < kWorkKinds; ++k) {
      EXPECT_LE(work[k], GetParam().most[k]) << "of kind " << k << " a corner, n = " << n;
      RecordProperty("n" + std::to_string(n) + "_kind" + std::to_string(k),
                     std::to_string(work[k]));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Meshes, WorkOf,
    testing::Values(Case{"fans", fans, {1500, 30, 12}},
                    Case{"bipyramid", bipyramid, {2000, 120, 12}},
                    Case{"drum", prism, {2000, 100, 12}}, Case{"wreath", wreath, {1000, 10, 12}},
                    Case{"creased_hub", creased_hub, {3200, 200, 12}},
                    Case{"folded_hubs", folded_hubs, {1500, 100, 50}},
                    Case{"chamfered_prism", chamfered_prism, {1500, 10, 40}},
                    // Chords are tried against a few places of each part: a sum that has an end.
                    Case{"comb", comb, {2500, 10, 600}}, Case{"leaf", leaf, {1500, 20, 40}},
                    Case{"hub_of_quads", hub_of_quads, {3000, 100, 60}},
                    Case{"hub_on_boundary", open_fan, {900, 10, 12}},
                    // Vertices are added to it, three times as many.
                    Case{"hubs_of_a_hundred", hubs_of_a_hundred, {2500, 20, 12}, 2, 10},
                    Case{"crossing_slivers", crossing_slivers, {18'000, 400, 50}, 100, 1000},
                    Case{"gear", gear, {24'000, 500, 60}}),
    [](const auto& one) { return std::string(one.param.name); });

// Rings of any size are counted: the bounds above would let nothing pass otherwise.
TEST(Work, IsCounted) {
  const auto work = work_of(bipyramid(kSmall));
  for (const Work kind : {Work::Products, Work::Points})
    EXPECT_GT(work[static_cast<std::size_t>(kind)], 1);
}

}  // namespace
}  // namespace planish::test
