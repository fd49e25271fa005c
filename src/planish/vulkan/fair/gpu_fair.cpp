#include "planish/vulkan/fair/gpu_fair.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <vector>

#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/context.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {

// Collects passes with the buffers that their kernels bind.
struct GpuFair::Binder {
  const Context& context;
  shared::FairParameters common;
  std::vector<BoundKernel> bound{};

  // Of `count` elements `large_count` are done by a work group each, where the kernel walks around
  // them.
  Pass& add(Passes& passes, Kernel kernel, std::uint32_t count,
            std::initializer_list<const Buffer*> buffers, std::uint32_t large_count = 0) {
    BoundKernel& kernel_buffers = bound.emplace_back(BoundKernel{kernel, {}});
    for (const Buffer* buffer : buffers) kernel_buffers.buffers.push_back(whole(*buffer));
    Pass pass{context.pipelines().specialised(kernel, {}), bound.size() - 1, common,
              context.groups_of(count)};
    pass.parameters.count = count;
    if (large_count > 0) {
      const std::uint32_t by_groups[] = {1};
      pass.large = context.pipelines().specialised(kernel, by_groups);
      pass.large_count = large_count;
      pass.large_groups = std::min(large_count, context.max_group_count());
    }
    return passes.emplace_back(pass);
  }

  // A kernel that adds up over its work groups, of which there is at least one.
  Pass& add_sum(Passes& passes, Kernel kernel, std::uint32_t count,
                std::initializer_list<const Buffer*> buffers, std::uint32_t large_count = 0) {
    Pass& pass = add(passes, kernel, count, buffers, large_count);
    pass.groups = std::clamp(pass.groups, 1u, shared::kMostSumGroups);
    pass.large_groups = std::min(pass.large_groups, shared::kMostSumGroups);
    pass.parameters.partial_count = pass.groups + pass.large_groups;
    return pass;
  }
};

namespace {

// An own method, step by step that of fair/fair_net.cpp, whose functions are the kernels' twins.

constexpr int kMaskSteps = 3;

}  // namespace

GpuFair::GpuFair(const Maker& on, const FairTables& tables, const Buffer& model_points,
                 const GpuFairOptions& options)
    : context_(on.context()), tables_(tables), options_(options) {
  make_buffers(on);
  Binder binder{context_, {}};
  const glm::vec3 origin(tables.placement.centre);
  binder.common.x = origin.x;
  binder.common.y = origin.y;
  binder.common.z = origin.z;
  binder.common.scale = static_cast<float>(tables.placement.diagonal);
  binder.common.decided = tables.is_decided ? 1 : 0;
  binder.common.vertex_count = tables.vertex_count;
  binder.common.corner_count = tables.corner_count;
  plan_prepare(binder, model_points);
  plan_build(binder);
  plan_repair(binder);
  plan_polish(binder);
  plan_cure(binder);
  plan_finish(binder, model_points);
  sets_ = DescriptorSets(on, binder.bound);
  plan_rounds();
}

void GpuFair::make_buffers(const Maker& on) {
  const auto make = [&](Buffer& buffer, std::uint64_t bytes) {
    buffer = make_bindable(on, bytes, "planish fair work");
  };
  const std::uint64_t vertices = tables_.vertex_count, corners = tables_.corner_count;
  Buffers& b = buffers_;
  for (Buffer* buffer : {&b.given, &b.normals}) make(*buffer, vertices * kPointBytes);
  make(b.face_normals, tables_.face_count * kPointBytes);
  make(b.given_offsets, corners * kPointBytes);
  if (tables_.has_regular_vertices) {
    for (Buffer* buffer : {&b.points, &b.next_points}) make(*buffer, vertices * kPointBytes);
    make(b.offsets, corners * kPointBytes);
  }
  make(b.sector_normals, tables_.sector_count * kPointBytes);
  make(b.shifts, tables_.crease_count * kPointBytes);
  for (Buffer* buffer : {&b.result, &b.state}) make(*buffer, tables_.state_size * kPointBytes);
  make(b.state_offsets, (tables_.state_size + options_.sum_count) * kPointBytes);
  for (Buffer* buffer : {&b.shares, &b.flags, &b.decisions, &b.precondition})
    make(*buffer, vertices * sizeof(float));
  make(b.counts, shared::kFairCounts * sizeof(std::uint32_t));
  make(b.arguments, shared::kRoundDispatches * shared::kArgumentWords * sizeof(std::uint32_t));
  make(b.status, sizeof(shared::SolveStatus));
  if (options_.cures_folds) {
    make(b.heights, tables_.face_count * sizeof(float));
    make(b.planes, 2 * vertices * kPointBytes);
  }
  if (options_.polish_steps == 0) return;
  make(b.directions, vertices * kPointBytes);
  for (Buffer* buffer : {&b.rows1, &b.rows2}) make(*buffer, corners * 4 * sizeof(float));
  make(b.lines, corners * 2 * sizeof(float));
  for (Buffer& buffer : b.motions) make(buffer, tables_.state_size * 4 * sizeof(float));
  make(b.gradient, corners * sizeof(float));
  make(b.partials, 2 * shared::kMostSumGroups * sizeof(float));  // of lanes', of groups' elements
  make(b.scalars, sizeof(shared::FairScalars));
}

void GpuFair::plan_prepare(Binder& binder, const Buffer& model_points) {
  const FairTables& t = tables_;
  Buffers& b = buffers_;
  const auto add_vertices = [&](Kernel kernel, std::initializer_list<const Buffer*> buffers) {
    binder.add(prepare_, kernel, t.vertex_count, buffers, t.large_vertex_count);
  };
  const auto add_faces = [&](Kernel kernel, std::initializer_list<const Buffer*> buffers) {
    binder.add(prepare_, kernel, t.face_count, buffers, t.large_face_count);
  };
  binder.add(prepare_, Kernel::FairPlace, t.vertex_count, {&model_points, &b.given});
  add_faces(Kernel::FairFaceNormals, {&t.faces, &t.owners, &b.given, &b.face_normals});
  add_vertices(Kernel::FairVertexNormals,
               {&t.vertices, &t.places, &b.given, &b.face_normals, &b.normals});
  const auto add_offsets = [&](const Buffer& points, const Buffer& offsets) {
    add_faces(Kernel::FairOffsets, {&t.faces, &t.owners, &b.given, &points, &t.circle, &offsets});
  };
  add_offsets(b.given, b.given_offsets);
  if (!t.has_regular_vertices) return;  // all shares stay 0
  // Those of large vertices alone; next_points has room for them until then.
  binder.add(prepare_, Kernel::FairLimitErrors, 0,
             {&t.vertices, &t.places, &b.given_offsets, &b.next_points}, t.large_vertex_count);
  add_vertices(Kernel::FairShares, {&t.vertices, &t.places, &b.given, &b.given_offsets, &b.normals,
                                    &b.next_points, &b.shares});
  const Buffer* points = &b.given;
  const Buffer* offsets = &b.given_offsets;
  for (int step = 0; step < kMaskSteps; ++step) {
    const Buffer* next = step % 2 == 0 ? &b.points : &b.next_points;
    add_vertices(Kernel::FairMaskStep,
                 {&t.vertices, &t.places, &b.given, &b.shares, offsets, points, next});
    points = next;
    offsets = &b.offsets;
    add_offsets(*points, *offsets);
  }
  static_assert(kMaskSteps % 2 == 1, "the last points are in buffers_.points");
}

void GpuFair::plan_build(Binder& binder) {
  const FairTables& t = tables_;
  Buffers& b = buffers_;
  const Buffer& points = t.has_regular_vertices ? b.points : b.given;
  binder.add(build_, Kernel::FairPolygons, t.vertex_count,
             {&t.vertices, &t.places, &b.given, &b.normals, &b.shares, &offsets(), &b.result},
             t.large_vertex_count);
  binder.add(
      build_, Kernel::FairReversed, t.vertex_count,
      {&t.vertices, &t.places, &b.normals, &b.given_offsets, &t.circle, &b.result, &b.decisions},
      t.large_vertex_count);
  binder.add(build_, Kernel::FairSectorNormals, t.sector_count,
             {&t.sectors, &t.places, &b.given, &b.face_normals, &b.sector_normals},
             t.large_sector_count);
  binder.add(build_, Kernel::FairHandles, t.crease_count,
             {&t.creases, &b.given, &b.shares, &points, &b.face_normals, &b.shifts, &b.result});
  binder.add(build_, Kernel::FairCorridor, t.crease_count,
             {&t.creases, &b.given, &t.places, &b.face_normals, &b.given_offsets, &b.result},
             t.large_crease_count);
  binder.add(build_, Kernel::FairSectors, t.sector_count,
             {&t.sectors, &t.places, &b.given, &b.sector_normals, &b.given_offsets, &offsets(),
              &b.shifts, &b.result},
             t.large_sector_count);
  binder
      .add(curve_points_, Kernel::FairCurvePoints, t.curve_point_count,
           {&t.curve_points, &b.given, &points, &b.result})
      .parameters.place = t.corner_count;
}

// What is turned over: kernels of the repair, or of the cure.
void GpuFair::plan_fold_looks(Binder& binder, Passes& passes, Kernel edges, Kernel faces) {
  const FairTables& t = tables_;
  Buffers& b = buffers_;
  binder
      .add(passes, edges, t.edge_count,
           {&t.edges, &t.owners, &b.given, &b.face_normals, &b.result, &b.flags, &b.counts})
      .arguments = shared::kRoundEdges;
  binder
      .add(passes, faces, t.face_count,
           {&t.faces, &t.owners, &b.given, &b.face_normals, &b.result, &t.circle, &b.flags,
            &b.counts},
           t.large_face_count)
      .arguments = shared::kRoundFaces;
}

void GpuFair::plan_repair(Binder& binder) {
  const FairTables& t = tables_;
  Buffers& b = buffers_;
  plan_fold_looks(binder, find_folds_, Kernel::FairEdgeFolds, Kernel::FairFaceFolds);
  for (const std::uint32_t which : {0u, 1u}) {
    Pass& pass = binder.add(shrink_[which], Kernel::FairShrink, t.vertex_count,
                            {&t.vertices, &t.places, &b.flags, &b.decisions, &b.result},
                            t.large_vertex_count);
    pass.arguments = shared::kRoundVertices;
    pass.parameters.shift = which * shared::kLateShift;
  }
  shared::FairParameters& round =
      binder.add(next_round_, Kernel::FairRound, 1, {&b.counts, &b.arguments}).parameters;
  round.edge_groups = find_folds_[0].groups;
  round.face_groups = find_folds_[1].groups;
  round.vertex_groups = shrink_[0][0].groups;
  round.large_face_groups = find_folds_[1].large_groups;
  round.large_vertex_groups = shrink_[0][0].large_groups;
}

void GpuFair::plan_polish(Binder& binder) {
  if (options_.polish_steps == 0) return;
  const FairTables& t = tables_;
  Buffers& b = buffers_;
  binder.add(start_polish_, Kernel::FairDirections, t.vertex_count,
             {&t.vertices, &b.normals, &b.shares, &b.directions});
  binder.add(start_polish_, Kernel::FairRows, t.corner_count,
             {&t.links, &t.owners, &b.given, &b.directions, &b.result, &b.rows1, &b.rows2});
  binder.add(start_polish_, Kernel::FairDiagonals, t.vertex_count,
             {&t.vertices, &t.places, &t.links, &b.rows1, &b.rows2, &b.precondition, &b.scalars},
             t.large_vertex_count);
  binder.add(start_polish_, Kernel::FairPrecondition, t.vertex_count,
             {&b.precondition, &b.scalars});
  binder.common.start = 1;
  plan_polish_step(binder, start_polish_, b.motions[1], b.motions[0]);
  binder.common.start = 0;
  plan_polish_step(binder, step_polish_[0], b.motions[0], b.motions[1]);
  plan_polish_step(binder, step_polish_[1], b.motions[1], b.motions[0]);
  binder.add(end_polish_, Kernel::FairApplyHeights, t.vertex_count,
             {&t.vertices, &t.places, &b.directions, &motions(), &b.result}, t.large_vertex_count);
}

void GpuFair::plan_polish_step(Binder& binder, Passes& passes, const Buffer& from,
                               const Buffer& to) {
  const FairTables& t = tables_;
  Buffers& b = buffers_;
  binder.add_sum(passes, Kernel::FairLines, t.corner_count,
                 {&t.links, &b.rows1, &b.rows2, &from, &b.scalars, &b.lines, &b.partials});
  binder.add(passes, Kernel::FairGradient, t.corner_count,
             {&t.links, &b.rows1, &b.rows2, &b.lines, &b.gradient});
  binder.add_sum(
      passes, Kernel::FairDescend, t.vertex_count,
      {&t.vertices, &t.places, &b.gradient, &b.precondition, &from, &b.scalars, &to, &b.partials},
      t.large_vertex_count);
}

void GpuFair::plan_finish(Binder& binder, const Buffer& model_points) {
  const FairTables& t = tables_;
  Buffers& b = buffers_;
  binder.add(finish_, Kernel::FairMeasure, t.vertex_count,
             {&t.vertices, &t.places, &b.given, &b.result, &b.status}, t.large_vertex_count);
  binder.add(finish_, Kernel::FairState, t.state_size,
             {&t.owners, &model_points, &b.result, &b.state, &b.state_offsets});
}

void GpuFair::add_rounds(const Passes& passes, std::uint32_t place, Action action) {
  for (const Pass& pass : passes)
    if (pass.groups + pass.large_groups > 0) rounds_.push_back({action, &pass, place, kKernelWait});
}

void GpuFair::add_repair(std::uint32_t which) {
  const std::uint32_t first = which * shared::kRepairCounts;
  const std::uint32_t last = first + 2 * shared::kRepairRounds;
  if (tables_.is_decided) {
    add_rounds(shrink_[which]);
  } else {
    add_rounds(find_folds_, first);
    for (std::uint32_t place = first; place < last; place += 2) {
      add_rounds(next_round_, place);
      rounds_.back().wait |= {kKernelScope, kIndirectScope};
      // As often as the device finds something to do.
      add_rounds(shrink_[which], 0, Action::DispatchIndirect);
      add_rounds(find_folds_, place + 2, Action::DispatchIndirect);
      // The next round's arguments are written after these have been read.
      rounds_.back().wait |= {kIndirectScope, kKernelScope};
    }
  }
  // The last look leaves flags standing, which the next repair must not meet.
  rounds_.back().wait |= {kKernelScope, kEntryScope};
  rounds_.push_back({Action::ClearFlags, nullptr, 0, {kCopyScope, kEntryScope}});
}

void GpuFair::plan_rounds() {
  auto start = part_starts_.begin() + 1;
  const auto end_part = [&] { *start++ = rounds_.size(); };
  rounds_.push_back({Action::Clear, nullptr, 0, {kCopyScope, kEntryScope}});
  end_part();
  add_rounds(prepare_);
  end_part();
  add_rounds(build_);
  add_rounds(curve_points_);
  end_part();
  add_repair(0);
  end_part();
  if (options_.polish_steps > 0) {
    add_rounds(curve_points_);
    add_rounds(start_polish_);
    for (std::uint32_t step = 0; step < options_.polish_steps; ++step)
      add_rounds(step_polish_[step % 2]);
    add_rounds(end_polish_);
  }
  end_part();
  if (options_.polish_steps > 0) add_repair(1);
  end_part();
  add_cure();
  end_part();
  add_rounds(finish_);
  rounds_.back().wait |= {kKernelScope, kEntryScope};
  end_part();
}

void GpuFair::record_clear(VkCommandBuffer commands) const noexcept {
  const Buffers& b = buffers_;
  for (const Buffer* buffer : {&b.result, &b.shares, &b.flags, &b.counts, &b.status, &b.motions[0],
                               &b.motions[1], &b.scalars})
    if (buffer->handle())
      context_.vk().vkCmdFillBuffer(commands, buffer->handle(), 0, VK_WHOLE_SIZE, 0);
  if (tables_.is_decided) {
    const VkBufferCopy copy{0, 0, b.decisions.size()};
    context_.vk().vkCmdCopyBuffer(commands, tables_.decisions.handle(), b.decisions.handle(), 1,
                                  &copy);
    if (!b.planes.handle()) return;
    const VkBufferCopy leans{0, 0, b.planes.size()};
    context_.vk().vkCmdCopyBuffer(commands, tables_.leans.handle(), b.planes.handle(), 1, &leans);
  } else {
    context_.vk().vkCmdFillBuffer(commands, b.decisions.handle(), 0, VK_WHOLE_SIZE, 0);
    if (!b.planes.handle()) return;
    context_.vk().vkCmdFillBuffer(commands, b.planes.handle(), 0, VK_WHOLE_SIZE,
                                  shared::kNoLeanBits);
  }
}

Wait GpuFair::record_round(VkCommandBuffer commands, std::size_t number) const noexcept {
  if (number >= rounds_.size()) return {};
  const Round& round = rounds_[number];
  if (round.action == Action::Clear) {
    record_clear(commands);
  } else if (round.action == Action::ClearFlags) {
    context_.vk().vkCmdFillBuffer(commands, buffers_.flags.handle(), 0, VK_WHOLE_SIZE, 0);
  } else {
    const Pass& pass = *round.pass;
    shared::FairParameters parameters = pass.parameters;
    parameters.place += round.place;
    const auto record = [&](Pipeline pipeline, std::uint32_t groups, std::uint32_t arguments) {
      const VkDeviceSize offset =
          VkDeviceSize{arguments} * shared::kArgumentWords * sizeof(std::uint32_t);
      if (round.action == Action::DispatchIndirect)
        record_dispatch_indirect(context_, commands, pipeline, sets_[pass.set], &parameters,
                                 {buffers_.arguments.handle(), offset});
      else
        record_dispatch(context_, commands, pipeline, sets_[pass.set], &parameters, groups);
    };
    if (pass.groups > 0) record(pass.pipeline, pass.groups, pass.arguments);
    if (pass.large_groups > 0) {
      parameters.count = pass.large_count;
      parameters.first_partial = pass.groups;
      record(pass.large, pass.large_groups,
             pass.arguments == shared::kRoundFaces ? shared::kRoundLargeFaces
                                                   : shared::kRoundLargeVertices);
    }
  }
  return round.wait;
}

void GpuFair::record(VkCommandBuffer commands, FairPart part) const noexcept {
  const auto index = static_cast<std::size_t>(part);
  const std::size_t start = part_starts_[index], end = part_starts_[index + 1];
  record_rounds(context_, commands, 1, [&](std::size_t, std::uint32_t round) {
    return start + round < end ? record_round(commands, start + round) : Wait{};
  });
}

void GpuFair::record(VkCommandBuffer commands) const noexcept {
  record_rounds(context_, commands, 1,
                [&](std::size_t, std::uint32_t round) { return record_round(commands, round); });
}

// The cure of what no repair helps, step by step that of fair/fold_cure.cpp.

// All that is looked at in a round.
void GpuFair::plan_looks(Binder& binder, Passes& passes) {
  const FairTables& t = tables_;
  Buffers& b = buffers_;
  const auto add_vertices = [&](Kernel kernel, std::initializer_list<const Buffer*> buffers) {
    binder.add(passes, kernel, t.vertex_count, buffers, t.large_vertex_count).arguments =
        shared::kRoundVertices;
  };
  const bool has_curves = t.state_size > t.corner_count;
  plan_fold_looks(binder, passes, Kernel::FairCureEdges, Kernel::FairCureFaces);
  if (has_curves) {
    binder
        .add(passes, Kernel::FairCureCurves, t.face_count,
             {&t.faces, &t.owners, &t.links, &b.given, &b.face_normals, &b.result, &b.flags},
             t.large_face_count)
        .arguments = shared::kRoundFaces;
  }
  add_vertices(Kernel::FairCureVertices, {&t.vertices, &t.places, &b.face_normals, &b.normals,
                                          &b.result, &t.circle, &b.flags});
  // Once a face, not once a corner of it; given points' offsets are needed no longer.
  Pass& step = binder.add(passes, Kernel::FairOffsets, t.face_count,
                          {&t.faces, &t.owners, &b.given, &b.result, &t.circle, &b.given_offsets},
                          t.large_face_count);
  step.arguments = shared::kRoundFaces;
  step.parameters.of_net = 1;
  add_vertices(Kernel::FairCureAround, {&t.vertices, &t.places, &t.links, &b.given_offsets,
                                        &b.given, &b.face_normals, &b.result, &b.flags});
  if (has_curves) {
    add_vertices(Kernel::FairCureSharp, {&t.vertices, &t.places, &t.links, &b.given,
                                         &b.face_normals, &b.result, &b.flags, &b.decisions});
  }
}

void GpuFair::plan_cure(Binder& binder) {
  const FairTables& t = tables_;
  Buffers& b = buffers_;
  const Buffer& points = t.has_regular_vertices ? b.points : b.given;
  shared::FairParameters& darts = binder
                                      .add(darts_, Kernel::FairCurvePoints, t.curve_point_count,
                                           {&t.curve_points, &b.given, &points, &b.result})
                                      .parameters;
  darts.place = t.corner_count;
  darts.darts_only = 1;
  if (options_.counts_folds) {
    plan_fold_looks(binder, count_, Kernel::FairCureEdges, Kernel::FairCureFaces);
    for (Pass& pass : count_) pass.parameters.only_counts = 1;
    count_[0].parameters.place = shared::kEndCounts;
    count_[1].parameters.place = shared::kEndCounts + 1;
  }
  if (!options_.cures_folds) return;
  if (!t.is_decided) {
    binder.common.start = 1;
    plan_looks(binder, look_[0]);
    binder.common.start = 0;
    plan_looks(binder, look_[1]);
  }
  binder.add(decide_, Kernel::FairCureDecide, t.vertex_count, {&b.flags, &b.decisions, &b.counts})
      .arguments = shared::kRoundVertices;
  const auto add_vertices = [&](Kernel kernel, std::initializer_list<const Buffer*> buffers) {
    binder.add(cure_, kernel, t.vertex_count, buffers, t.large_vertex_count).arguments =
        shared::kRoundVertices;
  };
  binder
      .add(cure_, Kernel::FairFaceHeights, t.face_count,
           {&t.faces, &t.owners, &b.given, &b.heights}, t.large_face_count)
      .arguments = shared::kRoundFaces;
  add_vertices(Kernel::FairCurePlanes, {&t.vertices, &t.places, &b.given, &b.face_normals,
                                        &b.heights, &t.circle, &b.flags, &b.planes});
  add_vertices(Kernel::FairCurePolygons, {&t.vertices, &t.places, &b.given, &b.normals, &b.planes,
                                          &t.circle, &b.flags, &b.result});
  if (t.state_size == t.corner_count) return;
  for (const Kernel kernel : {Kernel::FairCureCreases, Kernel::FairCureCorners}) {
    add_vertices(kernel, {&t.vertices, &t.places, &t.links, &b.given, &b.face_normals, &b.planes,
                          &b.flags, &b.result});
  }
}

void GpuFair::add_cure() {
  add_rounds(curve_points_);
  if (options_.cures_folds && tables_.is_decided) {
    add_rounds(decide_);
    add_rounds(cure_);
  } else if (options_.cures_folds) {
    for (std::uint32_t round = 0; round < shared::kCureRounds; ++round) {
      const std::uint32_t place = shared::kCureCounts + 2 * round;
      const Action action = round == 0 ? Action::Dispatch : Action::DispatchIndirect;
      add_rounds(look_[round > 0], place, action);
      add_rounds(decide_, place, action);
      // What comes of this round is written after the last one's arguments have been read.
      if (round > 0) rounds_.back().wait |= {kIndirectScope, kKernelScope};
      add_rounds(next_round_, place);
      rounds_.back().wait |= {kKernelScope, kIndirectScope};
      add_rounds(cure_, 0, Action::DispatchIndirect);
    }
  }
  add_rounds(darts_);
  add_rounds(count_);
}

}  // namespace planish::vulkan
