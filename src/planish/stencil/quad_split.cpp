#include "planish/stencil/quad_split.h"

#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include "planish/core/assert.h"
#include "planish/core/error.h"

namespace planish {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

QuadSplit::QuadSplit(const PolygonMesh& mesh) : face_offsets_(mesh.face_offsets) {
  std::vector<int> face_sizes(static_cast<std::size_t>(mesh.face_count()));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) face_sizes[f] = mesh.face_size(f);

  std::vector<int> crease_vertices;
  std::vector<float> crease_sharpness;
  for (const CreaseEdge& crease : mesh.creases) {
    crease_vertices.insert(crease_vertices.end(), {crease.v0, crease.v1});
    crease_sharpness.push_back(crease.sharpness);
  }

  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = mesh.vertex_count();
  descriptor.numFaces = mesh.face_count();
  descriptor.numVertsPerFace = face_sizes.data();
  descriptor.vertIndicesPerFace = mesh.face_vertices.data();
  descriptor.numCreases = static_cast<int>(crease_sharpness.size());
  descriptor.creaseVertexIndexPairs = crease_vertices.data();
  descriptor.creaseWeights = crease_sharpness.data();

  std::vector<int> uv_indices = mesh.face_uvs;
  const int uv_count = static_cast<int>(mesh.uvs.size());
  for (int& uv : uv_indices) uv = uv < 0 ? uv_count : uv;
  Far::TopologyDescriptor::FVarChannel uv_channel;
  uv_channel.numValues = uv_count + 1;
  uv_channel.valueIndices = uv_indices.data();
  descriptor.numFVarChannels = uv_indices.empty() ? 0 : 1;
  descriptor.fvarChannels = &uv_channel;

  // With other schemes OpenSubdiv's default boundary option tags every boundary face a hole.
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_ALL);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  refiner_.reset(Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_BILINEAR, options)));
  if (!refiner_) {
    throw Error(ErrorCode::UnusableMesh,
                "OpenSubdiv refuses the mesh's topology; `planish inspect` lists its problems");
  }
}

QuadSplit::~QuadSplit() = default;

void QuadSplit::refine(int levels) {
  refiner_->Unrefine();
  if (levels == 0) return;
  refiner_->RefineUniform(Far::TopologyRefiner::UniformOptions(levels));

  for (int l = 0; l < levels; ++l) {
    const Far::TopologyLevel& parent = refiner_->GetLevel(l);
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

int QuadSplit::level_count() const { return refiner_->GetMaxLevel(); }

const Far::TopologyLevel& QuadSplit::level(int index) const { return refiner_->GetLevel(index); }

LevelCounts QuadSplit::counts(int level) const {
  const Far::TopologyLevel& base = refiner_->GetLevel(0);
  LevelCounts counts{base.GetNumVertices(), base.GetNumEdges(), base.GetNumFaces()};
  std::int64_t corner_count = base.GetNumFaceVertices();
  for (int l = 0; l < level; ++l) {
    counts = {counts.vertices + counts.edges + counts.faces, 2 * counts.edges + corner_count,
              corner_count};
    corner_count = 4 * counts.faces;
  }
  return counts;
}

}  // namespace planish
