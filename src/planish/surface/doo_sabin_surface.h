#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/chart_field.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_surface.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/memory_need.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// A Doo-Sabin surface without its tessellation: topology, sharp features and the control points of
/// level 1, for all levels. The mesh must outlive it.
class DooSabinSurface {
 public:
  /// That of a control cage; takes what was prepared, weights, what is sharp and the rest pose of
  /// the options. Throws Error{UnusableMesh}.
  DooSabinSurface(const PolygonMesh& cage, const EvaluateOptions& options);
  /// The same of a part of a larger cage, in whose coordinates it is evaluated: where the part has
  /// all faces around a face's vertices, that face has the bits that it has on the whole.
  DooSabinSurface(const PolygonMesh& cage, const Placement& placement,
                  const EvaluateOptions& options);
  /// That of control points of level 1 on a mesh. Throws as above, Error{InvalidArgument} for a
  /// state of another size. The state must outlive the surface.
  DooSabinSurface(const PolygonMesh& mesh, const LevelOne& level_one,
                  const EvaluateOptions& options);
  /// That of a cage's points, or of a state of level 1, in unit coordinates; it keeps its own
  /// points of level 1, which may be changed (own_state()). Throws Error{UnusableMesh}.
  DooSabinSurface(const PolygonMesh& mesh, const Placement& placement,
                  std::span<const glm::dvec3> unit_cage, std::span<const glm::dvec3> state,
                  const EvaluateOptions& options);
  DooSabinSurface(PolygonMesh&& cage, const EvaluateOptions& options) = delete;
  DooSabinSurface(const DooSabinSurface&) = delete;
  DooSabinSurface& operator=(const DooSabinSurface&) = delete;

  /// One level of it, 0 to kMaxLevel, which this must outlive. `memory_limit_bytes` is for who
  /// takes it by blocks (0: what the machine has free). With an evaluator all rows are made on its
  /// device at once, in its precision, and kept. Throws Error{InvalidArgument},
  /// Error{OutOfMemory}, Error{DeviceLost}.
  [[nodiscard]] std::unique_ptr<SurfaceBlocks> level(int level,
                                                     std::uint64_t memory_limit_bytes = 0,
                                                     PatchEvaluator* evaluator = nullptr) const;

  /// Throws Error{OutOfMemory} where a SurfaceMesh of that level does not fit as well.
  void require_whole(int level, std::uint64_t memory_limit_bytes,
                     const PatchEvaluator* evaluator) const;

  [[nodiscard]] const PolygonMesh& mesh() const { return used_.mesh; }
  [[nodiscard]] const UsedPart& used() const { return used_; }
  [[nodiscard]] const MeshTopology& topology() const { return *used_.prepared->topology; }
  [[nodiscard]] const PatchMesh& patches() const { return patches_; }
  /// The control points of level 1, and behind them the sums of large rings.
  [[nodiscard]] std::span<const glm::dvec3> state() const { return state_; }
  /// The same where the surface keeps them itself, to be changed while nobody reads.
  [[nodiscard]] std::span<glm::dvec3> own_state() {
    uv_field_.reset();
    color_field_.reset();
    number_fields_.clear();
    return own_state_;
  }
  /// The mesh's texture coordinates on the surface, made when first asked for, from any thread,
  /// also after own_state() was. The mesh must have them.
  [[nodiscard]] const ChartField<glm::dvec2>& uv_field() const;
  /// The same of other values, by the indices that the mesh has.
  [[nodiscard]] ChartField<glm::dvec2> uv_field_of(std::span<const glm::dvec2> values) const;
  /// The colours of the mesh on the surface, or four numbers of its attributes (four_of()); made
  /// and kept as texture coordinates are.
  [[nodiscard]] const ChartField<glm::dvec4>& color_field() const;
  [[nodiscard]] const ChartField<glm::dvec4>& number_field(std::size_t four) const;
  /// The same of other values of vertices, or of what corner_uvs() names; both must outlive it.
  [[nodiscard]] ChartField<glm::dvec4> vertex_field_of(std::span<const glm::vec4> values) const {
    return {patches_, state_, used_.mesh.face_vertices, values, vertex_limits_};
  }
  [[nodiscard]] ChartField<glm::dvec4> corner_field_of(std::span<const glm::vec4> values) const {
    return {patches_, state_, corner_uvs().indices, values, vertex_limits_};
  }
  /// Of a part of a larger surface: where that has the vertices (vertex_limits()), as the part does
  /// not have all faces around its rim's; and two colours with the least and the largest numbers of
  /// all that it has, or none. Before a field is asked for.
  void take_whole(RawVector<glm::dvec3> limits, std::vector<glm::vec4> colors) {
    vertex_limits_ = std::move(limits);
    colors_of_whole_ = std::move(colors);
  }
  /// What each corner has of them.
  [[nodiscard]] const CornerUvs& corner_uvs() const;
  [[nodiscard]] const Placement& placement() const { return placement_; }
  [[nodiscard]] Weights weights() const { return weights_; }
  /// One flag a face where the mesh has holes, else nothing.
  [[nodiscard]] std::span<const std::uint8_t> hidden() const { return hidden_; }

 private:
  struct Begin {};
  DooSabinSurface(const PolygonMesh& mesh, const EvaluateOptions& options, Begin);
  void take_cage(const Placement& placement);
  void require(LastLevel what, int level, std::uint64_t limit_bytes, bool has_evaluator) const;
  // Makes what is not there yet, one at a time.
  template <class Field, class Make>
  const Field& made_once(std::unique_ptr<const Field>& field, const Make& make) const;

  UsedPart used_;
  std::shared_ptr<const SharpFeatures> features_;
  PatchMesh patches_;
  Weights weights_;
  std::vector<std::uint8_t> hidden_;
  Placement placement_;
  RawVector<glm::dvec3> own_state_;
  std::span<const glm::dvec3> state_;
  RawVector<glm::dvec3> vertex_limits_;     // of a part
  std::vector<glm::vec4> colors_of_whole_;  // likewise
  mutable std::once_flag has_corner_uvs_;
  mutable std::unique_ptr<const CornerUvs> corner_uvs_;
  mutable std::mutex field_mutex_;
  mutable std::unique_ptr<const ChartField<glm::dvec2>> uv_field_;
  mutable std::unique_ptr<const ChartField<glm::dvec4>> color_field_;
  struct NumberField {
    std::vector<glm::vec4> values;
    std::unique_ptr<const ChartField<glm::dvec4>> field;
  };
  mutable std::map<std::size_t, NumberField> number_fields_;
};

}  // namespace planish
