#include "planish/mesh/sound_topology.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>

#include "planish/mesh/mesh_topology.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

// One change of the kind that files bring.
void damage(PolygonMesh& mesh, std::mt19937& random) {
  const auto any = [&](std::size_t count) {
    return static_cast<std::int32_t>(
        std::uniform_int_distribution<std::size_t>(0, count - 1)(random));
  };
  const std::int32_t corner = any(mesh.face_vertices.size());
  const std::int32_t face = any(static_cast<std::size_t>(mesh.face_count()));
  const std::vector<std::int32_t> copy(mesh.face(face).begin(), mesh.face(face).end());
  switch (any(11)) {
    case 0:
      mesh.face_vertices[corner] = any(mesh.positions.size());
      break;
    case 1:
      mesh.face_vertices[corner] = mesh.vertex_count() + any(3) - 1;
      break;
    case 2:
      mesh.face_vertices[corner] = -1;
      break;
    case 3:
      mesh.add_face(copy);
      break;
    case 4:
      mesh.add_face(std::vector(copy.rbegin(), copy.rend()));
      break;
    case 5:
      mesh.positions[any(mesh.positions.size())].y = std::numeric_limits<double>::quiet_NaN();
      break;
    case 6:
      mesh.face_offsets[face] += any(3) - 1;
      break;
    case 7:
      mesh.creases.push_back({any(mesh.positions.size()), any(mesh.positions.size())});
      break;
    case 8:
      mesh.corners.push_back({any(mesh.positions.size() + 1) - 1});
      break;
    case 9:
      mesh.positions.emplace_back(1, 2, 3);  // unused: no problem
      break;
    case 10:
      mesh.add_face(std::array{any(mesh.positions.size()), any(mesh.positions.size()),
                               any(mesh.positions.size())});
      break;
    default:
      break;
  }
}

TEST(SoundTopology, IsThereExactlyWhereNoProblemIsListed) {
  std::mt19937 random(5);
  int sound = 0, unsound = 0;
  for (std::uint32_t seed = 0; seed < 400; ++seed) {
    PolygonMesh mesh = seed % 3 == 0   ? test::random_closed_mesh(seed)
                       : seed % 3 == 1 ? test::random_open_mesh(seed)
                                       : test::bipyramid(3 + static_cast<int>(seed % 40));
    for (std::uint32_t i = 0; i <= seed % 2; ++i) damage(mesh, random);
    const bool expected = list_problems(mesh).empty();
    (expected ? sound : unsound) += 1;
    ASSERT_EQ(sound_topology(mesh).has_value(), expected) << seed;
  }
  EXPECT_GT(sound, 40);
  EXPECT_GT(unsound, 100);
}

TEST(PrepareMesh, NumbersTheVerticesInUse) {
  PolygonMesh mesh = test::flat_grid(2, 1);
  mesh.positions.insert(mesh.positions.begin() + 1, glm::dvec3(7, 7, 7));
  for (std::int32_t& v : mesh.face_vertices) v += v > 0 ? 1 : 0;
  mesh.corners = {{2}};
  const auto prepared = prepare_mesh(mesh, "grid");
  EXPECT_FALSE(prepared->uses_all());
  EXPECT_EQ(std::vector<std::int32_t>(prepared->vertices.begin(), prepared->vertices.end()),
            (std::vector<std::int32_t>{0, 2, 3, 4, 5, 6}));
  const UsedPart used = used_part(mesh, prepared);
  EXPECT_EQ(used.mesh.vertex_count(), 6);
  EXPECT_EQ(used.mesh.corners.front().vertex, 1);
  EXPECT_EQ(used.mesh.face_vertices, test::flat_grid(2, 1).face_vertices);
  EXPECT_EQ(prepared->topology->vertex_count(), 6);

  const PolygonMesh whole = test::flat_grid(2, 1);
  EXPECT_EQ(&used_part(whole, prepare_mesh(whole, "grid")).mesh, &whole) << "nothing is copied";
}

}  // namespace
}  // namespace planish
