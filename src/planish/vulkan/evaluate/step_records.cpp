#include "planish/vulkan/evaluate/step_records.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>

#include "planish/core/error.h"
#include "planish/patches/ring_sums.h"
#include "planish/vulkan/evaluate/state_owners.h"

namespace planish::vulkan {

namespace {

constexpr std::int64_t kSliceLanes = 64;
constexpr std::uint64_t kStepPointBytes = shared::kPointFloats * sizeof(float);

std::uint32_t float_bits(double weight) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(weight));
}

IndexWindow from_a_multiple(const IndexWindow& window) {
  const std::int64_t shift = window.first % kSliceLanes;
  return {window.first - shift, window.count + shift};
}

static_assert(shared::kStepLargeFace == kSummedRing);

bool is_large(const MeshTopology& topology, std::int32_t face) {
  return topology.face_size(face) >= kSummedRing;
}

void add_weights(const MeshTopology& topology, Weights weights, std::vector<std::uint32_t>& words) {
  std::set<std::int32_t> sizes;
  for (std::int32_t f = 0; f < topology.face_count(); ++f)
    if (!is_large(topology, f)) sizes.insert(topology.face_size(f));
  if (sizes.empty()) return;
  const FaceWeights rule(weights);
  std::vector<double> scratch;
  words.resize(static_cast<std::size_t>(*sizes.rbegin()) + 1);
  for (const std::int32_t size : sizes) {
    words[size] = static_cast<std::uint32_t>(words.size());
    for (const double weight : rule.of(size, scratch)) words.push_back(float_bits(weight));
  }
}

// Returns where the faces' words begin.
std::uint32_t add_large_faces(const MeshTopology& topology, std::vector<std::uint32_t>& words) {
  std::map<std::int32_t, std::uint32_t> turns;  // by size
  std::vector<std::int32_t> faces;
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    if (!is_large(topology, f)) continue;
    faces.push_back(f);
    const std::int32_t size = topology.face_size(f);
    if (!turns.try_emplace(size, static_cast<std::uint32_t>(words.size())).second) continue;
    const double step = 2 * std::numbers::pi / size;
    for (std::int32_t i = 0; i < size; ++i)
      for (const double part : {std::cos(step * i), std::sin(step * i)})
        words.push_back(float_bits(part));
  }
  const auto first = static_cast<std::uint32_t>(words.size());
  for (const std::int32_t f : faces) {
    const std::int32_t size = topology.face_size(f);
    words.insert(words.end(), {static_cast<std::uint32_t>(topology.first_corner(f)),
                               static_cast<std::uint32_t>(size), turns.at(size)});
  }
  return first;
}

void add_sharp(const StencilView<double>& rows, std::span<const std::int32_t> owners,
               std::vector<std::uint32_t>& words) {
  auto pair = static_cast<std::uint32_t>(words.size() + 2 * rows.row_count() + 2);
  for (std::int32_t row = 0; row < rows.row_count(); ++row) {
    words.push_back(static_cast<std::uint32_t>(owners[row]));
    words.push_back(pair);
    pair += 2 * static_cast<std::uint32_t>(rows.sizes[row]);
  }
  words.insert(words.end(), {0, pair});
  for (std::int32_t row = 0; row < rows.row_count(); ++row)
    for (std::int32_t k = rows.offsets[row]; k < rows.offsets[row] + rows.sizes[row]; ++k) {
      words.push_back(static_cast<std::uint32_t>(rows.indices[k]));
      words.push_back(float_bits(rows.weights[k]));
    }
}

bool slice_fits(const StepSlice& slice, const PatchLimits& limits) {
  for (const IndexWindow& window : {slice.points, slice.corners, slice.vertices}) {
    const auto count = static_cast<std::uint64_t>(from_a_multiple(window).count);
    if (!limits.range.allows(count * kStepPointBytes)) return false;
  }
  // Of large faces a group does one after the other, of all else it does its lanes' points only.
  return slice.kind == shared::kStepLargeFaces ||
         static_cast<std::uint64_t>((slice.points.count + kSliceLanes - 1) / kSliceLanes) <=
             limits.max_groups;
}

void require_fit(const StepSlice& slice, const PatchLimits& limits) {
  if (slice_fits(slice, limits)) return;
  const std::int64_t most =
      std::max({slice.points.count, slice.corners.count, slice.vertices.count}) + kSliceLanes;
  const std::string what =
      slice.kind == shared::kStepSharp ? "the points beside sharp edges" : "a face's points";
  limits.range.require(static_cast<std::uint64_t>(most) * kStepPointBytes, what);
  throw Error(ErrorCode::OutOfMemory,
              what + " take more than the " + std::to_string(limits.max_groups) +
                  " work groups of one dispatch that maxComputeWorkGroupCount allows; " +
                  kSmallerMesh);
}

// Of the small faces, or of the large ones, whose words begin at `word`.
void cut_faces(const MeshTopology& topology, const PatchLimits& limits, std::uint32_t kind,
               std::uint32_t word, std::vector<StepSlice>& slices) {
  const bool of_large = kind == shared::kStepLargeFaces;
  StepSlice slice;
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    if (is_large(topology, f) != of_large) continue;
    StepSlice face;
    face.kind = kind;
    face.first_word = word;
    face.count = 1;
    if (of_large) word += shared::kLargeFaceWords;
    face.points = {topology.first_corner(f), topology.face_size(f)};
    for (const std::int32_t vertex : topology.face(f)) face.vertices.take(vertex);
    StepSlice longer = slice.count > 0 ? slice : face;
    longer.count = slice.count + 1;
    longer.points = longer.corners = slice.points.joined(face.points);
    longer.vertices = slice.vertices.joined(face.vertices);
    if (slice.points.count > 0 && !slice_fits(longer, limits)) {
      slices.push_back(slice);
      longer = face;
      longer.corners = face.points;
    }
    slice = longer;
    if (slice.points.count == face.points.count) require_fit(slice, limits);
  }
  if (slice.points.count > 0) slices.push_back(slice);
  if (of_large) return;
  for (StepSlice& of_points : slices)
    of_points.count = static_cast<std::uint32_t>(of_points.points.count);
}

}  // namespace

StepRecords step_records(const PatchMesh& mesh, Weights weights,
                         const StencilView<double>& sharp_rows, const PatchLimits& limits) {
  const MeshTopology& topology = mesh.topology();
  StepRecords records;
  records.vertices.reserve(static_cast<std::size_t>(topology.corner_count()));
  for (std::int32_t c = 0; c < topology.corner_count(); ++c)
    records.vertices.push_back(static_cast<std::uint32_t>(topology.vertex_of(c)));
  add_weights(topology, weights, records.words);
  cut_faces(topology, limits, shared::kStepFaces, 0, records.slices);
  const std::uint32_t large = add_large_faces(topology, records.words);
  cut_faces(topology, limits, shared::kStepLargeFaces, large, records.slices);
  records.rule = face_sum_rule(weights);
  if (sharp_rows.row_count() > 0) {
    const std::vector<std::int32_t> owners = state_owners(mesh);
    StepSlice slice;
    slice.kind = shared::kStepSharp;
    slice.count = static_cast<std::uint32_t>(sharp_rows.row_count());
    slice.first_word = static_cast<std::uint32_t>(records.words.size());
    slice.points = {mesh.first_sharp(), sharp_rows.row_count()};
    add_sharp(sharp_rows, std::span(owners).subspan(mesh.first_sharp()), records.words);
    for (const std::int32_t vertex : sharp_rows.indices) slice.vertices.take(vertex);
    require_fit(slice, limits);
    records.slices.push_back(slice);
  }
  for (StepSlice& slice : records.slices) {
    slice.corners = from_a_multiple(slice.corners);
    slice.vertices = from_a_multiple(slice.vertices);
  }
  return records;
}

}  // namespace planish::vulkan
