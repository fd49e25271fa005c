// Based on: Catmull & Clark 1978, Loop 1987, and OpenSubdiv's Sdc, which computes every mask.
#include "planish/primal/star_masks.h"

#include <opensubdiv/sdc/catmarkScheme.h>
#include <opensubdiv/sdc/loopScheme.h>

#include <algorithm>

namespace planish {

namespace Sdc = OpenSubdiv::Sdc;

namespace {

// What Sdc::Scheme asks of the neighbourhood of a vertex and of an edge, in its spelling.
class VertexNeighborhood {
 public:
  explicit VertexNeighborhood(const VertexStar& star) : star_(star) {}
  [[nodiscard]] int GetNumEdges() const { return star_.edge_count(); }
  [[nodiscard]] int GetNumFaces() const { return star_.face_count; }
  [[nodiscard]] float GetSharpness() const { return star_.sharpness; }
  float* GetSharpnessPerEdge(float* sharpness) const {
    std::ranges::copy(star_.edge_sharpness, sharpness);
    return sharpness;
  }
  [[nodiscard]] float GetChildSharpness(const Sdc::Crease& crease) const {
    return crease.SubdivideVertexSharpness(star_.sharpness);
  }
  float* GetChildSharpnessPerEdge(const Sdc::Crease& crease, float* sharpness) const {
    crease.SubdivideEdgeSharpnessesAroundVertex(star_.edge_count(), star_.edge_sharpness.data(),
                                                sharpness);
    return sharpness;
  }

 private:
  const VertexStar& star_;
};

struct EdgeNeighborhood {
  float sharpness;
  std::int32_t face_count;
  [[nodiscard]] int GetNumFaces() const { return face_count; }
  [[nodiscard]] float GetSharpness() const { return sharpness; }
  void GetChildSharpnesses(const Sdc::Crease& crease, float* children) const {
    children[0] = children[1] = crease.SubdivideUniformSharpness(sharpness);
  }
  // For the option that smooths triangles, which is off.
  void GetNumVerticesPerFace(int* counts) const { std::fill(counts, counts + face_count, 4); }
};

// Calls `use` with the scheme's rules.
template <class Use>
void with_rules(PrimalScheme scheme, const Use& use) {
  if (scheme == PrimalScheme::Loop) {
    use(Sdc::Scheme<Sdc::SCHEME_LOOP>());
  } else {
    use(Sdc::Scheme<Sdc::SCHEME_CATMARK>());
  }
}

}  // namespace

void vertex_mask(PrimalScheme scheme, const VertexStar& star, SubdivisionMask& mask) {
  with_rules(scheme, [&](const auto& rules) {
    rules.ComputeVertexVertexMask(VertexNeighborhood(star), mask);
  });
}

void edge_mask(PrimalScheme scheme, float sharpness, std::int32_t face_count,
               SubdivisionMask& mask) {
  mask.SetFaceWeightsForFaceCenters(scheme == PrimalScheme::CatmullClark);
  with_rules(scheme, [&](const auto& rules) {
    rules.ComputeEdgeVertexMask(EdgeNeighborhood{sharpness, face_count}, mask);
  });
}

void limit_mask(PrimalScheme scheme, const VertexStar& star, LimitMasks& masks) {
  const Sdc::Crease::Rule rule = Sdc::Crease().DetermineVertexVertexRule(
      star.sharpness, star.edge_count(), star.edge_sharpness.data());
  with_rules(scheme, [&](const auto& rules) {
    rules.ComputeVertexLimitMask(VertexNeighborhood(star), masks.position, masks.du, masks.dv,
                                 rule);
  });
}

}  // namespace planish
