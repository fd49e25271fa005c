// The cure of what no repair helps, step by step that of fair/fold_cure.cpp.
#include "planish/vulkan/fair/fair_binder.h"
#include "planish/vulkan/fair/gpu_fair.h"

namespace planish::vulkan {

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
