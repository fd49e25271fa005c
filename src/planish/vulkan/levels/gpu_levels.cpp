// Based on: the chord error of screen-space metrics, by what is visible of a bounding sphere; a
// choice a view, with hysteresis.
#include "planish/vulkan/levels/gpu_levels.h"

#include <algorithm>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

namespace {

constexpr std::uint64_t kLevelWordBytes = sizeof(std::uint32_t);
constexpr std::uint64_t kMostVertices = 0x7fffffff;  // that a draw's vertexOffset can name

}  // namespace

/// Where in the work's words things stand, and of how many of each the levels have room.
struct GpuLevels::Words {
  struct Level {
    std::uint32_t places, first_vertex, list, first_segment;
  };
  std::vector<Level> levels;
  std::uint32_t first_segment, seen_list, end;
  std::size_t segment_count;
};

GpuLevels::GpuLevels(const Maker& on, const ChosenParts& parts, const TessellationOptions& options)
    : context_(on.context()),
      parts_(parts),
      choose_pipeline_(context_.pipelines().specialised(Kernel::ChooseLevels, {})),
      place_pipeline_(context_.pipelines().specialised(Kernel::PlaceInstances, {})) {
  const std::uint32_t count = parts.instances.count;
  choose_.instance_count = place_.instance_count = count;
  choose_.point_count = static_cast<std::uint32_t>(parts.hull_count);
  choose_.point_stride = static_cast<std::uint32_t>(parts.hull_stride);
  choose_.level_count = place_.level_count = static_cast<std::uint32_t>(parts.set.levels.size());
  place_.numbers_draws = options.numbers_draws ? 1 : 0;
  for (std::size_t k = 0; k < parts.set.levels.size(); ++k)
    choose_.chords[k] = parts.set.levels[k].chord;
  require_binding(context_, parts.hull.size(), "points around instances", kFewerInstances);
  levels_ = Buffer(on, 2 * count * kLevelWordBytes, MemoryUse::Device, "planish levels");
  draws_ =
      Buffer(on, count * shared::kDrawWords * kLevelWordBytes, MemoryUse::Device, "planish draws");
  make_work(on, options);
  const BoundKernel bound[] = {
      {Kernel::ChooseLevels, {whole(parts.hull), whole(levels_)}},
      {Kernel::PlaceInstances, {whole(levels_), whole(work_), whole(draws_)}}};
  sets_ = DescriptorSets(on, bound);
}

void GpuLevels::make_work(const Maker& on, const TessellationOptions& options) {
  const std::deque<LevelTables>& levels = parts_.set.levels;
  Words words;
  words.segment_count =
      (parts_.step ? parts_.step->round_count() : 0) + (parts_.patches.ring_count > 0 ? 1 : 0);
  std::uint64_t vertices = 0;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    words.levels.push_back({options.places[k], static_cast<std::uint32_t>(vertices), 0,
                            static_cast<std::uint32_t>(words.segment_count)});
    words.segment_count += levels[k].patches.slices.size();
    vertices += std::uint64_t(options.places[k]) * levels[k].vertex_count;
    if (vertices > kMostVertices)
      throw Error(ErrorCode::OutOfMemory,
                  formatted("a Tessellation's levels up to {} have places for {} vertices, but "
                            "draws can name {}; give TessellationOptions fewer places",
                            levels[k].level, vertices, kMostVertices));
  }
  words.first_segment = place_.level_count * shared::kLevelWords;
  words.seen_list =
      words.first_segment + static_cast<std::uint32_t>(words.segment_count) * shared::kChosenWords;
  words.end = words.seen_list + parts_.instances.count;
  for (Words::Level& level : words.levels) {
    level.list = words.end;
    words.end += level.places;
  }
  place_.segment_count = static_cast<std::uint32_t>(words.segment_count);
  first_segment_ = words.first_segment * kLevelWordBytes;
  require_binding(context_, words.end * kLevelWordBytes, "lists of instances", kFewerInstances);
  work_ = Buffer(on, words.end * kLevelWordBytes, MemoryUse::Device, "planish instances");
  make_surface(on, words);
  make_patches(on, options, words);
}

void GpuLevels::make_surface(const Maker& on, const Words& words) {
  const InstanceList seen{&work_, words.seen_list};
  if (parts_.step) step_.emplace(on, parts_.patches, *parts_.steps, *parts_.step, seen);
  if (parts_.patches.ring_count > 0)
    sums_.emplace(on, parts_.patches, parts_.given, parts_.state, parts_.vertex_count,
                  parts_.instances, seen);
}

void GpuLevels::make_patches(const Maker& on, const TessellationOptions& options,
                             const Words& words) {
  std::vector<std::uint32_t> head;
  for (std::size_t k = 0; k < words.levels.size(); ++k) {
    const LevelTables& tables = parts_.set.levels[k];
    const Words::Level& level = words.levels[k];
    VertexLayout layout = options.vertices;
    layout.offset += VkDeviceSize(level.first_vertex) * layout.stride;
    layout.instance_stride = VkDeviceSize(tables.vertex_count) * layout.stride;
    VertexStream& attributes = layout.attributes;
    attributes.offset += VkDeviceSize(level.first_vertex) * attributes.stride;
    attributes.instance_stride = VkDeviceSize(tables.vertex_count) * attributes.stride;
    PatchLists lists;
    lists.work = &work_;
    lists.kernel = Kernel::InstancePatches;
    lists.first_arguments = words.first_segment + level.first_segment * shared::kChosenWords;
    lists.arguments_step = shared::kChosenWords;
    lists.first_list = level.list;
    lists.places = {level.places};
    lists.links = &parts_.patches.links;
    lists.vertices = formatted("the Tessellation's vertices of level {}", tables.level);
    lists.remedy = formatted(
        "give that level fewer places than {} (TessellationOptions::places), or vertices a smaller "
        "stride",
        level.places);
    patches_.emplace_back(on, tables.patches, parts_.given, parts_.state, layout,
                          parts_.vertex_count, parts_.instances, lists);
    head.insert(head.end(), {level.places, tables.vertex_count, tables.index_count,
                             tables.first_index, level.first_vertex, level.list});
  }
  const auto add_segment = [&](std::uint32_t groups, std::uint32_t level) {
    const auto [x, z] = context_.groups_in_layers(groups);
    head.insert(head.end(), {x, 0, z, level});
  };
  for (std::size_t i = 0; step_ && i < step_->round_count(); ++i)
    add_segment(step_->group_count(i), shared::kNone);
  if (sums_) add_segment(sums_->group_count(), shared::kNone);
  for (std::uint32_t k = 0; k < patches_.size(); ++k)
    for (std::size_t i = 0; i < patches_[k].round_count(); ++i)
      add_segment(patches_[k].group_count(i), k);
  template_ =
      Buffer(on, head.size() * kLevelWordBytes, MemoryUse::Upload, "planish empty instances");
  template_.write(std::as_bytes(std::span(head)));
}

void GpuLevels::record_reset(VkCommandBuffer commands) const noexcept {
  context_.vk().vkCmdFillBuffer(commands, levels_.handle(), 0, VK_WHOLE_SIZE, shared::kNone);
}

void GpuLevels::wait(VkCommandBuffer commands) const noexcept {
  record_barrier(context_, commands, kIndirectScope, kIndirectScope);
}

void GpuLevels::record_choice(VkCommandBuffer commands,
                              const TessellateParameters& view) const noexcept {
  shared::ChooseParameters parameters = choose_;
  std::ranges::copy(view.clip_from_world, parameters.clip);
  parameters.pixels = 0.5f * view.viewport_height;
  parameters.most = view.chord_pixels;
  parameters.coarser_at = view.chord_pixels * view.coarser_at;
  record_dispatch(context_, commands, choose_pipeline_, sets_[Choose], &parameters,
                  std::min(parameters.instance_count, context_.max_group_count()));
  wait(commands);
  record_dispatch(context_, commands, place_pipeline_, sets_[PlaceAll], &place_, 1);
  wait(commands);
}

void GpuLevels::record(VkCommandBuffer commands, const TessellateParameters& view) const noexcept {
  const VkBufferCopy heads{0, 0, template_.size()};
  context_.vk().vkCmdCopyBuffer(commands, template_.handle(), work_.handle(), 1, &heads);
  record_barrier(context_, commands, kEntryScope, kEntryScope);
  record_choice(commands, view);
  std::size_t segment = 0;
  for (std::size_t i = 0; step_ && i < step_->round_count(); ++i) {
    (void)step_->record_listed(commands, i, groups_of(segment++));
    wait(commands);
  }
  if (sums_) {
    (void)sums_->record_listed(commands, groups_of(segment++));
    wait(commands);
  }
  // Of all levels in lock-step.
  record_rounds(context_, commands, patches_.size(), [&](std::size_t level, std::uint32_t round) {
    return patches_[level].record_round(commands, round);
  });
  record_barrier(context_, commands, kExitScope, kExitScope);
}

}  // namespace planish::vulkan
