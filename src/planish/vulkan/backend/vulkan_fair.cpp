#include "planish/vulkan/backend/vulkan_fair.h"

#include <algorithm>
#include <cstring>

#include "planish/core/assert.h"
#include "planish/fair/fold_cure.h"
#include "planish/fair/vertex_frame.h"
#include "planish/vulkan/fair/gpu_fair.h"

namespace planish::vulkan {

namespace {

std::vector<std::uint32_t> download_words(Submitter& submitter, const Buffer& source,
                                          std::size_t count) {
  std::vector<std::uint32_t> words(count);
  submitter.download({source.handle(), 0, count * sizeof words[0]},
                     [&](std::uint64_t offset, std::span<const std::byte> piece) {
                       std::memcpy(&words[offset / sizeof words[0]], piece.data(), piece.size());
                     });
  return words;
}

// The few vertices that repair cannot help; `net.state` is relative to the given points.
void cure_on_host(const FairTopology& topology, std::span<const glm::dvec3> given,
                  const FairOptions& options, FairNet& net) {
  const std::vector<glm::dvec3> face_normals = unit_face_normals(topology, given);
  const std::vector<glm::dvec3> normals = vertex_normals(topology, given, face_normals);
  const CureInput input{topology, given, face_normals, normals, net.state};
  std::vector<std::uint8_t>& cures = net.decisions.cures;
  cures.assign(given.size(), 0);
  if (options.decisions && options.cures_folds) cures = options.decisions->cures;
  const bool decided = options.decisions || !options.cures_folds;
  const FoldCount folds = decided ? repeat_cure(input, cures) : cure_folds(input, cures);
  for (std::size_t s = 0; s < topology.curve_points.size(); ++s) {
    const FairTopology::CurvePoint& place = topology.curve_points[s];
    if (topology.kind(place.vertex) != VertexKind::Dart) continue;
    net.state[static_cast<std::size_t>(topology.corner_count) + s] =
        (net.state[place.corner_after] + net.state[place.corner_before]) / 2.0;
  }
  net.cured_vertices = std::count_if(cures.begin(), cures.end(), [](auto c) { return c > 0; });
  net.flagged_edges = folds.edges;
  net.flagged_faces = folds.faces;
}

}  // namespace

FairNet build_fair_net(VulkanMachine& machine, const FairTopology& topology,
                       std::span<const glm::dvec3> given, const FairOptions& options) {
  require_valid(options);
  PLANISH_ASSERT(std::ssize(given) == topology.vertex_count);
  Context& context = machine.context;
  const FairRecords records = fair_records(topology, options.decisions);
  const FairTables tables(context, records);
  tables.for_each(records, [&](const Buffer& buffer, std::span<const std::byte> bytes) {
    machine.submitter.upload({buffer.handle(), 0, bytes.size()}, bytes);
  });
  const Buffer points(context, given.size() * shared::kPointFloats * sizeof(float),
                      MemoryUse::Device, "planish given points");
  machine.upload_points(points, given);
  options.callbacks.check_cancelled();

  GpuFairOptions on_device;
  on_device.polish_steps = static_cast<std::uint32_t>(options.polish_steps);
  const GpuFair fair(context, tables, points, on_device);
  machine.submitter.run([&](VkCommandBuffer commands) { fair.record(commands); });

  // What the given points lose to single precision is nothing that the net must lose.
  FairNet net;
  net.state = machine.download_points(fair.buffers().result, records.owners.size());
  const std::vector<std::uint32_t> decisions =
      download_words(machine.submitter, fair.buffers().decisions, given.size());
  for (const std::uint32_t word : decisions) {
    net.reversed_vertices += (word & shared::kReversed) != 0;
    net.shrunk_vertices += (word & (shared::kReversed - 1)) != 0;
  }
  net.decisions = unpack_decisions(decisions);
  cure_on_host(topology, given, options, net);
  for (std::size_t i = 0; i < net.state.size(); ++i) net.state[i] += given[records.owners[i]];
  return net;
}

}  // namespace planish::vulkan
