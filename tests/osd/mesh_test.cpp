// Osd::Mesh of our classes against Osd::Mesh of OpenSubdiv's own.
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>
#include <opensubdiv/osd/cpuVertexBuffer.h>
#include <opensubdiv/osd/mesh.h>

#include "osd/cages.h"
#include "osd/fixture.h"
#include "planish/osd/vk_compute_evaluator.h"

namespace OpenSubdiv {
namespace OPENSUBDIV_VERSION {
namespace Osd {

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
