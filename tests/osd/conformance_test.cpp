// Osd::CpuEvaluator and VkComputeEvaluator on every cage and layout, to 1e-6 of the largest
// magnitude in each buffer.
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
  ASSERT_GE(cages.size(), 40u);
  std::size_t turn = 0;
  const auto next_layout = [&]() -> const Layout& { return layouts[turn++ % layouts.size()]; };
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
    }
    ++conformance.tally.cages;
  }
  conformance.tally.print();
}

}  // namespace
}  // namespace planish::testing
