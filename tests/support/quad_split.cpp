#include "support/quad_split.h"

#include "planish/core/guards.h"
#include "planish/solve/refiner.h"

namespace planish::test {

namespace Far = OpenSubdiv::Far;

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
