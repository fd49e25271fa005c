#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <opensubdiv/far/topologyLevel.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/sound_topology.h"
#include "planish/solve/refiner.h"
#include "support/meshes.h"
#include "support/opensubdiv_topology.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

using test::NamedMesh;

std::vector<std::int32_t> listed(const OpenSubdiv::Vtr::ConstIndexArray& values) {
  return {values.begin(), values.end()};
}
std::vector<std::int32_t> listed(std::span<const std::int32_t> values) {
  return {values.begin(), values.end()};
}

std::vector<NamedMesh> meshes() {
  std::vector<NamedMesh> all = {{"tetrahedron", test::tetrahedron()},
                                {"torus", test::torus(24, 12, 2, 0.5)},
                                {"split edges", test::cube_with_split_edges()},
                                {"plate with a hole", test::plate_with_hole(7)},
                                {"pole of 100", test::bipyramid(100)},
                                {"open pole of 100", test::open_fan(100)},
                                {"polygon", test::single_polygon(70)},
                                {"icosphere", test::icosphere(5)}};
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    all.push_back({"closed " + std::to_string(seed),
                   test::relabelled(test::random_closed_mesh(seed), seed).mesh});
    all.push_back({"open " + std::to_string(seed),
                   test::relabelled(test::random_open_mesh(seed), seed).mesh});
  }
  for (const auto& entry : std::filesystem::directory_iterator(PLANISH_SCENES)) {
    if (entry.path().extension() != ".obj") continue;
    const std::string name = entry.path().filename().string();
    all.push_back({name, read_mesh(entry.path()).mesh});
  }
  return all;
}

TEST(MeshTopology, EqualsOpenSubdivsLevelZero) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    const MeshTopology topology(mesh);
    const auto refiner = test::descriptor_refiner(mesh, {});
    const auto& level = refiner->GetLevel(0);
    ASSERT_EQ(topology.vertex_count(), level.GetNumVertices());
    ASSERT_EQ(topology.edge_count(), level.GetNumEdges());
    ASSERT_EQ(topology.face_count(), level.GetNumFaces());
    ASSERT_EQ(topology.corner_count(), level.GetNumFaceVertices());
    for (std::int32_t f = 0; f < topology.face_count(); ++f) {
      ASSERT_EQ(listed(topology.face(f)), listed(level.GetFaceVertices(f)));
      ASSERT_EQ(listed(topology.face_edges(f)), listed(level.GetFaceEdges(f)));
    }
    for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
      const auto [v0, v1] = topology.edge_vertices(e);
      ASSERT_EQ((std::vector{v0, v1}), listed(level.GetEdgeVertices(e)));
      ASSERT_EQ(topology.is_boundary_edge(e), level.IsEdgeBoundary(e));
      ASSERT_EQ(topology.find_edge(v1, v0), e);
      const std::int32_t corner = topology.corner_of(e);
      std::vector<std::int32_t> faces{topology.face_of(corner)};
      if (!topology.is_boundary_edge(e)) faces.push_back(topology.face_of(topology.twin(corner)));
      ASSERT_EQ(faces, listed(level.GetEdgeFaces(e)));
    }
    for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
      std::vector<std::int32_t> faces, places;
      for (const std::int32_t corner : topology.corners_at(v)) {
        faces.push_back(topology.face_of(corner));
        places.push_back(topology.place_of(corner));
      }
      ASSERT_EQ(faces, listed(level.GetVertexFaces(v)));
      const auto local = level.GetVertexFaceLocalIndices(v);
      ASSERT_EQ(places, std::vector<std::int32_t>(local.begin(), local.end()));
      ASSERT_EQ(topology.is_boundary_vertex(v), level.IsVertexBoundary(v));
      ASSERT_EQ(topology.valence(v), level.GetVertexEdges(v).size());
    }
  }
}

TEST(MeshTopology, StepsAroundFacesEdgesAndVertices) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    const MeshTopology topology(mesh);
    for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
      ASSERT_EQ(topology.prev(topology.next(c)), c);
      ASSERT_EQ(topology.face_of(topology.next(c)), topology.face_of(c));
      const std::int32_t twin = topology.twin(c);
      if (twin < 0) continue;
      ASSERT_EQ(topology.twin(twin), c);
      ASSERT_EQ(topology.vertex_of(twin), topology.vertex_of(topology.next(c)));
      ASSERT_EQ(topology.edge_of(twin), topology.edge_of(c));
      ASSERT_EQ(topology.ccw(topology.cw(c)), c);
    }
    for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
      const auto corners = topology.corners_at(v);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        ASSERT_EQ(topology.vertex_of(corners[i]), v);
        const bool last = i + 1 == corners.size();
        ASSERT_EQ(topology.ccw(corners[i]), !last                            ? corners[i + 1]
                                            : topology.is_boundary_vertex(v) ? -1
                                                                             : corners[0]);
      }
    }
  }
}

TEST(MeshTopology, IsTheSameForEveryThreadCount) {
  const PolygonMesh mesh = test::relabelled(test::icosphere(6), 7).mesh;
  const MeshTopology many(mesh);
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const MeshTopology few(mesh);
  for (std::int32_t c = 0; c < many.corner_count(); ++c) {
    ASSERT_EQ(many.twin(c), few.twin(c));
    ASSERT_EQ(many.edge_of(c), few.edge_of(c));
  }
  for (std::int32_t v = 0; v < many.vertex_count(); ++v)
    ASSERT_EQ(listed(many.corners_at(v)), listed(few.corners_at(v)));
}

TEST(MeshTopology, LeavesUnusedVerticesWithoutCorners) {
  PolygonMesh mesh = test::flat_grid(2, 1);
  mesh.positions.emplace_back(9, 9, 9);
  const MeshTopology topology(mesh);
  EXPECT_EQ(topology.vertex_count(), 7);
  EXPECT_TRUE(topology.corners_at(6).empty());
  EXPECT_FALSE(topology.is_boundary_vertex(6));
  EXPECT_EQ(topology.valence(6), 0);
  EXPECT_EQ(topology.find_edge(6, 0), -1);
  EXPECT_EQ(topology.find_edge(0, 7), -1);
  EXPECT_EQ(topology.find_edge(-1, 0), -1);
  EXPECT_EQ(topology.find_edge(0, 4), -1);  // a diagonal
}

// Three faces at an edge, two of one direction, two fans at a vertex.
TEST(MeshTopology, RefusesWhatIsNoManifold) {
  for (const int valence : {3, 40}) {
    const PolygonMesh fan = test::open_fan(valence);
    const std::int32_t hub = valence, other = fan.vertex_count();
    EXPECT_TRUE(MeshTopology::if_manifold(fan));

    PolygonMesh wound = fan;
    wound.positions.emplace_back(0, 0, 1);
    wound.add_face(std::array{hub, 0, other});
    EXPECT_FALSE(MeshTopology::if_manifold(wound)) << valence;

    PolygonMesh three = fan;
    three.positions.emplace_back(0, 0, 1);
    three.positions.emplace_back(0, 0, -1);
    three.add_face(std::array{1, 0, other});
    EXPECT_TRUE(MeshTopology::if_manifold(three)) << valence;
    three.add_face(std::array{1, 0, other + 1});
    EXPECT_FALSE(MeshTopology::if_manifold(three)) << valence;

    PolygonMesh two_fans = fan;
    two_fans.positions.emplace_back(0, 0, 1);
    two_fans.positions.emplace_back(0, 1, 1);
    two_fans.add_face(std::array{hub, other, other + 1});
    EXPECT_FALSE(MeshTopology::if_manifold(two_fans)) << valence;
    EXPECT_THROW(MeshTopology{two_fans}, Error);
  }
}

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

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

template <class Array>
std::vector<int> listed_array(const Array& values) {
  return {values.begin(), values.end()};
}

void expect_same_level(const Far::TopologyLevel& a, const Far::TopologyLevel& b) {
  ASSERT_EQ(a.GetNumVertices(), b.GetNumVertices());
  ASSERT_EQ(a.GetNumEdges(), b.GetNumEdges());
  ASSERT_EQ(a.GetNumFaces(), b.GetNumFaces());
  ASSERT_EQ(a.GetNumFVarChannels(), b.GetNumFVarChannels());
  for (int f = 0; f < a.GetNumFaces(); ++f) {
    ASSERT_EQ(listed_array(a.GetFaceVertices(f)), listed_array(b.GetFaceVertices(f)));
    ASSERT_EQ(listed_array(a.GetFaceEdges(f)), listed_array(b.GetFaceEdges(f)));
    if (a.GetNumFVarChannels() == 0) continue;
    ASSERT_EQ(listed_array(a.GetFaceFVarValues(f)), listed_array(b.GetFaceFVarValues(f)));
  }
  for (int e = 0; e < a.GetNumEdges(); ++e) {
    ASSERT_EQ(listed_array(a.GetEdgeVertices(e)), listed_array(b.GetEdgeVertices(e)));
    ASSERT_EQ(listed_array(a.GetEdgeFaces(e)), listed_array(b.GetEdgeFaces(e)));
    ASSERT_EQ(listed_array(a.GetEdgeFaceLocalIndices(e)),
              listed_array(b.GetEdgeFaceLocalIndices(e)));
    ASSERT_EQ(a.GetEdgeSharpness(e), b.GetEdgeSharpness(e));
  }
  for (int v = 0; v < a.GetNumVertices(); ++v) {
    ASSERT_EQ(listed_array(a.GetVertexFaces(v)), listed_array(b.GetVertexFaces(v)));
    ASSERT_EQ(listed_array(a.GetVertexEdges(v)), listed_array(b.GetVertexEdges(v)));
    ASSERT_EQ(listed_array(a.GetVertexFaceLocalIndices(v)),
              listed_array(b.GetVertexFaceLocalIndices(v)));
    ASSERT_EQ(listed_array(a.GetVertexEdgeLocalIndices(v)),
              listed_array(b.GetVertexEdgeLocalIndices(v)));
    ASSERT_EQ(a.GetVertexSharpness(v), b.GetVertexSharpness(v));
    ASSERT_EQ(a.GetVertexRule(v), b.GetVertexRule(v));
  }
}

// With texture coordinates that are cut at every third corner, and missing at some.
PolygonMesh textured(PolygonMesh mesh) {
  for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c) {
    if (c % 3 == 0) {
      mesh.face_uvs.push_back(static_cast<std::int32_t>(mesh.uvs.size()));
      mesh.uvs.emplace_back(double(c), 1.0);
    } else {
      mesh.face_uvs.push_back(static_cast<std::int32_t>(mesh.uvs.size()) - 1);
    }
    if (c % 17 == 5) mesh.face_uvs.back() = -1;
  }
  return mesh;
}

TEST(MakeRefiner, EqualsTheRefinerThatFindsEdgesItself) {
  for (std::uint32_t seed = 0; seed < 8; ++seed) {
    PolygonMesh mesh =
        seed % 2 == 0 ? test::random_closed_mesh(seed) : test::random_open_mesh(seed);
    mesh = textured(test::with_random_creases(test::relabelled(mesh, seed).mesh, 0.3, seed));
    mesh.creases.front().sharpness = 2.5f;
    mesh.creases.push_back({mesh.creases.front().v1, mesh.creases.front().v0, 3.5f});
    mesh.corners = {{3, 10.0f}, {4, 1.5f}};
    for (const auto scheme : {Sdc::SCHEME_BILINEAR, Sdc::SCHEME_CATMARK}) {
      for (const bool use_tags : {true, false}) {
        SCOPED_TRACE(seed);
        RefinerOptions options{scheme, {}};
        options.sharp.use_tags = use_tags;
        const auto made = make_refiner(mesh, options, MeshTopology(mesh));
        const auto expected = test::descriptor_refiner(mesh, options);
        Far::TopologyRefiner::UniformOptions uniform(2);
        uniform.fullTopologyInLastLevel = true;
        made->RefineUniform(uniform);
        expected->RefineUniform(uniform);
        for (int level = 0; level <= 2; ++level)
          expect_same_level(made->GetLevel(level), expected->GetLevel(level));
      }
    }
  }
}

}  // namespace
}  // namespace planish

namespace planish::test {
namespace {

// A triangle and a pentagon that share an edge: mixed sizes and a boundary.
PolygonMesh triangle_and_pentagon() {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}};
  mesh.add_face(std::array{0, 1, 2});
  mesh.add_face(std::array{1, 3, 4, 5, 2});
  return mesh;
}

TEST(QuadSplit, CountsEqualOpenSubdivsLevels) {
  QuadSplit split(triangle_and_pentagon());
  split.refine(4);
  ASSERT_EQ(split.level_count(), 4);
  for (int l = 0; l <= 4; ++l) {
    const LevelCounts counts = split.counts(l);
    EXPECT_EQ(counts.vertices, split.level(l).GetNumVertices());
    EXPECT_EQ(counts.faces, split.level(l).GetNumFaces());
    if (l < 4) {
      EXPECT_EQ(counts.edges, split.level(l).GetNumEdges());
    }
  }
}

TEST(QuadSplit, ChildFacesFollowTheirParentsCorners) {
  QuadSplit split(triangle_and_pentagon());
  split.refine(3);
  for (int l = 0; l < 3; ++l) {
    const auto& parent = split.level(l);
    const auto& child = split.level(l + 1);
    for (int f = 0; f < parent.GetNumFaces(); ++f) {
      const auto vertices = parent.GetFaceVertices(f);
      const auto children = parent.GetFaceChildFaces(f);
      ASSERT_EQ(children.size(), vertices.size());
      for (int i = 0; i < vertices.size(); ++i) {
        EXPECT_EQ(children[i], split.first_corner(l, f) + i);
        const auto corners = child.GetFaceVertices(children[i]);
        EXPECT_EQ(std::count(corners.begin(), corners.end(), vertices[i]), 1)
            << "a child face has the vertex of its corner, with the same index";
      }
    }
  }
}

TEST(QuadSplit, FacesAroundAVertexComeCounterClockwise) {
  QuadSplit split(triangle_and_pentagon());
  split.refine(2);
  for (int l = 0; l < 2; ++l) {
    const auto& level = split.level(l);
    for (int v = 0; v < level.GetNumVertices(); ++v) {
      const auto faces = level.GetVertexFaces(v);
      const auto corners = level.GetVertexFaceLocalIndices(v);
      for (int i = 0; i + 1 < faces.size(); ++i) {
        const auto edges = level.GetFaceEdges(faces[i]);
        const int trailing = edges[(corners[i] + edges.size() - 1) % edges.size()];
        EXPECT_EQ(trailing, level.GetFaceEdges(faces[i + 1])[corners[i + 1]]);
      }
      if (level.IsVertexBoundary(v)) {
        EXPECT_TRUE(level.IsEdgeBoundary(level.GetFaceEdges(faces[0])[corners[0]]));
      }
    }
  }
}

TEST(QuadSplit, KeepsCreaseTagsAsSharpness) {
  PolygonMesh mesh = triangle_and_pentagon();
  mesh.creases = {{2, 1, kInfiniteSharpness}};
  const QuadSplit split(mesh);
  const auto& base = split.level(0);
  int sharp = 0;
  for (int e = 0; e < base.GetNumEdges(); ++e) {
    if (base.IsEdgeBoundary(e) || base.GetEdgeSharpness(e) < kInfiniteSharpness) continue;
    ++sharp;
    const auto ends = base.GetEdgeVertices(e);
    EXPECT_EQ(std::min(ends[0], ends[1]), 1);
    EXPECT_EQ(std::max(ends[0], ends[1]), 2);
  }
  EXPECT_EQ(sharp, 1);
}

TEST(QuadSplit, RefinesAgainAfterwards) {
  QuadSplit split(triangle_and_pentagon());
  split.refine(2);
  split.refine(0);
  EXPECT_EQ(split.level_count(), 0);
  split.refine(1);
  EXPECT_EQ(split.level_count(), 1);
  EXPECT_EQ(split.level(1).GetNumFaces(), 8);
}

}  // namespace
}  // namespace planish::test
