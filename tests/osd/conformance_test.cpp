// Osd::CpuEvaluator and VkComputeEvaluator on every cage and layout, to 1e-6 of the largest
// magnitude in each buffer.
#include <gmock/gmock.h>

#include "osd/conformance.h"
#include "osd/fixture.h"

namespace planish::testing {
namespace {

using OpenSubdiv::Far::PatchTableFactory;

class OsdConformance : public OsdTest {};

RefineOptions uniform(std::size_t i) {
  RefineOptions options;
  options.level = 1 + static_cast<int>(i % 5);
  return options;
}

RefineOptions adaptive(std::size_t i) {
  constexpr PatchTableFactory::Options::EndCapType kEndCaps[] = {
      PatchTableFactory::Options::ENDCAP_GREGORY_BASIS,
      PatchTableFactory::Options::ENDCAP_BSPLINE_BASIS,
      PatchTableFactory::Options::ENDCAP_BILINEAR_BASIS};
  RefineOptions options;
  options.adaptive = true;
  options.level = 1 + static_cast<int>((i + 2) % 5);
  options.patches = PatchTableFactory::Options(options.level);
  options.patches.SetEndCapType(kEndCaps[i % 3]);
  options.patches.useInfSharpPatch = i % 2 == 1;
  options.patches.useSingleCreasePatch = i % 4 < 2;
  return options;
}

TEST_F(OsdConformance, EqualsCpuEvaluatorOnAllCages) {
  Conformance conformance{*device_context_, {}};
  const std::vector<Cage> cages = all_cages();
  const std::vector<Layout> layouts = all_layouts();
  // Patches have a kernel for each layout and derivative, which a software device compiles slowly.
  const std::vector<Layout> few_layouts = patch_layouts();
  ASSERT_GE(cages.size(), 40u);
  std::size_t turn = 0;
  const auto next_layout = [&]() -> const Layout& { return layouts[turn++ % layouts.size()]; };
  const auto next_few = [&]() -> const Layout& { return few_layouts[turn++ % few_layouts.size()]; };
  for (std::size_t i = 0; i < cages.size(); ++i) {
    for (const RefineOptions& options : {uniform(i), adaptive(i)}) {
      const Cage& cage = cages[i];
      const Refined refined = refine(cage, options);
      const std::string name = cage.name + (options.adaptive ? ", adaptive " : ", uniform ") +
                               std::to_string(options.level);
      conformance.stencils(name + ", vertices", cage, *refined.vertices, next_layout());
      conformance.stencils(name + ", varying", cage, *refined.varying, next_layout());
      if (refined.face_varying)
        conformance.stencils(name + ", face-varying", cage, *refined.face_varying, next_layout());
      if (options.adaptive)
        conformance.limit_stencils(name + ", limits", cage, *refined.limits, next_layout());
      conformance.patches(name + ", patches", cage, refined, PatchKind::Vertex, next_few());
      conformance.patches(name + ", varying patches", cage, refined, PatchKind::Varying,
                          next_few());
      if (refined.face_varying)
        conformance.patches(name + ", face-varying patches", cage, refined, PatchKind::FaceVarying,
                            next_few());
    }
    ++conformance.tally.cages;
  }
  conformance.tally.print();
  using OpenSubdiv::Far::PatchDescriptor;
  EXPECT_THAT(
      conformance.patch_types,
      ::testing::ElementsAre(PatchDescriptor::QUADS, PatchDescriptor::TRIANGLES,
                             PatchDescriptor::LOOP, PatchDescriptor::REGULAR,
                             PatchDescriptor::GREGORY_BASIS, PatchDescriptor::GREGORY_TRIANGLE));
  EXPECT_GT(conformance.sharp_patches, 0);
  EXPECT_GT(conformance.boundary_patches, 0);
}

}  // namespace
}  // namespace planish::testing
