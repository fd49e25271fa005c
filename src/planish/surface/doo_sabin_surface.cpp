#include "planish/surface/doo_sabin_surface.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/hole_flags.h"
#include "planish/patches/first_step.h"
#include "planish/surface/doo_sabin_blocks.h"
#include "planish/surface/subdivided_mesh.h"

namespace planish {

namespace {

std::shared_ptr<const SharpFeatures> sharp_features(const UsedPart& used,
                                                    const EvaluateOptions& options) {
  if (options.features) return options.features;
  const auto of_pose = [&](std::span<const glm::dvec3> pose) {
    return std::make_shared<const SharpFeatures>(
        find_sharp_features(used.mesh, *used.prepared->topology, pose, options.sharp));
  };
  if (options.rest_positions.empty()) return of_pose(used.mesh.positions);
  if (used.prepared->uses_all()) return of_pose(options.rest_positions);
  std::vector<glm::dvec3> rest(used.vertices.size());
  for (std::size_t v = 0; v < rest.size(); ++v) rest[v] = options.rest_positions[used.vertices[v]];
  return of_pose(rest);
}

}  // namespace

DooSabinSurface::DooSabinSurface(const PolygonMesh& mesh, const EvaluateOptions& options, Begin)
    : used_(usable_part(mesh, options.prepared)),
      features_(sharp_features(used_, options)),
      patches_(topology(), *features_, ring_columns(topology(), options.weights, used_.vertices)),
      weights_(options.weights) {
  if (used_.mesh.hole_faces.empty()) return;
  hidden_ = hole_flags(used_.mesh);
}

DooSabinSurface::DooSabinSurface(const PolygonMesh& cage, const EvaluateOptions& options)
    : DooSabinSurface(cage, options, Begin{}) {
  take_cage(placement_of(used_.mesh));
}

DooSabinSurface::DooSabinSurface(const PolygonMesh& cage, const Placement& placement,
                                 const EvaluateOptions& options)
    : DooSabinSurface(cage, options, Begin{}) {
  take_cage(placement);
}

void DooSabinSurface::take_cage(const Placement& placement) {
  placement_ = placement;
  RawVector<glm::dvec3> unit(used_.mesh.positions.size());
  parallel_each(unit.size(), 1 << 14,
                [&](std::size_t v) { unit[v] = placement_.to_unit(used_.mesh.positions[v]); });
  own_state_ = first_step(patches_, weights_, unit);
  state_ = own_state_;
}

DooSabinSurface::DooSabinSurface(const PolygonMesh& mesh, const LevelOne& level_one,
                                 const EvaluateOptions& options)
    : DooSabinSurface(mesh, options, Begin{}) {
  require_state_size(patches_.state_size(), level_one);
  placement_ = level_one.placement;
  if (patches_.has_sums()) own_state_ = patches_.with_sums(level_one.state);
  state_ = patches_.has_sums() ? std::span<const glm::dvec3>(own_state_) : level_one.state;
}

DooSabinSurface::DooSabinSurface(const PolygonMesh& mesh, const Placement& placement,
                                 std::span<const glm::dvec3> unit_cage,
                                 std::span<const glm::dvec3> state, const EvaluateOptions& options)
    : DooSabinSurface(mesh, options, Begin{}) {
  placement_ = placement;
  own_state_ =
      state.empty() ? first_step(patches_, weights_, unit_cage) : patches_.with_sums(state);
  state_ = own_state_;
}

const CornerUvs& DooSabinSurface::corner_uvs() const {
  std::call_once(has_corner_uvs_,
                 [&] { corner_uvs_ = std::make_unique<const CornerUvs>(used_.mesh); });
  return *corner_uvs_;
}

ChartField<glm::dvec2> DooSabinSurface::uv_field_of(std::span<const glm::dvec2> values) const {
  return {patches_, state_, corner_uvs().indices, values, vertex_limits_};
}

template <class Field, class Make>
const Field& DooSabinSurface::made_once(std::unique_ptr<const Field>& field,
                                        const Make& make) const {
  // A thread that waits in here must not begin other work, which may ask for the field.
  if (!field) {
    oneapi::tbb::this_task_arena::isolate([&] { field = std::make_unique<const Field>(make()); });
  }
  return *field;
}

const ChartField<glm::dvec2>& DooSabinSurface::uv_field() const {
  const std::lock_guard lock(field_mutex_);
  return made_once(uv_field_, [&] { return uv_field_of(used_.mesh.uvs); });
}

const ChartField<glm::dvec4>& DooSabinSurface::color_field() const {
  const std::lock_guard lock(field_mutex_);
  return made_once(color_field_, [&] {
    return ChartField<glm::dvec4>(patches_, state_, used_.mesh.face_vertices, used_.mesh.colors,
                                  vertex_limits_, {}, colors_of_whole_);
  });
}

const ChartField<glm::dvec4>& DooSabinSurface::number_field(std::size_t four) const {
  const std::lock_guard lock(field_mutex_);
  NumberField& made = number_fields_[four];
  return made_once(made.field, [&] {
    const std::span<const VertexAttribute> all = used_.mesh.attributes;
    made.values = four_of(all, four);
    std::array<int, 4> attributes{};
    for (std::size_t index = 0; index < all.size(); ++index)
      for (const NumberRun& run : runs_of(all, index))
        if (run.four == four)
          std::fill_n(attributes.begin() + run.lane, run.count, static_cast<int>(index));
    return ChartField<glm::dvec4>(patches_, state_, used_.mesh.face_vertices, made.values,
                                  vertex_limits_, attributes);
  });
}

void DooSabinSurface::require(LastLevel what, int level, std::uint64_t limit_bytes,
                              bool has_evaluator) const {
  require_level(level);
  const std::vector<LevelCounts> counts =
      split_counts({topology().vertex_count(), topology().edge_count(), topology().face_count()},
                   topology().corner_count(), level);
  RefinedAttributes attributes = RefinedAttributes::of(used_.mesh);
  attributes.device_rows = has_evaluator;
  require_memory(counts, what, attributes, limit_bytes);
}

void DooSabinSurface::require_whole(int level, std::uint64_t memory_limit_bytes,
                                    const PatchEvaluator* evaluator) const {
  require(LastLevel::None, level, memory_limit_bytes, evaluator != nullptr);
}

std::unique_ptr<SurfaceBlocks> DooSabinSurface::level(int level, std::uint64_t memory_limit_bytes,
                                                      PatchEvaluator* evaluator) const {
  require(LastLevel::Blocks, level, memory_limit_bytes, evaluator != nullptr);
  return std::make_unique<DooSabinBlocks>(*this, level, evaluator);
}

}  // namespace planish
