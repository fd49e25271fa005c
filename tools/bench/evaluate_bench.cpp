// The second half of a host's frame: from displaced points to vertices on the device.
#include <cstring>
#include <optional>

#include "bench/agreement.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "bench/device_frame.h"
#include "bench/table_evaluation.h"
#include "planish/core/formatted.h"
#include "planish/patches/patch_numbering.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/embed.h"
#include "support/doo_sabin_tables.h"

namespace planish::bench {

namespace {

using namespace vulkan;

std::string megabytes(std::uint64_t bytes) {
  return formatted("{}.{} MB", (bytes + 50'000) / 100'000 / 10, (bytes + 50'000) / 100'000 % 10);
}

// The same surface from the same control points by tables.
struct FrameTables {
  FrameTables(VulkanMachine& machine, const PolygonMesh& mesh, const DeviceFrame& frame,
              const Buffer& vertices) {
    test::QuadSplit split(mesh);
    split.refine(kFrameLevel);
    const SharpFeatures features = find_sharp_features(mesh, split.topology(), mesh.positions, {});
    const test::SubdivisionChain subdivision(split, features, Weights::DooSabin);
    const auto add = [&](const StencilTable& table) {
      refinement.emplace_back(machine.context, table.view(), DeviceTableOptions{});
      machine.upload_table(refinement.back(), table.view());
    };
    for (int l = 1; l <= kFrameLevel; ++l) add(step_table(subdivision, l));
    const PatchMesh patches(split.topology(), features);
    const test::LimitRows limits(subdivision, kFrameLevel);
    const StencilTable table =
        limit_table(subdivision, limits, limits.in_order_of(PatchNumbering(patches, kFrameLevel)));
    DeviceTableOptions options;
    options.has_derivatives = true;
    options.target_stride = kFrameVertexBytes;
    limit.emplace(machine.context, table.view(), options);
    machine.upload_table(*limit, table.view());
    evaluation.emplace(machine.context, refinement, *limit, frame.solve.control_points(),
                       VertexLayout{vertices.handle()});
  }

  [[nodiscard]] std::uint64_t device_bytes() const {
    std::uint64_t bytes = 0;
    const auto add = [&](const DeviceTable& table) {
      for (const DeviceTable::Slice& slice : table.slices())
        bytes += slice.entries.size() + slice.chunks.size() + slice.derivatives.size();
    };
    for (const DeviceTable& table : refinement) add(table);
    add(*limit);
    return bytes;
  }

  std::vector<DeviceTable> refinement;
  std::optional<DeviceTable> limit;
  std::optional<TableEvaluation> evaluation;
};

// Not normals: those of the tables lose digits to points far from the origin.
std::vector<glm::dvec3> positions_of(VulkanMachine& machine, const Buffer& vertices) {
  std::vector<glm::dvec3> result;
  machine.submitter.download({vertices.handle(), 0, vertices.size()},
                             [&](std::uint64_t, std::span<const std::byte> piece) {
                               for (std::size_t at = 0; at < piece.size();
                                    at += kFrameVertexBytes) {
                                 glm::vec3 value;
                                 std::memcpy(&value, &piece[at], sizeof value);
                                 result.emplace_back(value);
                               }
                             });
  return result;
}

}  // namespace

std::vector<Row> bench_evaluate(const Options& options) {
  const auto owned = traced_machine(options);
  if (!owned) return {};
  VulkanMachine& machine = *owned;
  const PolygonMesh mesh = torus_grid(options.quad_count);
  const DeviceFrame frame(machine, mesh, {.level = kFrameLevel});
  machine.submitter.run(
      [&](VkCommandBuffer commands) { frame.solve.record_solve(commands, {.iterations = 8}); });
  const Buffer by_tables(machine.context, frame.vertices.size(), MemoryUse::Device);
  const FrameTables tables(machine, mesh, frame, by_tables);
  const auto evaluate_patches = [&] {
    machine.submitter.run([&](VkCommandBuffer commands) { frame.solve.record_evaluate(commands); });
  };
  const auto evaluate_tables = [&] {
    machine.submitter.run([&](VkCommandBuffer commands) { tables.evaluation->record(commands); });
  };
  evaluate_patches();
  evaluate_tables();
  require_agreement("patches", positions_of(machine, frame.vertices),
                    positions_of(machine, by_tables));

  Group group;
  group.name = "evaluate";
  group.size =
      formatted("{} quads, {} vertices; vulkan on {}; tables {}, System's whole {}",
                mesh.face_count(), frame.system.vertex_count(), machine.device.capabilities().name,
                megabytes(tables.device_bytes()), megabytes(frame.tables.device_bytes()));
  group.baseline = "planish-tables";
  group.peers.push_back({"planish-tables", evaluate_tables});
  group.peers.push_back({"planish-patches", evaluate_patches});
  return run_group(group, options.repetitions);
}

}  // namespace planish::bench
