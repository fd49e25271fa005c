#include "planish/vulkan/backend/vulkan_patches.h"

#include <bit>
#include <cstring>
#include <glm/vec4.hpp>

#include "planish/core/assert.h"
#include "planish/core/parallel.h"
#include "planish/vulkan/evaluate/gpu_patches.h"
#include "planish/vulkan/evaluate/state_owners.h"

namespace planish::vulkan {

namespace {

constexpr std::uint32_t kRowBytes = sizeof(PatchEvaluator::Row);
static_assert(kRowBytes == 24);

// Points of level 1 as the kernel takes them. There are no given vertices here: those of a vertex
// are seen from one of them.
struct SeenPoints {
  SeenPoints(const PatchMesh& mesh, std::span<const glm::dvec3> state) {
    const std::vector<std::int32_t> owners = state_owners(mesh);
    origins.resize(static_cast<std::size_t>(mesh.topology().vertex_count()));
    for (std::size_t i = state.size(); i-- > 0;)
      origins[owners[i]] = glm::vec4(glm::vec3(state[i]), 0);
    offsets.resize(state.size());
    parallel_each(state.size(), [&](std::size_t i) {
      const auto owner = static_cast<std::uint32_t>(owners[i]);
      const glm::vec3 offset(state[i] - glm::dvec3(glm::vec3(origins[owner])));
      offsets[i] = glm::vec4(offset, std::bit_cast<float>(owner | shared::kVertexTag));
    });
  }
  std::vector<glm::vec4> origins, offsets;
};

}  // namespace

void evaluate_patches(VulkanMachine& machine, const PatchSurface& surface,
                      std::span<const glm::dvec3> state, std::span<PatchEvaluator::Row> rows) {
  PLANISH_ASSERT(std::ssize(rows) == surface.numbering().row_count());
  if (rows.empty()) return;
  Context& context = machine.context;
  const auto upload = [&](const Buffer& buffer, std::span<const std::byte> bytes) {
    machine.submitter.upload({buffer.handle(), 0, bytes.size()}, bytes);
  };
  const auto make = [&](const std::vector<glm::vec4>& points) {
    Buffer buffer(context, points.size() * sizeof points[0], MemoryUse::Device);
    upload(buffer, std::as_bytes(std::span(points)));
    return buffer;
  };
  const PatchRecords records = patch_records(surface, patch_limits(context, kRowBytes));
  const PatchTables tables(context, records, std::ssize(state));
  tables.for_each(records, upload);
  const SeenPoints points(surface.mesh(), state);
  const Buffer origins = make(points.origins), offsets = make(points.offsets);
  const Buffer target(context, rows.size_bytes(), MemoryUse::Device);
  const GpuPatches patches(context, tables, origins, offsets, {target.handle(), 0, kRowBytes});
  machine.submitter.run([&](VkCommandBuffer commands) { patches.record(commands); });
  const std::span<std::byte> bytes = std::as_writable_bytes(rows);
  machine.submitter.download({target.handle(), 0, bytes.size()},
                             [&](std::uint64_t offset, std::span<const std::byte> piece) {
                               std::memcpy(&bytes[offset], piece.data(), piece.size());
                             });
}

}  // namespace planish::vulkan
