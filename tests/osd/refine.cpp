#include <opensubdiv/far/stencilTableFactory.h>

#include "osd/conformance.h"

namespace planish::testing {

namespace {

using namespace OpenSubdiv;

constexpr float kGridPlaces[] = {0.0f, 0.125f, 0.5f, 0.8f, 1.0f};

/// The stencils of `table` and after them those of the patches' own points, which may be none.
std::unique_ptr<const Far::StencilTable> with_local_points(const Far::TopologyRefiner& refiner,
                                                           const Far::StencilTable* table,
                                                           const Far::StencilTable* local,
                                                           int channel) {
  std::unique_ptr<const Far::StencilTable> stencils(table);
  if (!local) return stencils;
  const Far::StencilTable* both =
      channel < 0 ? Far::StencilTableFactory::AppendLocalPointStencilTable(refiner, table, local)
                  : Far::StencilTableFactory::AppendLocalPointStencilTableFaceVarying(
                        refiner, table, local, channel);
  if (both) stencils.reset(both);
  return stencils;
}

/// Five by five places on every face, corners among them.
std::unique_ptr<const Far::LimitStencilTable> limit_table(const Refined& refined) {
  Far::LimitStencilTableFactory::LocationArrayVec locations;
  std::vector<float> s, t;
  const bool triangles = refined.refiner->GetSchemeType() == Sdc::SCHEME_LOOP;
  for (const float u : kGridPlaces)
    for (const float v : kGridPlaces) {
      if (triangles && u + v > 1) continue;
      s.push_back(u);
      t.push_back(v);
    }
  const int face_count = refined.patches->GetNumPtexFaces();
  for (int face = 0; face < face_count; ++face) {
    Far::LimitStencilTableFactory::LocationArray places;
    places.ptexIdx = face;
    places.numLocations = static_cast<int>(s.size());
    places.s = s.data();
    places.t = t.data();
    locations.push_back(places);
  }
  Far::LimitStencilTableFactory::Options options;
  options.generate1stDerivatives = true;
  options.generate2ndDerivatives = true;
  return std::unique_ptr<const Far::LimitStencilTable>(Far::LimitStencilTableFactory::Create(
      *refined.refiner, locations, nullptr, nullptr, options));
}

}  // namespace

Refined refine(const Cage& cage, const RefineOptions& options) {
  Refined refined;
  refined.refiner = make_refiner(cage);
  if (options.adaptive) {
    Far::TopologyRefiner::AdaptiveOptions adaptive = options.patches.GetRefineAdaptiveOptions();
    adaptive.isolationLevel = options.level;
    adaptive.considerFVarChannels = cage.face_varying_count > 0;
    refined.refiner->RefineAdaptive(adaptive);
  } else {
    Far::TopologyRefiner::UniformOptions uniform(options.level);
    uniform.fullTopologyInLastLevel = true;
    refined.refiner->RefineUniform(uniform);
  }
  Far::PatchTableFactory::Options patch_options = options.patches;
  patch_options.generateVaryingTables = true;
  patch_options.includeFVarBaseLevelIndices = true;
  patch_options.generateFVarTables = cage.face_varying_count > 0;
  patch_options.generateFVarLegacyLinearPatches = !options.adaptive;
  refined.patches.reset(Far::PatchTableFactory::Create(*refined.refiner, patch_options));

  const Far::TopologyRefiner& refiner = *refined.refiner;
  Far::StencilTableFactory::Options stencils;
  stencils.generateIntermediateLevels = options.adaptive;
  stencils.generateOffsets = true;
  refined.vertices = with_local_points(refiner, Far::StencilTableFactory::Create(refiner, stencils),
                                       refined.patches->GetLocalPointStencilTable(), -1);
  stencils.interpolationMode = Far::StencilTableFactory::INTERPOLATE_VARYING;
  refined.varying = with_local_points(refiner, Far::StencilTableFactory::Create(refiner, stencils),
                                      refined.patches->GetLocalPointVaryingStencilTable(), -1);
  if (cage.face_varying_count > 0) {
    stencils.interpolationMode = Far::StencilTableFactory::INTERPOLATE_FACE_VARYING;
    refined.face_varying =
        with_local_points(refiner, Far::StencilTableFactory::Create(refiner, stencils),
                          refined.patches->GetLocalPointFaceVaryingStencilTable(), 0);
  }
  refined.limits = limit_table(refined);
  return refined;
}

}  // namespace planish::testing
