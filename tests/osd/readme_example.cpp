#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/osd/mesh.h>

#include <cstdio>
#include <vector>

#include "planish/osd/vk_compute_evaluator.h"
#include "planish/osd/vk_vertex_buffer.h"
#include "planish/vulkan/device/own_device.h"

using namespace OpenSubdiv;
using namespace planish;
using Mesh = Osd::Mesh<osd::VkVertexBuffer, osd::VkStencilTable, osd::VkComputeEvaluator,
                       osd::VkPatchTable, osd::VkDeviceContext>;

int main() {
  const float points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
  const int sizes[] = {4, 4, 4, 4, 4, 4};
  const int corners[] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  Far::TopologyDescriptor cube;
  cube.numVertices = 8;
  cube.numFaces = 6;
  cube.numVertsPerFace = sizes;
  cube.vertIndicesPerFace = corners;
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;

  // README begins
  // A device of planish's own; a renderer gives its own as vulkan::HostDevice.
  vulkan::OwnDevice device{vulkan::OwnDeviceOptions{}};
  vulkan::Context context(device);
  osd::VkDeviceContext target(context, device.queue(), device.capabilities().compute_family);
  Osd::EvaluatorCacheT<osd::VkComputeEvaluator> evaluators;

  Mesh mesh(Factory::Create(cube, Factory::Options(Sdc::SCHEME_CATMARK)), 3, 0, /*level=*/2,
            Osd::MeshBitset(), &evaluators, &target);
  mesh.UpdateVertexBuffer(points, 0, 8);
  mesh.Refine();       // submits and returns; with target.SetCommandBuffer(...) it only records
  mesh.Synchronize();  // waits
                       // README ends

  // mesh.BindVertexBuffer() is the VkBuffer to draw from. Here its floats are copied back.
  std::vector<float> refined(3 * mesh.GetNumVertices());
  mesh.GetVertexBuffer()->ReadData(refined.data(), 0, mesh.GetNumVertices(), &target);
  std::printf("%d vertices; the first of level 2: %g %g %g\n", mesh.GetNumVertices(), refined[24],
              refined[25], refined[26]);
}
