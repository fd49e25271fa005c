#include "support/opensubdiv_topology.h"

#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <cstdint>
#include <vector>

#include "planish/core/guards.h"
#include "planish/solve/refiner.h"

namespace planish::test {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

namespace {

// The tags in the arrays that a descriptor points to.
struct Tags {
  std::vector<int> edges, vertices;
  std::vector<float> edge_sharpness, vertex_sharpness;

  explicit Tags(const PolygonMesh& mesh) {
    for (const CreaseEdge& crease : mesh.creases) {
      edges.insert(edges.end(), {crease.v0, crease.v1});
      edge_sharpness.push_back(crease.sharpness);
    }
    for (const CornerVertex& corner : mesh.corners) {
      vertices.push_back(corner.vertex);
      vertex_sharpness.push_back(corner.sharpness);
    }
  }
  void describe(Far::TopologyDescriptor& descriptor) const {
    descriptor.numCreases = static_cast<int>(edge_sharpness.size());
    descriptor.creaseVertexIndexPairs = edges.data();
    descriptor.creaseWeights = edge_sharpness.data();
    descriptor.numCorners = static_cast<int>(vertex_sharpness.size());
    descriptor.cornerVertexIndices = vertices.data();
    descriptor.cornerWeights = vertex_sharpness.data();
  }
};

}  // namespace

std::unique_ptr<Far::TopologyRefiner> descriptor_refiner(const PolygonMesh& mesh,
                                                         const RefinerOptions& options) {
  std::vector<int> face_sizes(static_cast<std::size_t>(mesh.face_count()));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) face_sizes[f] = mesh.face_size(f);

  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = mesh.vertex_count();
  descriptor.numFaces = mesh.face_count();
  descriptor.numVertsPerFace = face_sizes.data();
  descriptor.vertIndicesPerFace = mesh.face_vertices.data();
  const Tags tags(mesh);
  if (options.sharp.use_tags) tags.describe(descriptor);

  std::vector<int> uv_indices = mesh.face_uvs;
  const int uv_count = static_cast<int>(mesh.uvs.size());
  for (int& uv : uv_indices) uv = uv < 0 ? uv_count : uv;
  Far::TopologyDescriptor::FVarChannel uv_channel;
  uv_channel.numValues = uv_count + 1;
  uv_channel.valueIndices = uv_indices.data();
  descriptor.numFVarChannels = uv_indices.empty() ? 0 : 1;
  descriptor.fvarChannels = &uv_channel;

  // OpenSubdiv's default boundary option tags every boundary face a hole.
  Sdc::Options rules;
  rules.SetVtxBoundaryInterpolation(options.sharp.boundary == BoundaryRule::EdgeAndCorner
                                        ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                        : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  rules.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_ALL);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(options.scheme, rules)));
  return refiner;
}

QuadSplit::QuadSplit(const PolygonMesh& mesh)
    : topology_(mesh), refiner_(make_refiner(mesh, {}, topology_)) {}

void QuadSplit::refine(int levels) {
  refiner_->Unrefine();
  if (levels == 0) return;
  refiner_->RefineUniform(Far::TopologyRefiner::UniformOptions(levels));

  for (int l = 0; l < levels; ++l) {
    const Far::TopologyLevel& parent = level(l);
    const int last_vertex = parent.GetNumVertices() - 1;
    const int last_face = parent.GetNumFaces() - 1;
    const int last_edge = parent.GetNumEdges() - 1;
    PLANISH_ASSERT(parent.GetVertexChildVertex(0) == 0);
    PLANISH_ASSERT(parent.GetVertexChildVertex(last_vertex) == last_vertex);
    PLANISH_ASSERT(parent.GetFaceChildVertex(0) == last_vertex + 1);
    PLANISH_ASSERT(parent.GetFaceChildVertex(last_face) == last_vertex + 1 + last_face);
    PLANISH_ASSERT(parent.GetEdgeChildVertex(0) == last_vertex + last_face + 2);
    PLANISH_ASSERT(parent.GetEdgeChildVertex(last_edge) == last_vertex + last_face + 2 + last_edge);
    PLANISH_ASSERT(parent.GetFaceChildFaces(last_face)[0] == first_corner(l, last_face));
  }
}

std::vector<LevelCounts> QuadSplit::counts_to(int last) const {
  return split_counts({topology_.vertex_count(), topology_.edge_count(), topology_.face_count()},
                      topology_.corner_count(), last);
}

}  // namespace planish::test
