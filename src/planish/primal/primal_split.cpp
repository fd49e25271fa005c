#include "planish/primal/primal_split.h"

#include <string>

#include "planish/core/assert.h"
#include "planish/core/error.h"
#include "planish/stencil/refiner.h"

namespace planish {

namespace Far = OpenSubdiv::Far;

namespace {

void require_triangles(const PolygonMesh& mesh) {
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (mesh.face_size(f) == 3) continue;
    throw Error(ErrorCode::UnusableMesh,
                formatted("face {} has {} corners, and Loop subdivision knows triangles only; "
                          "split the faces into triangles, or take catmull-clark or doo-sabin",
                          f, mesh.face_size(f)),
                f);
  }
}

// Every vertex and edge of a face has a weight for each of its corners, about 60 bytes for a pair
// of them in step and limits: so many pairs in large faces take 1 GiB.
constexpr std::int64_t kMostPairs = 1 << 24;
constexpr std::int64_t kLargeFace = 64;

void require_small_faces(const PolygonMesh& mesh) {
  std::int64_t pairs = 0;
  std::int32_t largest = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int64_t size = mesh.face_size(f);
    if (size > kLargeFace) pairs += size * size;
    if (size > mesh.face_size(largest)) largest = f;
  }
  if (pairs <= kMostPairs) return;
  throw Error(ErrorCode::UnusableMesh,
              formatted("face {} has {} corners: Catmull-Clark's stencils take the square of a "
                        "face's corners, {} here and {} at most; split its large faces, or take "
                        "doo-sabin",
                        largest, mesh.face_size(largest), pairs, kMostPairs),
              largest);
}

}  // namespace

PrimalSplit::PrimalSplit(const PolygonMesh& mesh, const PrimalSplitOptions& options)
    : scheme_(options.scheme) {
  if (scheme_ == PrimalScheme::Loop) {
    require_triangles(mesh);
  } else {
    require_small_faces(mesh);
  }
  const RefinerOptions refined{scheme_ == PrimalScheme::Loop ? OpenSubdiv::Sdc::SCHEME_LOOP
                                                             : OpenSubdiv::Sdc::SCHEME_CATMARK,
                               options.sharp};
  refiner_ = options.topology != nullptr ? make_refiner(mesh, refined, *options.topology)
                                         : make_refiner(mesh, refined, MeshTopology(mesh));
}

PrimalSplit::~PrimalSplit() = default;

void PrimalSplit::refine(int levels) {
  refiner_->Unrefine();
  if (levels == 0) return;
  Far::TopologyRefiner::UniformOptions options(levels);
  // A vertex's limit needs the faces around it, on the last level too.
  options.fullTopologyInLastLevel = true;
  refiner_->RefineUniform(options);

  for (int l = 0; l < levels; ++l) {
    const Far::TopologyLevel& parent = level(l);
    const int vertices = parent.GetNumVertices();
    const int faces = scheme_ == PrimalScheme::Loop ? 0 : parent.GetNumFaces();
    PLANISH_ASSERT(parent.GetVertexChildVertex(vertices - 1) == vertices - 1);
    PLANISH_ASSERT(faces == 0 || parent.GetFaceChildVertex(faces - 1) == vertices + faces - 1);
    PLANISH_ASSERT(parent.GetEdgeChildVertex(0) == vertices + faces);
    const auto children = parent.GetFaceChildFaces(parent.GetNumFaces() - 1);
    PLANISH_ASSERT(children[children.size() - 1] == level(l + 1).GetNumFaces() - 1);
  }
}

int PrimalSplit::sharp_edge_count() const {
  int count = 0;
  for (int e = 0; e < level(0).GetNumEdges(); ++e) count += level(0).GetEdgeSharpness(e) > 0;
  return count;
}

int PrimalSplit::boundary_edge_count() const {
  int count = 0;
  for (int e = 0; e < level(0).GetNumEdges(); ++e) count += level(0).IsEdgeBoundary(e);
  return count;
}

int PrimalSplit::corner_count() const {
  int count = 0;
  for (int v = 0; v < level(0).GetNumVertices(); ++v) {
    count += level(0).GetVertexRule(v) == OpenSubdiv::Sdc::Crease::RULE_CORNER;
  }
  return count;
}

std::vector<LevelCounts> PrimalSplit::counts_to(int last) const {
  const Far::TopologyLevel& base = level(0);
  std::vector<LevelCounts> counts{{base.GetNumVertices(), base.GetNumEdges(), base.GetNumFaces()}};
  std::int64_t corners = base.GetNumFaceVertices();
  for (int l = 0; l < last; ++l) {
    const LevelCounts& c = counts.back();
    const bool loop = scheme_ == PrimalScheme::Loop;
    counts.push_back(
        loop ? LevelCounts{c.vertices + c.edges, 2 * c.edges + corners, 4 * c.faces}
             : LevelCounts{c.vertices + c.edges + c.faces, 2 * c.edges + corners, corners});
    corners *= 4;
  }
  return counts;
}

}  // namespace planish
