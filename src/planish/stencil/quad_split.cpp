#include "planish/stencil/quad_split.h"

#include "planish/core/assert.h"
#include "planish/stencil/refiner.h"

namespace planish {

namespace Far = OpenSubdiv::Far;

QuadSplit::QuadSplit(const PolygonMesh& mesh)
    : face_offsets_(mesh.face_offsets), refiner_(make_refiner(mesh, {})) {}

QuadSplit::QuadSplit(QuadSplit&&) noexcept = default;
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

std::vector<LevelCounts> QuadSplit::counts_to(int last) const {
  const Far::TopologyLevel& base = refiner_->GetLevel(0);
  std::vector<LevelCounts> counts{{base.GetNumVertices(), base.GetNumEdges(), base.GetNumFaces()}};
  std::int64_t corner_count = base.GetNumFaceVertices();
  for (int l = 0; l < last; ++l) {
    const LevelCounts& c = counts.back();
    counts.push_back({c.vertices + c.edges + c.faces, 2 * c.edges + corner_count, corner_count});
    corner_count *= 4;
  }
  return counts;
}

}  // namespace planish
