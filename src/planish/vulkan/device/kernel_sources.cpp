#include "planish/vulkan/device/kernel_sources.h"

#include <initializer_list>

#include "shaders/apply_limit.spv.h"
#include "shaders/apply_limit_texel.spv.h"
#include "shaders/apply_stencils.spv.h"
#include "shaders/apply_stencils_texel.spv.h"
#include "shaders/bending_directions.spv.h"
#include "shaders/bending_directions_texel.spv.h"
#include "shaders/bending_rows.spv.h"
#include "shaders/bending_rows_texel.spv.h"
#include "shaders/bending_step.spv.h"
#include "shaders/bending_step_texel.spv.h"
#include "shaders/cg_advance.spv.h"
#include "shaders/cg_apply.spv.h"
#include "shaders/cg_apply_texel.spv.h"
#include "shaders/cg_turn.spv.h"
#include "shaders/choose_levels.spv.h"
#include "shaders/choose_levels_texel.spv.h"
#include "shaders/control_points.spv.h"
#include "shaders/corner_patches.spv.h"
#include "shaders/corner_patches_texel.spv.h"
#include "shaders/edit_advance.spv.h"
#include "shaders/edit_advance_texel.spv.h"
#include "shaders/edit_begin.spv.h"
#include "shaders/edit_commit.spv.h"
#include "shaders/edit_jobs.spv.h"
#include "shaders/edit_jobs_texel.spv.h"
#include "shaders/edit_points.spv.h"
#include "shaders/edit_points_texel.spv.h"
#include "shaders/edit_residual.spv.h"
#include "shaders/edit_residual_texel.spv.h"
#include "shaders/edit_stale.spv.h"
#include "shaders/edit_take.spv.h"
#include "shaders/edit_take_texel.spv.h"
#include "shaders/eval_patches.spv.h"
#include "shaders/fair/shared_fair.h"
#include "shaders/fair_apply_heights.spv.h"
#include "shaders/fair_apply_heights_texel.spv.h"
#include "shaders/fair_cure_around.spv.h"
#include "shaders/fair_cure_around_texel.spv.h"
#include "shaders/fair_cure_corners.spv.h"
#include "shaders/fair_cure_corners_texel.spv.h"
#include "shaders/fair_cure_creases.spv.h"
#include "shaders/fair_cure_creases_texel.spv.h"
#include "shaders/fair_cure_curves.spv.h"
#include "shaders/fair_cure_curves_texel.spv.h"
#include "shaders/fair_cure_decide.spv.h"
#include "shaders/fair_cure_edges.spv.h"
#include "shaders/fair_cure_edges_texel.spv.h"
#include "shaders/fair_cure_faces.spv.h"
#include "shaders/fair_cure_faces_texel.spv.h"
#include "shaders/fair_cure_planes.spv.h"
#include "shaders/fair_cure_planes_texel.spv.h"
#include "shaders/fair_cure_polygons.spv.h"
#include "shaders/fair_cure_polygons_texel.spv.h"
#include "shaders/fair_cure_sharp.spv.h"
#include "shaders/fair_cure_sharp_texel.spv.h"
#include "shaders/fair_cure_vertices.spv.h"
#include "shaders/fair_cure_vertices_texel.spv.h"
#include "shaders/fair_curve_points.spv.h"
#include "shaders/fair_curve_points_texel.spv.h"
#include "shaders/fair_descend.spv.h"
#include "shaders/fair_descend_texel.spv.h"
#include "shaders/fair_diagonals.spv.h"
#include "shaders/fair_diagonals_texel.spv.h"
#include "shaders/fair_directions.spv.h"
#include "shaders/fair_directions_texel.spv.h"
#include "shaders/fair_edge_folds.spv.h"
#include "shaders/fair_edge_folds_texel.spv.h"
#include "shaders/fair_face_folds.spv.h"
#include "shaders/fair_face_folds_texel.spv.h"
#include "shaders/fair_face_heights.spv.h"
#include "shaders/fair_face_heights_texel.spv.h"
#include "shaders/fair_face_normals.spv.h"
#include "shaders/fair_face_normals_texel.spv.h"
#include "shaders/fair_gradient.spv.h"
#include "shaders/fair_gradient_texel.spv.h"
#include "shaders/fair_handles.spv.h"
#include "shaders/fair_handles_texel.spv.h"
#include "shaders/fair_lines.spv.h"
#include "shaders/fair_lines_texel.spv.h"
#include "shaders/fair_mask_step.spv.h"
#include "shaders/fair_mask_step_texel.spv.h"
#include "shaders/fair_measure.spv.h"
#include "shaders/fair_measure_texel.spv.h"
#include "shaders/fair_momentum.spv.h"
#include "shaders/fair_momentum_texel.spv.h"
#include "shaders/fair_offsets.spv.h"
#include "shaders/fair_offsets_texel.spv.h"
#include "shaders/fair_place.spv.h"
#include "shaders/fair_place_texel.spv.h"
#include "shaders/fair_polygons.spv.h"
#include "shaders/fair_polygons_texel.spv.h"
#include "shaders/fair_precondition.spv.h"
#include "shaders/fair_reversed.spv.h"
#include "shaders/fair_reversed_texel.spv.h"
#include "shaders/fair_round.spv.h"
#include "shaders/fair_rows.spv.h"
#include "shaders/fair_rows_texel.spv.h"
#include "shaders/fair_sector_normals.spv.h"
#include "shaders/fair_sector_normals_texel.spv.h"
#include "shaders/fair_sectors.spv.h"
#include "shaders/fair_sectors_texel.spv.h"
#include "shaders/fair_shares.spv.h"
#include "shaders/fair_shares_texel.spv.h"
#include "shaders/fair_shrink.spv.h"
#include "shaders/fair_shrink_texel.spv.h"
#include "shaders/fair_state.spv.h"
#include "shaders/fair_state_texel.spv.h"
#include "shaders/fair_step_length.spv.h"
#include "shaders/fair_step_length_texel.spv.h"
#include "shaders/fair_vertex_normals.spv.h"
#include "shaders/fair_vertex_normals_texel.spv.h"
#include "shaders/finish_solve.spv.h"
#include "shaders/first_step.spv.h"
#include "shaders/first_step_texel.spv.h"
#include "shaders/gather_points.spv.h"
#include "shaders/initial_residual.spv.h"
#include "shaders/initial_residual_texel.spv.h"
#include "shaders/instance_patches.spv.h"
#include "shaders/instance_patches_texel.spv.h"
#include "shaders/interpolation_step.spv.h"
#include "shaders/interpolation_step_texel.spv.h"
#include "shaders/listed_patches.spv.h"
#include "shaders/listed_patches_texel.spv.h"
#include "shaders/place_instances.spv.h"
#include "shaders/reduce_rms.spv.h"
#include "shaders/reduce_sums.spv.h"
#include "shaders/ring_sums.spv.h"
#include "shaders/ring_sums_texel.spv.h"
#include "shaders/shared.h"
#include "shaders/stop_test.spv.h"
#include "shaders/surface_places.spv.h"
#include "shaders/surface_places_texel.spv.h"
#include "shaders/take_up.spv.h"

namespace planish::vulkan {

namespace {

using Code = std::span<const std::uint32_t>;

using enum Binding;

KernelSource table_kernel(Code storage, Code texel, std::initializer_list<Binding> others,
                          std::uint32_t parameter_bytes = sizeof(shared::TableParameters)) {
  KernelSource source{storage, texel, parameter_bytes, {Entries, Words}, 2};
  for (const Binding binding : others) source.bindings[source.binding_count++] = binding;
  return source;
}

KernelSource vector_kernel(Code code, std::uint32_t binding_count) {
  // Array elements that are not named are Storage.
  return {code, code, sizeof(shared::VectorParameters), {}, binding_count};
}

KernelSource special_kernel(Code storage, Code texel, std::uint32_t parameter_bytes,
                            std::initializer_list<Binding> bindings) {
  KernelSource source{storage, texel, parameter_bytes, {}, 0, true};
  for (const Binding binding : bindings) source.bindings[source.binding_count++] = binding;
  return source;
}

KernelSource fair_kernel(Code storage, Code texel, std::initializer_list<Binding> bindings) {
  return special_kernel(storage, texel, sizeof(shared::FairParameters), bindings);
}

KernelSource bending_kernel(Code storage, Code texel, std::initializer_list<Binding> bindings) {
  return special_kernel(storage, texel, sizeof(shared::BendingParameters), bindings);
}

KernelSource edit_kernel(Code storage, Code texel, std::initializer_list<Binding> bindings) {
  return special_kernel(storage, texel, sizeof(shared::EditParameters), bindings);
}

#define PLANISH_BOTH(name) spirv::name, spirv::name##_texel

// In the order of enum Kernel.
const KernelSource kSources[kKernelCount] = {
    table_kernel(PLANISH_BOTH(interpolation_step),
                 {Points, Points, Points, Storage, Storage, Storage}),
    vector_kernel(spirv::reduce_rms, 2),
    vector_kernel(spirv::finish_solve, 2),
    table_kernel(PLANISH_BOTH(apply_stencils), {Floats, Storage},
                 sizeof(shared::StencilParameters)),
    table_kernel(PLANISH_BOTH(apply_limit), {Points, Storage, Pairs}),
    special_kernel(PLANISH_BOTH(first_step), sizeof(shared::FirstStepParameters),
                   {Words, Entries, Words, Points, Points, Storage, Storage}),
    special_kernel(PLANISH_BOTH(corner_patches), sizeof(shared::CornerPatchParameters),
                   {Records, Words, Entries, Points, Points, Points, Storage, Storage}),
    special_kernel(PLANISH_BOTH(surface_places), sizeof(shared::PlaceParameters),
                   {Storage, Words, Entries, Points, Points, Points, Storage}),
    special_kernel(PLANISH_BOTH(ring_sums), sizeof(shared::RingSumParameters),
                   {Words, Points, Points, Storage, Storage}),
    table_kernel(PLANISH_BOTH(cg_apply), {Points, Storage, Storage, Storage}),
    vector_kernel(spirv::cg_advance, 6),
    vector_kernel(spirv::cg_turn, 2),
    vector_kernel(spirv::reduce_sums, 2),
    vector_kernel(spirv::stop_test, 2),
    vector_kernel(spirv::gather_points, 3),
    table_kernel(PLANISH_BOTH(initial_residual), {Points, Storage}),
    vector_kernel(spirv::take_up, 4),
    vector_kernel(spirv::control_points, 7),
    {spirv::eval_patches, spirv::eval_patches, sizeof(shared::PatchParameters), {}, 6, true},
    edit_kernel(spirv::edit_begin, spirv::edit_begin, {Storage, Storage}),
    edit_kernel(PLANISH_BOTH(edit_take),
                {Storage, Words, Storage, Storage, Storage, Storage, Storage}),
    edit_kernel(PLANISH_BOTH(edit_residual),
                {Entries, Words, Words, Points, Points, Storage, Storage, Storage}),
    edit_kernel(PLANISH_BOTH(edit_advance),
                {Words, Entries, Words, Storage, Storage, Storage, Storage, Storage}),
    edit_kernel(spirv::edit_commit, spirv::edit_commit,
                {Storage, Storage, Storage, Storage, Storage, Storage, Storage, Storage}),
    edit_kernel(PLANISH_BOTH(edit_jobs), {Words, Storage, Storage, Storage}),
    edit_kernel(PLANISH_BOTH(edit_points),
                {Words, Words, Entries, Words, Points, Points, Storage, Storage}),
    edit_kernel(spirv::edit_stale, spirv::edit_stale, {Storage, Storage, Storage}),
    special_kernel(PLANISH_BOTH(listed_patches), sizeof(shared::CornerPatchParameters),
                   {Records, Words, Entries, Points, Points, Points, Storage, Storage}),
    special_kernel(PLANISH_BOTH(choose_levels), sizeof(shared::ChooseParameters),
                   {Points, Storage}),
    special_kernel(spirv::place_instances, spirv::place_instances,
                   sizeof(shared::PlaceInstancesParameters), {Storage, Storage, Storage}),
    special_kernel(PLANISH_BOTH(instance_patches), sizeof(shared::CornerPatchParameters),
                   {Records, Words, Entries, Points, Points, Points, Storage, Storage}),
    bending_kernel(PLANISH_BOTH(bending_directions),
                   {Records, Entries, Points, Storage, Storage, Storage, Storage}),
    bending_kernel(PLANISH_BOTH(bending_rows), {Records, Entries, Points, Points, Points, Storage}),
    bending_kernel(PLANISH_BOTH(bending_step),
                   {Records, Entries, Floats, Points, Points, Storage, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_place), {Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_face_normals), {Records, Words, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_vertex_normals), {Records, Records, Points, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_sector_normals), {Storage, Records, Points, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_offsets), {Records, Words, Points, Points, Pairs, Storage}),
    fair_kernel(PLANISH_BOTH(fair_shares), {Records, Records, Points, Points, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_mask_step),
                {Records, Records, Points, Floats, Points, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_polygons),
                {Records, Records, Points, Points, Floats, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_reversed),
                {Records, Records, Points, Points, Pairs, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_handles),
                {Storage, Points, Floats, Points, Records, Points, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_sectors),
                {Storage, Records, Points, Points, Points, Points, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_curve_points), {Storage, Points, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_edge_folds),
                {Records, Words, Points, Points, Points, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_face_folds),
                {Records, Words, Points, Points, Points, Pairs, Storage, Storage}),
    fair_kernel(spirv::fair_round, spirv::fair_round, {Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_shrink), {Records, Records, Storage, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_directions), {Records, Points, Floats, Storage}),
    fair_kernel(PLANISH_BOTH(fair_rows),
                {Records, Words, Points, Points, Points, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_diagonals),
                {Records, Records, Records, Points, Points, Storage, Storage}),
    fair_kernel(spirv::fair_precondition, spirv::fair_precondition, {Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_lines),
                {Records, Points, Points, Points, Storage, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_gradient), {Records, Points, Points, Pairs, Storage}),
    fair_kernel(PLANISH_BOTH(fair_step_length), {Floats, Storage}),
    fair_kernel(PLANISH_BOTH(fair_descend),
                {Records, Records, Floats, Floats, Points, Storage, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_momentum), {Floats, Storage}),
    fair_kernel(PLANISH_BOTH(fair_apply_heights), {Records, Records, Points, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_measure), {Records, Records, Points, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_state), {Words, Points, Points, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_cure_edges),
                {Records, Words, Points, Points, Points, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_cure_faces),
                {Records, Words, Points, Points, Points, Pairs, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_cure_curves),
                {Records, Words, Records, Points, Points, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_cure_vertices),
                {Records, Records, Points, Points, Points, Pairs, Storage}),
    fair_kernel(PLANISH_BOTH(fair_cure_around),
                {Records, Records, Records, Points, Points, Points, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_cure_sharp),
                {Records, Records, Records, Points, Points, Points, Storage, Storage}),
    fair_kernel(spirv::fair_cure_decide, spirv::fair_cure_decide, {Storage, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_face_heights), {Records, Words, Points, Storage}),
    fair_kernel(PLANISH_BOTH(fair_cure_planes),
                {Records, Records, Points, Points, Floats, Pairs, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_cure_polygons),
                {Records, Records, Points, Points, Points, Pairs, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_cure_creases),
                {Records, Records, Records, Points, Points, Storage, Storage, Storage}),
    fair_kernel(PLANISH_BOTH(fair_cure_corners),
                {Records, Records, Records, Points, Points, Storage, Storage, Storage}),
};

#undef PLANISH_BOTH

// In the order of enum Kernel.
constexpr const char* kKernelNames[kKernelCount] = {"planish interpolation_step",
                                                    "planish reduce_rms",
                                                    "planish finish_solve",
                                                    "planish apply_stencils",
                                                    "planish apply_limit",
                                                    "planish first_step",
                                                    "planish corner_patches",
                                                    "planish surface_places",
                                                    "planish ring_sums",
                                                    "planish cg_apply",
                                                    "planish cg_advance",
                                                    "planish cg_turn",
                                                    "planish reduce_sums",
                                                    "planish stop_test",
                                                    "planish gather_points",
                                                    "planish initial_residual",
                                                    "planish take_up",
                                                    "planish control_points",
                                                    "planish eval_patches",
                                                    "planish edit_begin",
                                                    "planish edit_take",
                                                    "planish edit_residual",
                                                    "planish edit_advance",
                                                    "planish edit_commit",
                                                    "planish edit_jobs",
                                                    "planish edit_points",
                                                    "planish edit_stale",
                                                    "planish listed_patches",
                                                    "planish choose_levels",
                                                    "planish place_instances",
                                                    "planish instance_patches",
                                                    "planish bending_directions",
                                                    "planish bending_rows",
                                                    "planish bending_step",
                                                    "planish fair_place",
                                                    "planish fair_face_normals",
                                                    "planish fair_vertex_normals",
                                                    "planish fair_sector_normals",
                                                    "planish fair_offsets",
                                                    "planish fair_shares",
                                                    "planish fair_mask_step",
                                                    "planish fair_polygons",
                                                    "planish fair_reversed",
                                                    "planish fair_handles",
                                                    "planish fair_sectors",
                                                    "planish fair_curve_points",
                                                    "planish fair_edge_folds",
                                                    "planish fair_face_folds",
                                                    "planish fair_round",
                                                    "planish fair_shrink",
                                                    "planish fair_directions",
                                                    "planish fair_rows",
                                                    "planish fair_diagonals",
                                                    "planish fair_precondition",
                                                    "planish fair_lines",
                                                    "planish fair_gradient",
                                                    "planish fair_step_length",
                                                    "planish fair_descend",
                                                    "planish fair_momentum",
                                                    "planish fair_apply_heights",
                                                    "planish fair_measure",
                                                    "planish fair_state",
                                                    "planish fair_cure_edges",
                                                    "planish fair_cure_faces",
                                                    "planish fair_cure_curves",
                                                    "planish fair_cure_vertices",
                                                    "planish fair_cure_around",
                                                    "planish fair_cure_sharp",
                                                    "planish fair_cure_decide",
                                                    "planish fair_face_heights",
                                                    "planish fair_cure_planes",
                                                    "planish fair_cure_polygons",
                                                    "planish fair_cure_creases",
                                                    "planish fair_cure_corners"};

}  // namespace

const KernelSource& source_of(Kernel kernel) { return kSources[static_cast<std::size_t>(kernel)]; }

const char* name_of(Kernel kernel) { return kKernelNames[static_cast<std::size_t>(kernel)]; }

}  // namespace planish::vulkan
