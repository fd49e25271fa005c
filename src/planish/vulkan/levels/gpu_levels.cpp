#include "planish/vulkan/levels/gpu_levels.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"
#include "planish/mesh/face_geometry.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/host/system.h"

namespace planish::vulkan {
namespace {

// Corners whose grids are made at once.
constexpr std::size_t kGridCorners = 32;

// From a chord's nearest point.
glm::dvec3 from_chord(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 along = b - a;
  const double square = glm::dot(along, along);
  const double t = square > 0 ? std::clamp(glm::dot(point - a, along) / square, 0.0, 1.0) : 0.0;
  return point - (a + t * along);
}

// The corners' grids of a level above all others.
class ChordMeasure {
 public:
  ChordMeasure(const SurfaceRecords& surface, std::span<const glm::dvec3> state,
               std::span<const int> levels)
      : surface_(surface),
        state_(state),
        levels_(levels),
        fine_(surface.patch_mesh, surface.patch_options(levels.back() + 1)) {
    for (const int level : levels) cells_.emplace_back(level);
  }

  [[nodiscard]] std::vector<double> of(std::span<const std::int32_t> corners) const {
    const PatchSamples& samples = fine_.numbering().samples();
    const auto count = static_cast<std::size_t>(samples.count());
    std::vector<glm::dvec3> points(corners.size() * count);
    std::vector<glm::vec3> normals(points.size());
    PatchTarget target;
    target.positions = points;
    target.normals = normals;
    fine_.grids(state_, Placement{}, corners, target);
    std::vector<double> largest(levels_.size());
    for (std::size_t i = 0; i < corners.size(); ++i)
      for (std::size_t k = 0; k < levels_.size(); ++k)
        largest[k] = std::max(largest[k],
                              of_level(k, corners[i], std::span(points).subspan(i * count, count),
                                       std::span(normals).subspan(i * count, count)));
    return largest;
  }

 private:
  // Of the sides of a level's quads, and of the diagonals that part their triangles.
  [[nodiscard]] double of_level(std::size_t k, std::int32_t corner,
                                std::span<const glm::dvec3> points,
                                std::span<const glm::vec3> normals) const {
    const PatchSamples& samples = fine_.numbering().samples();
    const std::int32_t side = 1 << (levels_[k] - 1), half = samples.side() / side / 2;
    const bool is_sharp_below = surface_.patch_mesh.is_sharp(corner),
               is_sharp_left = surface_.patch_mesh.is_sharp(surface_.topology->prev(corner));
    const auto at = [&](std::int32_t place) {
      return points[samples.index(place % (side + 1) * 2 * half, place / (side + 1) * 2 * half)];
    };
    double largest = 0;
    const auto take = [&](std::int32_t x, std::int32_t y) {
      const std::int32_t a = x % (side + 1) + y % (side + 1), b = x / (side + 1) + y / (side + 1);
      const std::int32_t m = samples.index(a * half, b * half);
      const glm::dvec3 off = from_chord(points[m], at(x), at(y));
      // Beside singular places a middle lies aside within the surface, which is no error but where
      // it ends.
      const bool is_end = (b == 0 && is_sharp_below) || (a == 0 && is_sharp_left);
      const glm::dvec3 normal(normals[m]);
      largest =
          std::max(largest, is_end || normal == glm::dvec3(0) ? glm::length(off)
                                                              : std::abs(glm::dot(normal, off)));
    };
    for (const auto& cell : cells_[k].of(*surface_.topology, corner)) {
      for (std::size_t i = 0; i < 4; ++i) take(cell[i], cell[(i + 1) % 4]);
      const bool from_1 = is_cut_from_1(at(cell[0]), at(cell[1]), at(cell[2]), at(cell[3]));
      take(cell[from_1 ? 1 : 0], cell[from_1 ? 3 : 2]);
    }
    return largest;
  }

  const SurfaceRecords& surface_;
  std::span<const glm::dvec3> state_;
  std::span<const int> levels_;
  PatchSurface fine_;
  std::vector<PatchCells> cells_;
};

}  // namespace

LevelRecords::LevelRecords(const SurfaceRecords& surface, int level)
    : patches(surface.patch_mesh, surface.patch_options(level)) {
  if (surface.uvs) frames = row_frames(patches, surface.weights, *surface.uv_field);
}

double sphere_radius(std::span<const glm::dvec3> points) {
  if (points.empty()) return 0;
  const auto [low, high] = point_bounds(points);
  double radius = 0;
  for (const glm::dvec3& p : points)
    radius = std::max(radius, glm::distance(p, 0.5 * (low + high)));
  return radius;
}

LevelSet make_levels(const PolygonMesh& mesh, const SurfaceRecords& surface,
                     std::span<const glm::dvec3> hull, const PosedSurface& rest,
                     std::span<const int> levels) {
  LevelSet set;
  set.radius = sphere_radius(hull);
  const ChordMeasure measure(surface, rest.state, levels);
  const std::vector<std::int32_t> corners = kept_corners(mesh, *surface.topology);
  const std::vector<double> chords = ordered_reduce(
      corners.size(), kGridCorners, std::vector<double>(levels.size()),
      [&](std::size_t begin, std::size_t end) {
        return measure.of(std::span(corners).subspan(begin, end - begin));
      },
      [](std::vector<double>& total, const std::vector<double>& part) {
        for (std::size_t k = 0; k < total.size(); ++k) total[k] = std::max(total[k], part[k]);
      });
  for (std::size_t k = 0; k < levels.size(); ++k) {
    LevelRecords& level = set.levels.emplace_back(surface, levels[k]);
    const std::vector<std::uint32_t> triangles = kept_faces(mesh, level.patches, rest).triangles;
    level.first_index = set.triangles.size();
    level.index_count = triangles.size();
    set.triangles.insert(set.triangles.end(), triangles.begin(), triangles.end());
    if (set.radius > 0) level.chord = chords[k] / set.radius;
  }
  return set;
}

LevelSetTables::LevelSetTables(const Maker& on, const LevelSet& set,
                               std::span<const PatchRecords> records)
    : indices(on, set.triangles.size() * sizeof(std::uint32_t), MemoryUse::Device,
              "planish indices") {
  for (std::size_t i = 0; i < records.size(); ++i) {
    const LevelRecords& level = set.levels[i];
    const std::int32_t points = level.patches.mesh().point_count();
    levels.push_back({level.patches.numbering().level(), PatchTables(on, records[i], points),
                      static_cast<std::uint32_t>(level.patches.numbering().row_count()),
                      static_cast<std::uint32_t>(level.first_index),
                      static_cast<std::uint32_t>(level.index_count),
                      static_cast<float>(level.chord)});
  }
}

namespace {

// Based on: the chord error of screen-space metrics, by what is visible of a bounding sphere; a
// choice a view, with hysteresis.

constexpr std::uint64_t kLevelWordBytes = sizeof(std::uint32_t);
constexpr std::uint64_t kMostVertices = 0x7fffffff;  // that a draw's vertexOffset can name
static_assert(sizeof(DrawnInstance) == shared::kDrawnWords * kLevelWordBytes);

}  // namespace

VertexLayout previous_layout(const TessellationOptions& options) {
  VertexLayout layout = options.vertices;
  const VertexStream& to = options.previous_positions;
  layout.buffer = to.buffer, layout.offset = to.offset, layout.stride = to.stride;
  layout.position_offset = 0;
  layout.normal_offset = layout.tangent_offset = kNotWritten;
  layout.attributes = {};
  return layout;
}

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
      place_pipeline_(context_.pipelines().specialised(Kernel::PlaceInstances, {})),
      numbers_draws_(options.numbers_draws) {
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
  draws_ = Buffer(on, (count + choose_.level_count) * shared::kDrawWords * kLevelWordBytes,
                  MemoryUse::Device, "planish draws");
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
      (parts_.steps ? parts_.steps->parts.size() : 0) + (parts_.patches.ring_count > 0 ? 1 : 0);
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
    first_listed_.push_back(words.end * kLevelWordBytes);
    words.end += level.places * shared::kDrawnWords;
  }
  place_.segment_count = static_cast<std::uint32_t>(words.segment_count);
  first_segment_ = words.first_segment * kLevelWordBytes;
  require_binding(context_, words.end * kLevelWordBytes, "lists of instances", kFewerInstances);
  work_ = Buffer(on, words.end * kLevelWordBytes, MemoryUse::Device, "planish instances");
  make_surface(on, {&parts_.given, parts_.displacement, &parts_.state}, options.vertices, words,
               surface_);
  make_template(on, words);
  if (options.previous_positions.stride > 0) make_kept(on, previous_layout(options), words);
}

void GpuLevels::make_surface(const Maker& on, const Points& points, const VertexLayout& vertices,
                             const Words& words, Surface& surface) const {
  const InstanceList seen{&work_, words.seen_list};
  const PatchTables& patches = parts_.patches;
  if (points.displacement)
    surface.step.emplace(
        on, patches, *parts_.steps,
        GpuFirstStep::Points{points.given, points.displacement, parts_.vertex_count, points.state},
        parts_.instances, seen);
  if (patches.ring_count > 0)
    surface.sums.emplace(on, patches, *points.given, *points.state, parts_.vertex_count,
                         parts_.instances, seen);
  for (std::size_t k = 0; k < words.levels.size(); ++k) {
    const LevelTables& tables = parts_.set.levels[k];
    const Words::Level& level = words.levels[k];
    VertexLayout layout = vertices;
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
    lists.links = &patches.links;
    lists.vertices = formatted("the Tessellation's vertices of level {}", tables.level);
    lists.remedy = formatted(
        "give that level fewer places than {} (TessellationOptions::places), or vertices a smaller "
        "stride",
        level.places);
    surface.patches.emplace_back(on, tables.patches, *points.given, *points.state, layout,
                                 parts_.vertex_count, parts_.instances, lists);
  }
}

// Only the points are kept: the view before may have had another level, or not have seen an
// instance.
void GpuLevels::make_kept(const Maker& on, const VertexLayout& vertices, const Words& words) {
  kept_.emplace();
  const auto copy_of = [&](const Buffer& points, const char* name) {
    return Buffer(on, points.size(), MemoryUse::Device, name);
  };
  kept_->given = copy_of(parts_.given, "planish points of the view before");
  kept_->moving = copy_of(moving(), "planish displacement of the view before");
  const bool steps = parts_.displacement != nullptr;
  make_surface(
      on, {&kept_->given, steps ? &kept_->moving : nullptr, steps ? &parts_.state : &kept_->moving},
      vertices, words, kept_->surface);
}

void GpuLevels::make_template(const Maker& on, const Words& words) {
  std::vector<std::uint32_t> head;
  std::uint32_t first_row = 0;
  for (std::size_t k = 0; k < words.levels.size(); ++k) {
    const LevelTables& tables = parts_.set.levels[k];
    const Words::Level& level = words.levels[k];
    head.insert(head.end(), {level.places, tables.vertex_count, tables.index_count,
                             tables.first_index, level.first_vertex, level.list, first_row});
    first_row += tables.vertex_count;
  }
  const auto add_segment = [&](std::uint32_t groups, std::uint32_t level) {
    const auto [x, z] = context_.groups_in_layers(groups);
    head.insert(head.end(), {x, 0, z, level});
  };
  const auto& [step, sums, patches] = surface_;
  for (std::size_t i = 0; step && i < step->round_count(); ++i)
    add_segment(step->group_count(i), shared::kNone);
  if (sums) add_segment(sums->group_count(), shared::kNone);
  for (std::uint32_t k = 0; k < patches.size(); ++k)
    for (std::size_t i = 0; i < patches[k].round_count(); ++i)
      add_segment(patches[k].group_count(i), k);
  template_ =
      Buffer(on, head.size() * kLevelWordBytes, MemoryUse::Upload, "planish empty instances");
  template_.write(std::as_bytes(std::span(head)));
}

void GpuLevels::record_reset(VkCommandBuffer commands) const noexcept {
  context_.vk().vkCmdFillBuffer(commands, levels_.handle(), 0, VK_WHOLE_SIZE, shared::kNone);
  if (kept_) record_keep(commands);
}

// Of the next view the points of the view before.
void GpuLevels::record_keep(VkCommandBuffer commands) const noexcept {
  const auto copy = [&](const Buffer& from, const Buffer& to) {
    const VkBufferCopy all{0, 0, from.size()};
    context_.vk().vkCmdCopyBuffer(commands, from.handle(), to.handle(), 1, &all);
  };
  copy(parts_.given, kept_->given);
  copy(moving(), kept_->moving);
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
  if (kept_) record_surface(commands, kept_->surface);
  record_surface(commands, surface_);
  if (kept_) {
    record_barrier(context_, commands, kEntryScope, kEntryScope);
    record_keep(commands);
  }
  record_barrier(context_, commands, kExitScope, kExitScope);
}

void GpuLevels::record_surface(VkCommandBuffer commands, const Surface& surface) const noexcept {
  const auto& [step, sums, patches] = surface;
  std::size_t segment = 0;
  for (std::size_t i = 0; step && i < step->round_count(); ++i) {
    (void)step->record_listed(commands, i, groups_of(segment++));
    wait(commands);
  }
  if (sums) {
    (void)sums->record_listed(commands, groups_of(segment++));
    wait(commands);
  }
  // Of all levels in lock-step.
  record_rounds(context_, commands, patches.size(), [&](std::size_t level, std::uint32_t round) {
    return patches[level].record_round(commands, round);
  });
}

LevelDraw GpuLevels::level_draw(std::size_t level) const {
  return {draws_.handle(), (parts_.instances.count + level) * shared::kDrawWords * kLevelWordBytes,
          work_.handle(), first_listed_[numbers_draws_ ? 0 : level]};
}

}  // namespace planish::vulkan
