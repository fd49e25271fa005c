#include "planish/vulkan/evaluate/gpu_places.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/patches/patch_form.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {
namespace {

// Based on: corner patches, a derivation of our own; see patches/patch_form.cpp, whose quarters
// within quarters these records flatten: every polynomial that a place can lie in is a row of
// weights of the corner's own control points.

// Coefficients of s^i t^j in the kernel's order: i + 3 j.
constexpr std::array<std::size_t, 9> kCoefficientOrder{0, 1, 3, 2, 4, 6, 5, 7, 8};
constexpr std::size_t kCoefficientCount = kCoefficientOrder.size();
constexpr std::size_t kFurtherQuarters = 3;

// Rows over a patch's points, the coefficients of one cell.
using CellRows = std::vector<double>;

std::size_t columns_of(const PatchForm& form) {
  return static_cast<std::size_t>(form.column_count);
}

// The coefficients of a form that is one polynomial: the uniform quadratic B-splines' powers.
CellRows polynomial_cell(const PatchForm& form) {
  constexpr double kPowers[3][3] = {{0.5, 0.5, 0}, {-1, 1, 0}, {0.5, -1, 0.5}};
  CellRows rows;
  for (const std::size_t place : kCoefficientOrder)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t i = 0; i < 3; ++i)
        rows.push_back(kPowers[place % 3][i] * kPowers[place / 3][j]);
  return pulled_back(rows, form.net, columns_of(form));
}

// V itself: rows of which the kernel knows the meaning by the cell's number.
CellRows vertex_cell(const PatchForm& form) {
  CellRows rows(kCoefficientCount * columns_of(form), 0.0);
  std::copy(form.corner.begin(), form.corner.end(), rows.begin());
  return rows;
}

bool is_singular_at_face(const PatchForm& form) {
  return !form.is_polynomial() && !form.quarters[2]->is_polynomial();
}

class PlacePacker {
 public:
  PlacePacker(const PatchMesh& mesh, Weights weights, const PatchLimits& limits)
      : mesh_(mesh), limits_(limits), forms_(weights) {}

  PlaceRecords pack() {
    const MeshTopology& topology = mesh_.topology();
    records_.face_count = static_cast<std::uint32_t>(topology.face_count());
    records_.corner_count = static_cast<std::uint32_t>(topology.corner_count());
    list_classes();
    require_fit();
    for (std::int32_t f = 0; f < topology.face_count(); ++f) add_word(topology.first_corner(f));
    add_word(topology.corner_count());
    add_corners();
    for (const auto& [patch, entry] : classes_) add_class(*entry.form);
    add_lists();
    PLANISH_ASSERT(records_.words.size() == word_count_);
    PLANISH_ASSERT(records_.weights.size() == texel_count_);
    return std::move(records_);
  }

 private:
  struct Entry {
    const PatchForm* form;
    std::uint64_t word;  // where its words stand
  };

  static std::uint64_t cell_count(const PatchForm& form) {
    if (form.is_polynomial()) return 1;
    return shared::kQuarterCells + (form.is_singular_at_vertex() ? shared::kChainCells : 0) +
           (is_singular_at_face(form) ? shared::kChainCells : 0);
  }
  static bool has_list(const PatchClass& patch) {
    return patch.kind != PatchKind::Smooth || patch.has_ring_sums || patch.has_face_sums;
  }

  void add_word(std::int64_t value) { records_.words.push_back(static_cast<std::uint32_t>(value)); }
  void list_classes();
  void require_fit() const;
  void add_corners();
  void add_class(const PatchForm& form);
  void add_lists();
  void add_cell(const CellRows& rows, std::size_t columns);
  void add_chain(const PatchForm& form, int quarter);
  const std::vector<CellRows>& chain_of(const PatchForm& form);

  const PatchMesh& mesh_;
  const PatchLimits& limits_;
  PatchForms forms_;
  PlaceRecords records_;
  std::map<PatchClass, Entry> classes_;
  std::map<PatchClass, std::vector<CellRows>> chains_;
  std::uint64_t word_count_ = 0, first_list_ = 0, texel_count_ = 0;
};

void PlacePacker::list_classes() {
  const std::int32_t corner_count = mesh_.topology().corner_count();
  std::uint64_t list_words = 0;
  for (std::int32_t c = 0; c < corner_count; ++c) {
    const PatchClass patch = mesh_.corner_patch(c).patch;
    if (has_list(patch)) list_words += static_cast<std::uint64_t>(patch.column_count());
    classes_.try_emplace(patch, Entry{nullptr, 0});
  }
  word_count_ = records_.face_count + 1 + 2 * static_cast<std::uint64_t>(corner_count);
  for (auto& [patch, entry] : classes_) {
    entry = {&forms_.of(patch), word_count_};
    word_count_ += shared::kPlaceClassWords;
    texel_count_ += cell_count(*entry.form) * shared::kCellVectors *
                    static_cast<std::uint64_t>(patch.column_count() - 1);
  }
  first_list_ = word_count_;
  word_count_ += list_words;
}

void PlacePacker::require_fit() const {
  const auto check = [&](const std::string& what, std::uint64_t count, std::uint64_t item_bytes) {
    limits_.range.require(count * item_bytes, "places of the surface: " + what,
                          "ask a LimitSurface on the CPU, or take a smaller mesh");
  };
  check(formatted("the weights of {} kinds of corners", classes_.size()), texel_count_,
        sizeof records_.weights[0]);
  check("what is known of corners", word_count_, sizeof(std::uint32_t));
  check("control points", static_cast<std::uint64_t>(mesh_.point_count()),
        shared::kPointFloats * sizeof(float));
}

void PlacePacker::add_corners() {
  std::uint64_t list = first_list_;
  for (std::int32_t c = 0; c < mesh_.topology().corner_count(); ++c) {
    const PatchClass patch = mesh_.corner_patch(c).patch;
    add_word(static_cast<std::int64_t>(classes_.at(patch).word));
    if (!has_list(patch)) {
      add_word(shared::kNone);
      continue;
    }
    add_word(static_cast<std::int64_t>(list));
    list += static_cast<std::uint64_t>(patch.column_count());
  }
}

void PlacePacker::add_lists() {
  std::vector<std::int32_t> gathered;
  for (std::int32_t c = 0; c < mesh_.topology().corner_count(); ++c) {
    const PatchPlace place = mesh_.corner_patch(c);
    if (!has_list(place.patch)) continue;
    gathered.resize(static_cast<std::size_t>(place.patch.column_count()));
    mesh_.gather(place, gathered.data(), 1);
    for (const std::int32_t point : gathered) add_word(point);
  }
}

// Column by column, without the own point, which the others are relative to.
void PlacePacker::add_cell(const CellRows& rows, std::size_t columns) {
  for (std::size_t k = 1; k < columns; ++k) {
    std::array<float, shared::kCellVectors * 4> values{};
    for (std::size_t r = 0; r < kCoefficientCount; ++r)
      values[r] = static_cast<float>(rows[r * columns + k]);
    for (std::size_t i = 0; i < values.size(); i += 4)
      records_.weights.push_back({values[i], values[i + 1], values[i + 2], values[i + 3]});
  }
}

// The cells of ever further halvings towards V, of a form whose own quarter at V is of its class:
// quarters 1 to 3 of the first, of the second and so on, over the form's own points.
const std::vector<CellRows>& PlacePacker::chain_of(const PatchForm& form) {
  const auto [at, is_new] = chains_.try_emplace(form.patch);
  std::vector<CellRows>& cells = at->second;
  if (!is_new) return cells;
  PLANISH_ASSERT(form.quarters[0] == &form);
  const std::size_t columns = columns_of(form);
  for (std::size_t q = 1; q <= kFurtherQuarters; ++q)
    cells.push_back(pulled_back(polynomial_cell(*form.quarters[q]), form.steps[q], columns));
  while (cells.size() + 1 < shared::kChainCells)
    cells.push_back(pulled_back(cells[cells.size() - kFurtherQuarters], form.steps[0], columns));
  return cells;
}

void PlacePacker::add_chain(const PatchForm& form, int quarter) {
  const std::size_t columns = columns_of(form);
  for (const CellRows& rows : chain_of(*form.quarters[quarter]))
    add_cell(pulled_back(rows, form.steps[quarter], columns), columns);
  add_cell(quarter == 0
               ? vertex_cell(form)
               : pulled_back(vertex_cell(*form.quarters[quarter]), form.steps[quarter], columns),
           columns);
}

void PlacePacker::add_class(const PatchForm& form) {
  const PatchClass& patch = form.patch;
  const bool at_vertex = form.is_singular_at_vertex(), at_face = is_singular_at_face(form);
  add_word(patch.column_count() - 1);
  add_word(patch.ring_size);
  add_word(patch.face_size);
  add_word(std::ssize(records_.weights));
  add_word((form.is_polynomial() ? shared::kOnePolynomial : 0) |
           (at_vertex ? shared::kSingularAtVertex : 0) | (at_face ? shared::kSingularAtFace : 0));
  const std::size_t columns = columns_of(form);
  if (form.is_polynomial()) {
    add_cell(polynomial_cell(form), columns);
    return;
  }
  for (int q = 0; q < 4; ++q) {
    const PatchForm& quarter = *form.quarters[q];
    const CellRows none(kCoefficientCount * columns, 0.0);
    add_cell(quarter.is_polynomial() ? pulled_back(polynomial_cell(quarter), form.steps[q], columns)
                                     : none,
             columns);
  }
  if (at_vertex) add_chain(form, 0);
  if (at_face) add_chain(form, 2);
}

}  // namespace

PlaceRecords place_records(const PatchMesh& mesh, Weights weights, const PatchLimits& limits) {
  return PlacePacker(mesh, weights, limits).pack();
}

namespace {

// Based on: corner patches, a derivation of our own; its twin is limit/limit_surface.cpp.

constexpr std::uint32_t kPlaceLanes = 64;
constexpr std::uint32_t kWord = sizeof(float);

std::uint32_t words_of(std::uint32_t bytes) {
  return bytes == kNotWritten ? shared::kNone : bytes / kWord;
}

// Places as far as they are read, and results as far as they are written.
FloatElements list_elements(const PlaceList& list) {
  return {list.buffer, list.offset / kWord, shared::kPlaceWords, list.stride / kWord};
}
FloatElements result_elements(const PlaceLayout& layout) {
  return {layout.buffer, layout.offset / kWord,
          static_cast<std::uint32_t>(result_bytes(layout) / kWord), layout.stride / kWord};
}

}  // namespace

std::uint64_t result_bytes(const PlaceLayout& layout) {
  std::uint64_t end =
      layout.state_offset == kNotWritten ? 0 : std::uint64_t(layout.state_offset) + kWord;
  for (const std::uint32_t offset :
       {layout.position_offset, layout.normal_offset, layout.du_offset, layout.dv_offset,
        layout.duu_offset, layout.duv_offset, layout.dvv_offset})
    if (offset != kNotWritten) end = std::max(end, std::uint64_t(offset) + 3 * kWord);
  return end;
}

PlaceTables::PlaceTables(const Maker& on, const PlaceRecords& records)
    : face_count(records.face_count),
      corner_count(records.corner_count),
      words(make_bindable(on, records.words.size() * kWord, "planish words of places")),
      weights(make_bindable(on, std::as_bytes(std::span(records.weights)).size(),
                            "planish weights of places")) {}

GpuPlaces::GpuPlaces(Context& context, const PatchTables& patches, const PlaceTables& tables,
                     const BufferRange& given, const BufferRange& state, const PlaceList& list,
                     const PlaceLayout& layout)
    : context_(context), pipeline_(context.pipelines().specialised(Kernel::SurfacePlaces, {})) {
  // The kernel reads any point.
  require_binding(context, state.size, "control points", "take a smaller mesh");
  require_binding(context, given.size, "given points", "take a smaller mesh");
  const std::uint64_t step =
      elements_at_once(context, std::max(list.stride, layout.stride) / kWord, 1);
  std::vector<BoundKernel> bound;
  for (std::uint64_t first = 0; first < list.count; first += step) {
    const std::uint64_t count = std::min(step, list.count - first);
    const ElementWindow from = element_window(list_elements(list), first, count);
    const ElementWindow to = element_window(result_elements(layout), first, count);
    require_window(context, from, "places of a list");
    require_window(context, to, "results of places");
    Dispatch& dispatch = dispatches_.emplace_back();
    dispatch.first = static_cast<std::uint32_t>(first);
    shared::PlaceParameters& parameters = dispatch.parameters;
    parameters.count = static_cast<std::uint32_t>(count);
    parameters.first_place = from.shift;
    parameters.place_stride = list.stride / kWord;
    parameters.face_count = tables.face_count;
    parameters.first_target = to.shift;
    parameters.target_stride = layout.stride / kWord;
    parameters.position = words_of(layout.position_offset);
    parameters.normal = words_of(layout.normal_offset);
    parameters.du = words_of(layout.du_offset);
    parameters.dv = words_of(layout.dv_offset);
    parameters.duu = words_of(layout.duu_offset);
    parameters.duv = words_of(layout.duv_offset);
    parameters.dvv = words_of(layout.dvv_offset);
    parameters.state = words_of(layout.state_offset);
    bound.push_back({Kernel::SurfacePlaces,
                     {from.range, whole(tables.words), whole(patches.links), state, given,
                      whole(tables.weights), to.range}});
  }
  sets_ = DescriptorSets(context, bound);
}

void GpuPlaces::record(VkCommandBuffer commands, std::uint32_t count) const noexcept {
  for (std::size_t i = 0; i < dispatches_.size() && dispatches_[i].first < count; ++i) {
    // Windows of neighbouring dispatches may share their edge.
    if (i > 0) record_barrier(context_, commands, kKernelScope, kKernelScope);
    shared::PlaceParameters parameters = dispatches_[i].parameters;
    parameters.count = std::min(parameters.count, count - dispatches_[i].first);
    record_dispatch(context_, commands, pipeline_, sets_[i], &parameters,
                    (parameters.count + kPlaceLanes - 1) / kPlaceLanes);
  }
}

}  // namespace planish::vulkan
