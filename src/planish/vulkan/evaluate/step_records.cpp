#include "planish/vulkan/evaluate/step_records.h"

#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>

#include "planish/patches/ring_sums.h"
#include "planish/vulkan/evaluate/state_owners.h"

namespace planish::vulkan {

namespace {

std::uint32_t float_bits(double weight) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(weight));
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

}  // namespace

StepRecords step_records(const PatchMesh& mesh, Weights weights,
                         const StencilView<double>& sharp_rows) {
  const MeshTopology& topology = mesh.topology();
  StepRecords records;
  records.vertices.reserve(static_cast<std::size_t>(topology.corner_count()));
  for (std::int32_t c = 0; c < topology.corner_count(); ++c)
    records.vertices.push_back(static_cast<std::uint32_t>(topology.vertex_of(c)));
  const auto word = [&] { return static_cast<std::uint32_t>(records.words.size()); };
  const auto add_part = [&](std::uint32_t kind, std::int32_t count, std::int32_t first,
                            std::uint32_t first_word) {
    if (count > 0)
      records.parts.push_back(
          {kind, static_cast<std::uint32_t>(count), static_cast<std::uint32_t>(first), first_word});
  };
  std::int32_t large_count = 0;
  for (std::int32_t f = 0; f < topology.face_count(); ++f) large_count += is_large(topology, f);
  add_weights(topology, weights, records.words);
  if (large_count < topology.face_count())
    add_part(shared::kStepFaces, topology.corner_count(), 0, 0);
  add_part(shared::kStepLargeFaces, large_count, 0, add_large_faces(topology, records.words));
  add_part(shared::kStepSharp, sharp_rows.row_count(), mesh.first_sharp(), word());
  records.rule = face_sum_rule(weights);
  if (sharp_rows.row_count() > 0) {
    const std::vector<std::int32_t> owners = state_owners(mesh);
    add_sharp(sharp_rows, std::span(owners).subspan(mesh.first_sharp()), records.words);
  }
  return records;
}

}  // namespace planish::vulkan
