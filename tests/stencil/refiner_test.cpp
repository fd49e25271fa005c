#include "planish/solve/refiner.h"

#include <gtest/gtest.h>
#include <opensubdiv/far/topologyLevel.h>

#include <vector>

#include "support/descriptor_refiner.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

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
