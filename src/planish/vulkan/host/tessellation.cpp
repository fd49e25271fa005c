#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/host/device_system.h"
#include "planish/vulkan/host/write_timestamps.h"

namespace planish::vulkan {

namespace {

// A number of places for each level.
std::vector<std::uint32_t> places_of(const LevelSetTables& tables, std::uint32_t count,
                                     std::vector<std::uint32_t> places) {
  const std::size_t levels = tables.levels.size();
  if (places.empty()) places.assign(levels, count);
  require_option(places.size() == levels, "places are of {} levels, but the System has {}",
                 places.size(), levels);
  for (std::uint32_t& of_level : places) {
    require_option(of_level > 0,
                   "a level has places for no instance; give it some, or leave it out");
    of_level = std::min(of_level, count);
  }
  require_option(places[0] == count,
                 "the coarsest level has places for {} instances, but takes all {}", places[0],
                 count);
  return places;
}

std::uint64_t vertex_total(const LevelSetTables& tables, std::span<const std::uint32_t> places) {
  std::uint64_t vertices = 0;
  for (std::size_t k = 0; k < places.size(); ++k)
    vertices += std::uint64_t{places[k]} * tables.levels[k].vertex_count;
  return vertices;
}

TessellationOptions checked(const LevelSetTables& tables, const EvaluatedParts& solve,
                            TessellationOptions options) {
  require_option(options.vertices.buffer, "vertices of a Tessellation have no buffer");
  check_layout(options.vertices, solve.sizes);
  require_option(attributes_of(options.vertices).buffer == options.vertices.buffer,
                 "a Tessellation has positions and attributes in one buffer");
  options.places = places_of(tables, solve.chosen.instances.count, std::move(options.places));
  const std::vector<HostRange> written = vertex_ranges(options.vertices, " of the Tessellation",
                                                       vertex_total(tables, options.places), 1);
  require_apart(written);
  require_apart(solve.read, written);
  return options;
}

const LevelSetTables& level_set_of(const std::optional<LevelSetTables>& tables) {
  require_option(tables.has_value(),
                 "the System has no levels to choose from; give SystemOptions some");
  return *tables;
}

}  // namespace

std::uint64_t DeviceSystem::tessellation_bytes(const TessellationOptions& options,
                                               std::uint32_t instances) const {
  const LevelSetTables& tables = level_set_of(parts_->levels);
  const std::uint64_t vertices = vertex_total(tables, places_of(tables, instances, options.places));
  const VertexStream attributes = attributes_of(options.vertices);
  return std::max(options.vertices.offset + vertices * options.vertices.stride,
                  attributes.offset + vertices * attributes.stride);
}

struct Tessellation::Parts {
  Parts(Context& on, const LevelSetTables& tables, const EvaluatedParts& solve,
        const TessellationOptions& options)
      : arena(on),
        context(on),
        given(solve.given),
        instances(solve.chosen.instances),
        indices(tables.indices.handle()),
        levels(arena, solve.chosen, checked(tables, solve, options)) {
    arena.finish();
  }

  Arena arena;  // of all that follows
  Context& context;
  const GpuGiven* given;
  Instances instances;
  VkBuffer indices;
  GpuLevels levels;
};

Tessellation::Tessellation(Context& context, const DeviceSystem& system, const Solve& solve,
                           const TessellationOptions& options) {
  const LevelSetTables& tables = level_set_of(system.parts_->levels);
  parts_ = std::make_unique<Parts>(context, tables, solve.evaluated_parts(), options);
}
Tessellation::~Tessellation() = default;
Tessellation::Tessellation(Tessellation&&) noexcept = default;
Tessellation& Tessellation::operator=(Tessellation&&) noexcept = default;

void Tessellation::record_reset(VkCommandBuffer commands) const noexcept {
  record_barrier(parts_->context, commands, kExitScope, kEntryScope);
  parts_->levels.record_reset(commands);
}

void Tessellation::record_evaluate(VkCommandBuffer commands,
                                   const TessellateParameters& parameters) const noexcept {
  const Context& context = parts_->context;
  const LabelScope label(context, commands, "planish levels");
  record_barrier(context, commands, kExitScope, kEntryScope);
  write_first(context, commands, parameters.timestamps);
  if (parts_->given) parts_->given->record_control_points(commands);
  parts_->levels.record(commands, parameters);
  write_second(context, commands, parameters.timestamps);
}

void Tessellation::record_levels(VkCommandBuffer commands, VkBuffer target,
                                 VkDeviceSize offset) const noexcept {
  const Context& context = parts_->context;
  record_barrier(context, commands, kExitScope, kEntryScope);
  const VkDeviceSize bytes = VkDeviceSize(parts_->instances.count) * sizeof(std::uint32_t);
  const VkBufferCopy copy{bytes, offset, bytes};
  context.vk().vkCmdCopyBuffer(commands, parts_->levels.levels(), target, 1, &copy);
}

VkBuffer Tessellation::draws() const { return parts_->levels.draws(); }
VkBuffer Tessellation::indices() const { return parts_->indices; }

}  // namespace planish::vulkan
