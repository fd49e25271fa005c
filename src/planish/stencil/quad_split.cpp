#include "planish/stencil/quad_split.h"

#include <utility>

#include "planish/core/assert.h"
#include "planish/stencil/refiner.h"

namespace planish {

namespace Far = OpenSubdiv::Far;

QuadSplit::QuadSplit(const PolygonMesh& mesh)
    : QuadSplit(mesh, std::make_shared<const MeshTopology>(mesh)) {}

QuadSplit::QuadSplit(const PolygonMesh& mesh, std::shared_ptr<const MeshTopology> topology)
    : mesh_(&mesh), topology_(std::move(topology)), lazy_(std::make_unique<Lazy>()) {
  PLANISH_ASSERT(mesh.face_count() == topology_->face_count());
  PLANISH_ASSERT(mesh.vertex_count() == topology_->vertex_count());
}

QuadSplit::QuadSplit(QuadSplit&&) noexcept = default;
QuadSplit::~QuadSplit() = default;

void QuadSplit::refine(int levels) {
  if (level_count_ > 0) made_refiner().Unrefine();
  level_count_ = levels;
  if (levels == 0) return;
  made_refiner().RefineUniform(Far::TopologyRefiner::UniformOptions(levels));

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

Far::TopologyRefiner& QuadSplit::made_refiner() const {
  std::call_once(lazy_->once, [&] { lazy_->refiner = make_refiner(*mesh_, {}, *topology_); });
  return *lazy_->refiner;
}

const Far::TopologyRefiner& QuadSplit::refiner() const { return made_refiner(); }

const Far::TopologyLevel& QuadSplit::level(int index) const { return refiner().GetLevel(index); }

std::vector<LevelCounts> QuadSplit::counts_to(int last) const {
  return split_counts({topology_->vertex_count(), topology_->edge_count(), topology_->face_count()},
                      topology_->corner_count(), last);
}

std::vector<LevelCounts> split_counts(const LevelCounts& base, std::int64_t corner_count,
                                      int last) {
  std::vector<LevelCounts> counts{base};
  for (int l = 0; l < last; ++l) {
    const LevelCounts& c = counts.back();
    counts.push_back({c.vertices + c.edges + c.faces, 2 * c.edges + corner_count, corner_count});
    corner_count *= 4;
  }
  return counts;
}

}  // namespace planish
