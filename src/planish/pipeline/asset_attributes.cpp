#include "planish/pipeline/asset_attributes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <mutex>
#include <ranges>
#include <string>
#include <utility>

#include "planish/adaptive/adaptive_blocks.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/core/words.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

bool is_same_name(const std::string& a, const std::string& b) {
  return lower_case(a) == lower_case(b);
}

void require_memory_of(std::uint64_t count, std::int64_t rows) {
  const std::uint64_t needed = sizeof(float) * count * static_cast<std::uint64_t>(rows),
                      free = available_memory_bytes();
  if (needed > free)
    throw Error(ErrorCode::OutOfMemory, formatted("{} numbers of vertices at {} rows need {} MiB "
                                                  "of memory where {} are free; take a lower level",
                                                  count, rows, needed >> 20, free >> 20));
}

constexpr int kWidestField = 4;  // glTF's VEC4

VertexAttribute column_of(const VertexAttribute& of, int column) {
  VertexAttribute made = attribute_of_size(formatted("{}_{}", of.name, column), 1, of.count());
  for (std::size_t i = 0; i < made.values.size(); ++i)
    made.values[i] =
        of.values[static_cast<std::size_t>(of.width) * i + static_cast<std::size_t>(column)];
  return made;
}

}  // namespace

std::vector<float> rows_of_vertices(std::span<const float> given, int width,
                                    const FittedMesh& fitted, const SurfaceBlocks& surface) {
  const auto numbers = static_cast<std::size_t>(width);
  std::vector<glm::vec4> vertices(fitted.mesh.positions.size(), glm::vec4(0.0f));
  const std::size_t own = vertices.size() - fitted.added_vertices.size();
  for (std::size_t v = 0; v < own; ++v) {
    const std::size_t source =
        fitted.source_vertices.empty() ? v : static_cast<std::size_t>(fitted.source_vertices[v]);
    for (std::size_t k = 0; k < numbers; ++k)
      vertices[v][static_cast<int>(k)] = given[numbers * source + k];
  }
  for (std::size_t v = own; v < vertices.size(); ++v) {
    const AddedVertex& added = fitted.added_vertices[v - own];
    for (int k = 0; k < 3; ++k)
      vertices[v] += static_cast<float>(added.weights[k]) * vertices[added.vertices[k]];
  }
  std::vector<glm::vec4> made(static_cast<std::size_t>(surface.info().row_count));
  (void)surface.rows_of(vertices, made);
  std::vector<float> values(numbers * made.size());
  for (std::size_t i = 0; i < made.size(); ++i)
    for (std::size_t k = 0; k < numbers; ++k)
      values[numbers * i + k] = made[i][static_cast<int>(k)];
  return values;
}

std::vector<VertexAttribute> add_attributes(const SurfaceBlocks& surface,
                                            std::vector<NamedField>& fields,
                                            const Callbacks& callbacks) {
  const std::vector<AttributeName>& given = surface.info().attributes;
  std::vector<std::size_t> wanted;
  std::uint64_t numbers = 0;
  std::string left_out;
  for (std::size_t k = 0; k < given.size(); ++k) {
    const bool is_taken = std::ranges::any_of(
        fields, [&](const NamedField& field) { return is_same_name(field.name, given[k].name); });
    if (is_taken) {
      left_out += (left_out.empty() ? "" : ", ") + given[k].name;
    } else {
      wanted.push_back(k);
      numbers += static_cast<std::uint64_t>(given[k].width);
    }
  }
  if (!left_out.empty())
    callbacks.warn({"left-out-properties",
                    "properties of the vertices are left out: " + left_out +
                        "; fields of the surface have these names",
                    static_cast<std::int64_t>(given.size() - wanted.size())});
  require_memory_of(numbers, surface.info().row_count);
  std::vector<VertexAttribute> made;
  for (const std::size_t k : wanted) {
    VertexAttribute all = all_rows(surface, k);
    if (all.width <= kWidestField) {
      made.push_back(std::move(all));
    } else {
      for (int column = 0; column < all.width; ++column) made.push_back(column_of(all, column));
    }
  }
  for (const VertexAttribute& attribute : made)
    fields.push_back({attribute.name, attribute.values, attribute.width});
  return made;
}

namespace {

constexpr std::size_t kVertexGrain = 4096;

// Finer than float32 holds, whatever the tolerance of positions is.
constexpr double kTolerance = 1e-8;

// The most that a surface may miss what it is to go through, of the numbers' extent.
constexpr double kLargestMiss = 1e-5;

// `surface`: of Doo-Sabin.
LimitSystem system_of(const FittedMesh& fitted, const DooSabinSurface* surface) {
  const UsedPart used = used_part(fitted.mesh, fitted.fit.prepared);
  const MeshTopology& topology = *used.prepared->topology;
  FitOptions options = fitted.options;
  options.callbacks = {};
  options.solver = Solver::Chebyshev;
  if (surface != nullptr) {
    const SharpFeatures& features = surface->patches().features();
    return doo_sabin_system(used.mesh, Subdivision(topology, features, options.weights), options);
  }
  PrimalSplit split(used.mesh, {*primal_scheme(options.scheme), options.sharp, &topology});
  split.refine(1);
  return primal_system(split, options);
}

}  // namespace

LinearSurface::LinearSurface(const FittedMesh& fitted, const SurfaceBlocks& rows, Backend& backend)
    : fitted_(fitted),
      rows_(rows),
      backend_(backend),
      fitted_surface_(is_doo_sabin()
                          ? fitted_surface(fitted.mesh, fitted.fit, fitted.evaluate_options())
                          : nullptr),
      system_(system_of(fitted, fitted_surface_.get())) {}

EvaluateOptions LinearSurface::options() const {
  return fitted_.evaluate_options(rows_.info().level);
}

std::unique_ptr<PolygonMesh> LinearSurface::cage_through(std::span<const glm::dvec3> given,
                                                         const Callbacks& callbacks) const {
  const UsedPart used = used_part(fitted_.mesh, fitted_.fit.prepared);
  RawVector<glm::dvec3> values(used.vertices.size());
  parallel_each(values.size(), kVertexGrain,
                [&](std::size_t v) { values[v] = given[used.vertices[v]]; });
  InterpolationOptions interpolation;
  interpolation.tolerance = kTolerance;
  interpolation.spectral_bound = system_.spectral_bound;
  interpolation.callbacks.progress = callbacks.progress;
  interpolation.callbacks.cancelled = callbacks.cancelled;
  const Interpolation solved = interpolate(backend_, system_.masks.view(), values, interpolation);
  if (!(solved.error.max <= kLargestMiss))
    throw Error(ErrorCode::InvalidArgument,
                "this scheme has no surface through what the vertices have, joints or morph "
                "targets; take --scheme doo-sabin, which always has one, or merge the scene "
                "(--asset merge)");
  auto cage = std::make_unique<PolygonMesh>(fitted_.mesh);
  parallel_each(values.size(), kVertexGrain, [&](std::size_t v) {
    cage->positions[used.vertices[v]] = values[v] + solved.displacement[v];
  });
  return cage;
}

LinearSurface::Rows LinearSurface::at_rows(Rows made) const {
  if (!is_doo_sabin()) {
    made.whole_ = std::make_unique<const SurfaceMesh>(evaluate(*made.cage_, backend_, options()));
    made.blocks_ = blocks_of(*made.whole_, fitted_.mesh);
  } else if (const auto* const adaptive = dynamic_cast<const AdaptiveBlocks*>(&rows_)) {
    made.whole_ =
        std::make_unique<const SurfaceMesh>(adaptive->rows_on(LimitSurface(made.surface_)));
    made.blocks_ = blocks_of(*made.whole_, PolygonMesh{});
  } else {
    made.blocks_ = made.surface_->level(rows_.info().level);
  }
  return made;
}

LinearSurface::Rows LinearSurface::through(std::span<const glm::dvec3> given,
                                           const Callbacks& callbacks) const {
  Rows made;
  made.cage_ = cage_through(given, callbacks);
  if (is_doo_sabin())
    made.surface_ = std::make_shared<const DooSabinSurface>(*made.cage_, Placement{}, options());
  return at_rows(std::move(made));
}

LinearSurface::Rows LinearSurface::moved(std::span<const glm::dvec3> moves,
                                         const Callbacks& callbacks) const {
  Rows made;
  std::unique_ptr<PolygonMesh> by = cage_through(moves, callbacks);
  if (!is_doo_sabin()) {
    parallel_each(by->positions.size(), kVertexGrain,
                  [&](std::size_t v) { by->positions[v] += fitted_.fit.cage.positions[v]; });
    made.cage_ = std::move(by);
    return at_rows(std::move(made));
  }
  const DooSabinSurface& base = *fitted_surface_;
  const DooSabinSurface mover(*by, Placement{}, options());
  const auto size = static_cast<std::size_t>(base.patches().state_size());
  auto sum = std::make_unique<LevelOne>();
  sum->placement = base.placement();
  sum->state.resize(size);
  parallel_each(size, kVertexGrain, [&](std::size_t i) {
    sum->state[i] = base.state()[i] + mover.state()[i] / base.placement().diagonal;
  });
  made.level_one_ = std::move(sum);
  made.surface_ =
      std::make_shared<const DooSabinSurface>(fitted_.mesh, *made.level_one_, options());
  return at_rows(std::move(made));
}

namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.7.2.2 (morph targets) and 3.7.3.3
// (skinned meshes: weights sum to 1).

constexpr int kJointsOfSet = 4;

// of(range) on all threads, for all rows.
template <class Of>
void for_rows(const SurfaceBlocks& surface, const Of& of) {
  const std::vector<RowRange> ranges = surface.row_blocks(kAttributeRows);
  parallel_each(ranges.size(), 1, [&](std::size_t i) { of(ranges[i]); });
}

}  // namespace

class AssetAttributes::Maker {
 public:
  Maker(AssetAttributes& made, const AssetMesh& mesh, const FittedMesh& fitted,
        const SurfaceBlocks& surface, Backend& backend, const Callbacks& callbacks)
      : made_(made),
        given_(mesh.vertices),
        fitted_(fitted),
        surface_(surface),
        backend_(backend),
        callbacks_(callbacks) {
    for (const JointWeight& influence : given_.influences) channel_of_.try_emplace(influence.joint);
    std::size_t channel = 0;
    for (auto& [joint, number] : channel_of_) number = channel++;
    solve_count_ = (has_fields() ? 0 : (channel_of_.size() + 2) / 3) + given_.targets.size();
  }

  void add_uvs() {
    for (const std::vector<glm::dvec2>& set : given_.further_uvs) made_.uvs_.push_back(uvs_of(set));
  }

  // Of texture coordinates by morph targets.
  void add_uv_moves() {
    for (const AssetUvMoves& moves : given_.uv_moves) {
      std::vector<float>& values = made_.values_.emplace_back();
      for (const glm::dvec2& move : uvs_of(moves.values))
        for (int k = 0; k < 2; ++k) values.push_back(static_cast<float>(move[k]));
      GltfAttribute& made =
          made_.attributes_.emplace_back(GltfAttribute{.name = layer_name(moves.layer, moves.name),
                                                       .width = 2,
                                                       .values = values,
                                                       .of_uvs = true});
      for (const AssetGroup& group : given_.groups)
        made.in_groups.push_back(group.uv_sets_at(moves.layer) > moves.set ? 1 : 0);
    }
  }

  void add_arrays() {
    std::vector<const AssetArray*> blended;
    for (const AssetArray& array : given_.arrays) {
      if (array.is_of_things) {
        add_array(array, nearest_rows(array));
      } else if (array.of_corners) {
        add_array(array, uv_rows(array));
      } else if (is_doo_sabin()) {
        add_array(array, rows_of_vertices(array.values, array.width, fitted_, surface_));
      } else {
        blended.push_back(&array);
      }
    }
    if (blended.empty()) return;
    PolygonMesh cage = fitted_.fit.cage;
    cage.attributes.clear();
    for (const AssetArray* array : blended) {
      VertexAttribute& attribute = cage.attributes.emplace_back(
          attribute_of_size(array->name, array->width, cage.positions.size()));
      for (std::size_t v = 0; v < cage.positions.size(); ++v)
        std::copy_n(array->values.begin() + array->width * static_cast<std::int64_t>(source(v)),
                    array->width,
                    attribute.values.begin() + array->width * static_cast<std::int64_t>(v));
    }
    const SurfaceMesh made = evaluated(cage);
    for (std::size_t i = 0; i < blended.size(); ++i)
      add_array(*blended[i], {made.attributes[i].values.begin(), made.attributes[i].values.end()});
  }

  // Any surface has them: they come of its triangles.
  void add_tangents() {
    RawVector<glm::dvec2> first(static_cast<std::size_t>(surface_.info().uv_count));
    parallel_for(first.size(), kAttributeRows, [&](std::size_t begin, std::size_t end) {
      surface_.uvs({static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end - begin)},
                   std::span(first).subspan(begin, end - begin));
    });
    TangentSource source{.sets = {first}, .set_of_group = {}};
    for (const std::vector<glm::dvec2>& set : made_.uvs_) source.sets.emplace_back(set);
    for (int depth = 0; depth <= given_.layer_depth(); ++depth) {
      GltfAttribute tangents{.name = layer_name(depth, "TANGENT"), .width = 4, .of_uvs = true};
      source.set_of_group.clear();
      for (const AssetGroup& group : given_.groups) {
        const int set = group.tangent_set_at(depth);
        source.set_of_group.push_back(set < static_cast<int>(source.sets.size()) ? set : -1);
        tangents.in_groups.push_back(source.set_of_group.back() >= 0 ? 1 : 0);
      }
      if (!given_.has_tangents(depth)) continue;
      SurfaceTangents& made = depth == 0 ? made_.tangents_.front() : made_.tangents_.emplace_back();
      made = surface_tangents(surface_, source);
      tangents.values = made.values;
      tangents.further = made.further;
      tangents.further_values = made.further_values;
      made_.attributes_.push_back(std::move(tangents));
    }
  }

  void add_joints() {
    std::vector<std::int32_t> joints;
    for (const auto& [joint, channel] : channel_of_) joints.push_back(joint);
    if (has_fields()) {
      add_joints_by_fields(joints);
      return;
    }
    // Three on a surface.
    std::vector<LinearSurface::Rows> surfaces;
    for (std::size_t first = 0; first < joints.size(); first += 3) {
      std::vector<glm::dvec3> given(fitted_.mesh.positions.size(), glm::dvec3(0.0));
      for (std::size_t v = 0; v < given.size(); ++v)
        for_weights(source(v), first, 3,
                    [&](std::size_t k, float weight) { given[v][static_cast<int>(k)] += weight; });
      surfaces.push_back(linear().through(given, next_solve()));
    }
    write_joints(joints, [&](RowRange rows, std::vector<std::vector<double>>& weights) {
      std::vector<glm::dvec3> three(static_cast<std::size_t>(rows.count));
      for (std::size_t k = 0; k < surfaces.size(); ++k) {
        RowTarget target;
        target.positions = three;
        (void)surfaces[k].blocks().rows(rows, target);
        for (std::size_t j = 3 * k; j < std::min(joints.size(), 3 * k + 3); ++j)
          for (std::size_t i = 0; i < three.size(); ++i)
            weights[j][i] = three[i][static_cast<int>(j - 3 * k)];
      }
    });
  }

  void add_targets() {
    for (std::size_t k = 0; k < given_.targets.size(); ++k) {
      std::vector<glm::dvec3> moves(fitted_.mesh.positions.size());
      for (std::size_t v = 0; v < moves.size(); ++v) moves[v] = given_.targets[k][source(v)];
      const LinearSurface::Rows moved = linear().moved(moves, next_solve());
      const std::string target = formatted("target/{}/", k);
      std::vector<float>& positions = new_attribute(target + "POSITION", 3);
      std::vector<float>& normals = new_attribute(target + "NORMAL", 3);
      for_rows(surface_, [&](RowRange rows) {
        const auto count = static_cast<std::size_t>(rows.count);
        std::vector<glm::dvec3> from(count), to(count);
        std::vector<glm::vec3> from_normals(count), to_normals(count);
        const auto make = [&](const SurfaceBlocks& of, std::vector<glm::dvec3>& made,
                              std::vector<glm::vec3>& made_normals) {
          RowTarget rest;
          rest.positions = made;
          rest.normals = made_normals;
          (void)of.rows(rows, rest);
        };
        make(surface_, from, from_normals);
        make(moved.blocks(), to, to_normals);
        for (std::size_t i = 0; i < count; ++i) {
          const std::size_t at = 3 * (static_cast<std::size_t>(rows.first) + i);
          for (int axis = 0; axis < 3; ++axis) {
            positions[at + static_cast<std::size_t>(axis)] =
                static_cast<float>(to[i][axis] - from[i][axis]);
            normals[at + static_cast<std::size_t>(axis)] =
                to_normals[i][axis] - from_normals[i][axis];
          }
        }
      });
    }
  }

 private:
  [[nodiscard]] std::size_t source(std::size_t vertex) const {
    return fitted_.source_vertices.empty()
               ? vertex
               : static_cast<std::size_t>(fitted_.source_vertices[vertex]);
  }
  void add_array(const AssetArray& array, std::vector<float> rows) {
    const std::vector<float>& values = made_.values_.emplace_back(std::move(rows));
    GltfAttribute& made =
        made_.attributes_.emplace_back(GltfAttribute{.name = layer_name(array.layer, array.name),
                                                     .width = array.width,
                                                     .is_integer = array.is_integer,
                                                     .values = values,
                                                     .of_uvs = array.of_corners});
    for (const AssetGroup& group : given_.groups)
      if (array.layer > 0) made.in_groups.push_back(group.layer(array.layer) != nullptr ? 1 : 0);
  }
  [[nodiscard]] std::vector<float> nearest_rows(const AssetArray& array) const;
  [[nodiscard]] std::vector<float> uv_rows(const AssetArray& array) const;
  // Other values in the place of texture coordinates.
  [[nodiscard]] std::vector<glm::dvec2> uvs_of(const std::vector<glm::dvec2>& given) const {
    std::vector<glm::dvec2> values;
    if (is_doo_sabin()) {
      values.resize(static_cast<std::size_t>(surface_.info().uv_count));
      (void)surface_.uvs_of(given, values);
      return values;
    }
    PolygonMesh cage = fitted_.fit.cage;
    cage.uvs = given;
    const SurfaceMesh made = evaluated(cage);
    values.assign(made.uvs.begin(), made.uvs.end());
    return values;
  }
  // The linear map of the progressive method is that of its own surfaces: on others an affine
  // function of the place would not stay one.
  [[nodiscard]] bool has_fields() const {
    return is_doo_sabin() && fitted_.options.method == InterpolationMethod::Fair;
  }
  // use(k, weight) for the influences of a given vertex by channel first + k of so many.
  template <class Use>
  void for_weights(std::size_t vertex, std::size_t first, std::size_t count, const Use& use) const {
    for (const JointWeight& influence : given_.influences_of(static_cast<std::int64_t>(vertex))) {
      const std::size_t channel = channel_of_.at(influence.joint);
      if (channel >= first && channel < first + count) use(channel - first, influence.weight);
    }
  }
  void add_joints_by_fields(const std::vector<std::int32_t>& joints) {
    constexpr std::size_t kAtOnce = 4;
    std::vector<std::vector<float>> fields;
    for (std::size_t first = 0; first < joints.size(); first += kAtOnce) {
      std::vector<float> given(kAtOnce * (given_.first_influence.size() - 1), 0.0f);
      for (std::size_t v = 0; v + 1 < given_.first_influence.size(); ++v)
        for_weights(v, first, kAtOnce,
                    [&](std::size_t k, float weight) { given[kAtOnce * v + k] += weight; });
      fields.push_back(rows_of_vertices(given, static_cast<int>(kAtOnce), fitted_, surface_));
    }
    write_joints(joints, [&](RowRange rows, std::vector<std::vector<double>>& weights) {
      const auto begin = static_cast<std::size_t>(rows.first);
      for (std::size_t j = 0; j < joints.size(); ++j)
        for (std::size_t i = 0; i < weights[j].size(); ++i)
          weights[j][i] = fields[j / kAtOnce][kAtOnce * (begin + i) + j % kAtOnce];
    });
  }
  [[nodiscard]] bool is_doo_sabin() const { return fitted_.options.scheme == Scheme::DooSabin; }
  // Other schemes have their attributes from OpenSubdiv, along with all of a surface.
  [[nodiscard]] SurfaceMesh evaluated(const PolygonMesh& cage) const {
    return evaluate(cage, backend_, fitted_.evaluate_options(surface_.info().level));
  }
  [[nodiscard]] const LinearSurface& linear() {
    if (!linear_) linear_ = std::make_unique<const LinearSurface>(fitted_, surface_, backend_);
    return *linear_;
  }
  // Callbacks of the next of all solves.
  [[nodiscard]] Callbacks next_solve() {
    const double from = static_cast<double>(solved_) / static_cast<double>(solve_count_);
    const double to = static_cast<double>(++solved_) / static_cast<double>(solve_count_);
    return share_of(callbacks_, from, to);
  }
  std::vector<float>& new_attribute(std::string name, int width, bool is_integer = false) {
    std::vector<float>& values = made_.values_.emplace_back();
    values.resize(static_cast<std::size_t>(width * surface_.info().row_count), 0.0f);
    made_.attributes_.push_back(
        {.name = std::move(name), .width = width, .is_integer = is_integer, .values = values});
    return values;
  }
  // weights_of(rows, weights): of each joint at each row.
  template <class WeightsOf>
  void write_joints(const std::vector<std::int32_t>& joints, const WeightsOf& weights_of);

  AssetAttributes& made_;
  const AssetVertices& given_;
  const FittedMesh& fitted_;
  const SurfaceBlocks& surface_;
  Backend& backend_;
  const Callbacks& callbacks_;
  std::map<std::int32_t, std::size_t> channel_of_;  // of joints that move anything
  std::size_t solve_count_ = 0, solved_ = 0;
  std::unique_ptr<const LinearSurface> linear_;
};

// Of what corners have, where texture coordinates stand.
std::vector<float> AssetAttributes::Maker::uv_rows(const AssetArray& array) const {
  const auto width = static_cast<std::size_t>(array.width);
  std::vector<glm::vec4> given(array.values.size() / width, glm::vec4(0.0f));
  for (std::size_t i = 0; i < given.size(); ++i)
    for (std::size_t k = 0; k < width; ++k)
      given[i][static_cast<int>(k)] = array.values[width * i + k];
  std::vector<glm::vec4> made(static_cast<std::size_t>(surface_.info().uv_count));
  if (is_doo_sabin()) {
    (void)surface_.corners_of(given, made);
  } else {
    // Other schemes know texture coordinates alone.
    std::vector<glm::dvec2> two(given.size());
    for (int first = 0; first < array.width; first += 2) {
      for (std::size_t i = 0; i < given.size(); ++i)
        two[i] = {given[i][first], given[i][first + 1]};
      const std::vector<glm::dvec2> rows = uvs_of(two);
      for (std::size_t row = 0; row < made.size(); ++row)
        for (int k = 0; k < 2; ++k) made[row][first + k] = static_cast<float>(rows[row][k]);
    }
  }
  std::vector<float> rows(width * made.size());
  for (std::size_t row = 0; row < made.size(); ++row)
    for (std::size_t k = 0; k < width; ++k) rows[width * row + k] = made[row][static_cast<int>(k)];
  return rows;
}

// Each row has the numbers of a corner of a face that it lies on, the nearest one: the surface
// passes through them.
std::vector<float> AssetAttributes::Maker::nearest_rows(const AssetArray& array) const {
  const PolygonMesh& mesh = fitted_.mesh;
  const auto width = static_cast<std::size_t>(array.width);
  const SurfaceInfo& info = surface_.info();
  const std::int64_t row_count = array.of_corners ? info.uv_count : info.row_count;
  std::vector<float> values(width * static_cast<std::size_t>(row_count), 0.0f);
  struct Piece {
    RawVector<std::int32_t> rows, faces;
    RawVector<glm::dvec3> positions;
    RawVector<glm::vec3> normals;
    std::vector<std::int32_t> nearest;  // corners of the mesh, by corner
  };
  const auto corner_count = [&](RowRange faces) {
    return static_cast<std::size_t>(info.first_corner(faces.first + faces.count) -
                                    info.first_corner(faces.first));
  };
  in_order<Piece>(
      ranges_of(info.face_count, kAttributeRows),
      [&](RowRange faces, Piece& piece) {
        piece.rows.resize(corner_count(faces));
        piece.positions.resize(piece.rows.size());
        piece.normals.resize(piece.rows.size());
        piece.nearest.resize(piece.rows.size());
        piece.faces.resize(static_cast<std::size_t>(faces.count));
        if (array.of_corners) {
          surface_.face_uvs(faces, piece.rows);
        } else {
          surface_.face_vertices(faces, piece.rows);
        }
        surface_.corners(faces, piece.positions, piece.normals);
        surface_.ancestors(faces, piece.faces);
        for (std::int64_t f = 0; f < faces.count; ++f) {
          const auto begin = static_cast<std::size_t>(mesh.face_offsets[piece.faces[f]]);
          const auto end = static_cast<std::size_t>(mesh.face_offsets[piece.faces[f] + 1]);
          const auto of = std::views::iota(begin, end);
          const std::int64_t first = info.first_corner(faces.first);
          for (std::int64_t c = info.first_corner(faces.first + f) - first;
               c < info.first_corner(faces.first + f + 1) - first; ++c)
            piece.nearest[c] = static_cast<std::int32_t>(
                *std::ranges::min_element(of, {}, [&](std::size_t corner) {
                  const glm::dvec3 apart =
                      mesh.positions[mesh.face_vertices[corner]] - piece.positions[c];
                  return glm::dot(apart, apart);
                }));
        }
      },
      [&](RowRange, const Piece& piece) {
        for (std::size_t c = 0; c < piece.rows.size(); ++c) {
          const std::int32_t corner = piece.nearest[c];
          const auto from = array.of_corners
                                ? static_cast<std::size_t>(mesh.face_uvs[corner])
                                : source(static_cast<std::size_t>(mesh.face_vertices[corner]));
          std::copy_n(array.values.begin() + static_cast<std::int64_t>(width * from), width,
                      values.begin() + static_cast<std::int64_t>(width) * piece.rows[c]);
        }
      });
  return values;
}

template <class WeightsOf>
void AssetAttributes::Maker::write_joints(const std::vector<std::int32_t>& joints,
                                          const WeightsOf& weights_of) {
  const auto places = static_cast<std::size_t>(kJointsOfSet * given_.joint_sets);
  std::vector<std::vector<float>*> numbers, weights;
  for (int set = 0; set < given_.joint_sets; ++set) {
    numbers.push_back(&new_attribute(formatted("JOINTS_{}", set), kJointsOfSet, true));
    weights.push_back(&new_attribute(formatted("WEIGHTS_{}", set), kJointsOfSet));
  }
  std::mutex mutex;
  for_rows(surface_, [&](RowRange rows) {
    const auto count = static_cast<std::size_t>(rows.count);
    std::vector<std::vector<double>> weights_of_joint(joints.size(), std::vector<double>(count));
    weights_of(rows, weights_of_joint);
    double lost = 0;
    std::vector<JointWeight> of_row;
    for (std::size_t i = 0; i < count; ++i) {
      of_row.clear();
      double sum = 0, kept = 0, below = 0;
      for (std::size_t j = 0; j < joints.size(); ++j) {
        const auto weight = static_cast<float>(weights_of_joint[j][i]);
        if (weight > 0) of_row.push_back({joints[j], weight}), sum += weight;
        if (weight < 0) below -= weight;
      }
      std::ranges::stable_sort(of_row, std::greater<>(), &JointWeight::weight);
      of_row.resize(std::min(of_row.size(), places));
      for (const JointWeight& one : of_row) kept += one.weight;
      if (sum > 0) lost = std::max(lost, (sum - kept + below) / sum);
      for (std::size_t k = 0; k < of_row.size(); ++k) {
        const std::size_t at = kJointsOfSet * (static_cast<std::size_t>(rows.first) + i) + k % 4;
        (*numbers[k / 4])[at] = static_cast<float>(of_row[k].joint);
        (*weights[k / 4])[at] = static_cast<float>(of_row[k].weight / kept);
      }
      // A vertex that nothing moves has the first joint, as the format wants.
      if (of_row.empty())
        (*weights[0])[kJointsOfSet * (static_cast<std::size_t>(rows.first) + i)] = 1.0f;
    }
    const std::lock_guard lock(mutex);
    made_.lost_weight_ = std::max(made_.lost_weight_, lost);
  });
}

AssetAttributes::AssetAttributes(const AssetMesh& mesh, const FittedMesh& fitted,
                                 const SurfaceBlocks& surface, Backend& backend,
                                 const Callbacks& callbacks)
    : name_(mesh.name) {
  const AssetVertices& given = mesh.vertices;
  Maker maker(*this, mesh, fitted, surface, backend, callbacks);
  maker.add_arrays();
  maker.add_uvs();
  maker.add_uv_moves();
  try {
    if (!given.first_influence.empty()) maker.add_joints();
    if (!given.targets.empty()) maker.add_targets();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InvalidArgument) throw;
    throw Error(error.code(), mesh.name + ": " + error.what());
  }
  if (given.has_tangents()) maker.add_tangents();
  for (const AssetGroup& group : given.groups) uv_sets_.push_back(group.mesh_uv_sets());
}

void AssetAttributes::add_to(GltfOptions& options) const {
  options.name = name_;
  options.origin = glm::dvec3(0.0);
  options.attributes = attributes_;
  options.uv_sets = uv_sets_;
  for (const std::vector<glm::dvec2>& set : uvs_) options.further_uvs.push_back(set);
}

}  // namespace planish
