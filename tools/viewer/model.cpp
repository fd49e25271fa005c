#include "model.h"

#include <algorithm>
#include <limits>
#include <span>

#include "cage_edges.h"
#include "nearest_given.h"

namespace planish::viewer {
namespace {

std::vector<std::uint32_t> words(std::span<const std::int32_t> values) {
  return {values.begin(), values.end()};
}

// Mesa's llvmpipe (22.3) takes time with the square of a draw's triangles, and goes through loops
// but once in a vertex shader's last lanes where they are no whole group.
constexpr std::uint32_t kSoftwarePatches = 32;

std::vector<Model::Run> shown_patches(const PolygonMesh& mesh, bool is_software) {
  const std::int32_t most =
      is_software ? std::int32_t{kSoftwarePatches} : std::numeric_limits<std::int32_t>::max();
  std::vector<std::int32_t> holes = mesh.hole_faces;
  std::ranges::sort(holes);
  holes.push_back(mesh.face_count());
  std::vector<Model::Run> runs;
  std::int32_t face = 0;
  for (const std::int32_t hole : holes) {
    if (hole > face) {
      std::int32_t first = mesh.face_offsets[face];
      const std::int32_t end = mesh.face_offsets[hole];
      for (std::int32_t count = 0; first < end; first += count) {
        count = std::min(most, end - first);
        const auto start = static_cast<std::uint32_t>(first),
                   corners = static_cast<std::uint32_t>(count);
        runs.push_back({start, is_software ? kSoftwarePatches : corners, start + corners});
      }
    }
    face = hole + 1;
  }
  return runs;
}

}  // namespace

Model::Model(const Device& device, vulkan::Context& context, const Scene& scene)
    : system_(scene.mesh, scene.system),
      tables_(context, system_, {shared::kVertexFloats * sizeof(float), device.has_tessellation()}),
      indices_(device, tables_.index_count() * sizeof(std::uint32_t),
               VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Device),
      used_(word_buffer(device, words(system_.used_vertices()))),
      edges_(word_buffer(device, cage_edges(scene, system_.used_vertices()))),
      edge_count_(static_cast<std::uint32_t>(edges_.bytes() / (2 * sizeof(std::uint32_t)))),
      patches_(shown_patches(scene.mesh, device.is_software())),
      face_count_(static_cast<std::uint32_t>(scene.mesh.face_count())) {
  const NearestGiven nearest = nearest_given(system_);
  offsets_ = word_buffer(device, nearest.offsets);
  nearest_ = word_buffer(device, nearest.rows);
  if (const std::vector<glm::vec2> uvs = system_.uvs(); !uvs.empty())
    uvs_ = buffer_of(device, std::as_bytes(std::span(uvs)), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  const Buffer staging(device, tables_.upload_bytes(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                       Place::Host);
  tables_.write_upload(system_, staging.mapped());
  device.run([&](VkCommandBuffer commands) {
    tables_.record_upload(commands, staging, 0, {indices_, 0});
    barrier(commands, vulkan::kExitScope,
            {VK_PIPELINE_STAGE_VERTEX_INPUT_BIT, VK_ACCESS_INDEX_READ_BIT});
  });
}

}  // namespace planish::viewer
