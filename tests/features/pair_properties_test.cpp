// Which triangles are joined is of the shape alone.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "features/shapes.h"
#include "planish/quads/pair_triangles.h"
#include "support/cut_quads.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

// A can of n sides, all in triangles: lids are fans around their middles.
PolygonMesh can(int n, double taper) {
  PolygonMesh mesh;
  for (const auto& [z, radius] : {std::pair(0.0, 1.0), {1.5, taper}}) {
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  }
  mesh.positions.emplace_back(0, 0, 0);
  mesh.positions.emplace_back(0, 0, 1.5);
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.add_face(std::array{i, j, n + j});
    mesh.add_face(std::array{i, n + j, n + i});
    mesh.add_face(std::array{j, i, 2 * n});
    mesh.add_face(std::array{n + i, n + j, 2 * n + 1});
  }
  return mesh;
}

PairedMesh joined(const PolygonMesh& mesh) {
  return with_paired_triangles(mesh, *prepare_mesh(mesh, "mesh"));
}

using FaceSets = std::set<std::set<std::int32_t>>;

// Faces as sets of the vertices that they were before `new_index` renamed them.
FaceSets faces_of_joined(const PolygonMesh& mesh, const std::vector<std::int32_t>& new_index = {}) {
  std::vector<std::int32_t> old(new_index.size());
  for (std::size_t v = 0; v < new_index.size(); ++v)
    old[new_index[v]] = static_cast<std::int32_t>(v);
  const PolygonMesh quads = joined(mesh).mesh;
  FaceSets faces;
  for (std::int32_t f = 0; f < quads.face_count(); ++f) {
    std::set<std::int32_t> face;
    for (const std::int32_t v : quads.face(f)) face.insert(old.empty() ? v : old[v]);
    faces.insert(face);
  }
  return faces;
}

std::vector<NamedMesh> triangle_meshes() {
  std::vector<NamedMesh> meshes;
  for (int n = 5; n <= 16; ++n)
    for (const double taper : {1.0, 0.6, 0.3})
      meshes.push_back({"can " + std::to_string(n) + ", " + std::to_string(taper), can(n, taper)});
  const PolygonMesh ring = cut_quads(torus(12, 8, 1, 0.4));
  meshes.push_back({"torus", ring});
  meshes.push_back({"uneven torus", jittered(ring, 0.05, 3)});
  meshes.push_back({"icosphere", icosphere(2)});
  meshes.push_back({"uneven icosphere", jittered(icosphere(2), 0.03, 5)});
  meshes.push_back({"bipyramid", bipyramid(8)});
  meshes.push_back({"sheet", cut_quads(flat_grid(5, 4))});
  return meshes;
}

TEST(PairedTriangles, AreThoseOfTheShapeAlone) {
  for (const auto& [name, mesh] : triangle_meshes()) {
    const FaceSets own = faces_of_joined(mesh);
    EXPECT_EQ(faces_of_joined(jittered(mesh, 1e-12, 7)), own) << name << ", moved by rounding";
    for (const double scale : {1e-3, 1e3})
      EXPECT_EQ(faces_of_joined(moved(mesh, [&](const auto& p) { return scale * p; })), own)
          << name << " x " << scale;
    EXPECT_EQ(faces_of_joined(turned(mesh)), own) << name << ", turned";
    EXPECT_EQ(faces_of_joined(mirrored(mesh)), own) << name << ", mirrored";
    for (const std::uint32_t seed : {1u, 2u}) {
      const Relabelled other = relabelled(mesh, seed);
      EXPECT_EQ(faces_of_joined(other.mesh, other.new_index), own) << name << ", in another order";
    }
  }
}

TEST(PairedTriangles, AreAllOfABandAndNoneOfAFan) {
  for (int n = 5; n <= 16; ++n)
    for (const double taper : {1.0, 0.6, 0.3}) {
      const PairedMesh result = joined(can(n, taper));
      EXPECT_EQ(result.pair_count, n) << n << ", " << taper;
      EXPECT_EQ(result.mesh.face_count(), 3 * n);
    }
}

}  // namespace
}  // namespace planish::test
