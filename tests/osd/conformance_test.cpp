#include <gmock/gmock.h>
#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>
#include <opensubdiv/osd/cpuVertexBuffer.h>
#include <opensubdiv/osd/mesh.h>

#include <limits>

#include "osd/cages.h"
#include "osd/conformance.h"
#include "osd/fixture.h"
#include "planish/osd/vk_compute_evaluator.h"

namespace planish::testing {
namespace {

// The comparison of the conformance test notices what it is for.

TEST(OsdTally, NoticesAFloatThatIsOff) {
  EXPECT_NONFATAL_FAILURE(Tally().compare("off", {{4, 2, 1}}, {{4, 2, 1.00001f}}), "off");
  EXPECT_NONFATAL_FAILURE(
      Tally().compare("nan", {{4}}, {{std::numeric_limits<float>::quiet_NaN()}}), "nan");
  EXPECT_NONFATAL_FAILURE(Tally().compare("zero", {{0, 0}}, {{0, 1e-30f}}), "zero");
  EXPECT_FATAL_FAILURE(Tally().compare("short", {{1, 2}}, {{1}}), "short");
}

TEST(OsdTally, CountsAndMeasures) {
  Tally tally;
  tally.compare("near", {{4, 2}, {1}}, {{4, 2.000001f}, {1}});
  EXPECT_EQ(tally.floats, 3);
  EXPECT_NEAR(tally.largest, 1e-6 / 4, 1e-7);
}

// Osd::CpuEvaluator and VkComputeEvaluator on every cage and layout, to 1e-6 of the largest
// magnitude in each buffer.

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

namespace OpenSubdiv {
namespace OPENSUBDIV_VERSION {
namespace Osd {

// Osd::Mesh of our classes against Osd::Mesh of OpenSubdiv's own.

/// What a CPU mesh binds to draw from: nothing.
struct DrawnCpuPatchTable : CpuPatchTable {
  typedef float* VertexBufferBinding;
  using CpuPatchTable::CpuPatchTable;
  static DrawnCpuPatchTable* Create(const Far::PatchTable* table, void* = nullptr) {
    return new DrawnCpuPatchTable(table);
  }
};

struct DrawnCpuVertexBuffer : CpuVertexBuffer {
  using CpuVertexBuffer::CpuVertexBuffer;
  static DrawnCpuVertexBuffer* Create(int elements, int vertices, void* = nullptr) {
    return new DrawnCpuVertexBuffer(elements, vertices);
  }
  float* BindVBO(void* = nullptr) { return BindCpuBuffer(); }
};

}  // namespace Osd

}  // namespace OPENSUBDIV_VERSION

}  // namespace OpenSubdiv

namespace planish::testing {
namespace {

using namespace OpenSubdiv;
using VkMesh = Osd::Mesh<osd::VkVertexBuffer, osd::VkStencilTable, osd::VkComputeEvaluator,
                         osd::VkPatchTable, osd::VkDeviceContext>;
using CpuMesh = Osd::Mesh<Osd::DrawnCpuVertexBuffer, Far::StencilTable, Osd::CpuEvaluator,
                          Osd::DrawnCpuPatchTable>;

class OsdMesh : public OsdTest {
 protected:
  struct Case {
    std::string name;
    Cage cage;
    int varying;
    Osd::MeshBitset bits;
  };

  static Osd::MeshBitset bits(std::initializer_list<int> set) {
    Osd::MeshBitset result;
    for (const int bit : set) result.set(bit);
    return result;
  }

  static std::vector<Case> cases() {
    Cage loop = icosahedron();
    loop.scheme = Sdc::SCHEME_LOOP;
    return {{"uniform", prism(5), 0, {}},
            {"uniform with varying", prism(5), 2, {}},
            {"interleaved varying", prism(5), 2, bits({Osd::MeshInterleaveVarying})},
            {"adaptive", torus(6, 5), 0, bits({Osd::MeshAdaptive, Osd::MeshEndCapGregoryBasis})},
            {"adaptive with varying", prism(5), 4,
             bits({Osd::MeshAdaptive, Osd::MeshEndCapBSplineBasis})},
            {"adaptive loop", loop, 1, bits({Osd::MeshAdaptive, Osd::MeshEndCapGregoryBasis})}};
  }

  template <class Mesh>
  static void update(Mesh& mesh, const Case& given, float scale) {
    std::vector<float> points, colours;
    for (const auto& position : given.cage.positions) {
      const bool interleaved = given.bits.test(Osd::MeshInterleaveVarying);
      for (const float coordinate : position) points.push_back(scale * coordinate);
      for (int c = 0; c < given.varying; ++c)
        (interleaved ? points : colours).push_back(scale * position[0] + 0.25f * c);
    }
    const int count = static_cast<int>(given.cage.positions.size());
    mesh.UpdateVertexBuffer(points.data(), 0, count);
    if (!colours.empty()) mesh.UpdateVaryingBuffer(colours.data(), 0, count);
    mesh.Refine();
  }
};

TEST_F(OsdMesh, RefinesAsTheCpuMeshDoes) {
  Osd::EvaluatorCacheT<osd::VkComputeEvaluator> cache;
  for (const Case& given : cases()) {
    CpuMesh cpu(make_refiner(given.cage).release(), 3, given.varying, 3, given.bits);
    update(cpu, given, 1.5f);
    for (auto* evaluators : {&cache, static_cast<decltype(&cache)>(nullptr)}) {
      VkMesh mesh(make_refiner(given.cage).release(), 3, given.varying, 3, given.bits, evaluators,
                  device_context_.get());
      update(mesh, given, 3.0f);
      update(mesh, given, 1.5f);
      mesh.Synchronize();
      ASSERT_EQ(mesh.GetNumVertices(), cpu.GetNumVertices());
      EXPECT_NE(mesh.BindVertexBuffer(), VkBuffer(VK_NULL_HANDLE));
      const auto expect_same = [&](Osd::DrawnCpuVertexBuffer* expected, osd::VkVertexBuffer* got) {
        const std::vector<float> floats = floats_of(*got);
        const float* from = expected->BindCpuBuffer();
        EXPECT_EQ(floats, std::vector<float>(from, from + floats.size())) << given.name;
      };
      expect_same(cpu.GetVertexBuffer(), mesh.GetVertexBuffer());
      ASSERT_EQ(cpu.GetVaryingBuffer() == nullptr, mesh.GetVaryingBuffer() == nullptr);
      if (cpu.GetVaryingBuffer()) expect_same(cpu.GetVaryingBuffer(), mesh.GetVaryingBuffer());
    }
  }
}

TEST_F(OsdMesh, MayBeDeletedWhileItsCommandsRun) {
  const Case given = cases()[3];
  for (int i = 0; i < 5; ++i) {
    VkMesh mesh(make_refiner(given.cage).release(), 3, 0, 3, given.bits, nullptr,
                device_context_.get());
    update(mesh, given, 1);
  }
  device_context_->Synchronize();
}

}  // namespace
}  // namespace planish::testing
