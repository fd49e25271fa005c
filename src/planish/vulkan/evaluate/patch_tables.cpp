#include "planish/vulkan/evaluate/patch_tables.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/patches/patch_mesh.h"

namespace planish::vulkan {

std::vector<std::int32_t> state_owners(const PatchMesh& mesh) {
  const MeshTopology& topology = mesh.topology();
  const SharpFeatures& features = mesh.features();
  std::vector<std::int32_t> owners(static_cast<std::size_t>(mesh.point_count()));
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) owners[c] = topology.vertex_of(c);
  for (std::int32_t e = 0; features.sharp_edge_count > 0 && e < topology.edge_count(); ++e) {
    const std::int32_t sharp = features.sharp_of_edge[e];
    if (sharp < 0) continue;
    const auto [v0, v1] = topology.edge_vertices(e);
    owners[mesh.first_sharp() + 2 * sharp] = v0;
    owners[mesh.first_sharp() + 2 * sharp + 1] = v1;
  }
  for (std::int32_t i = 0; i < features.corner_count; ++i)
    owners[mesh.first_corner_vertex() + i] = features.corner_vertices[i];
  for (const LargeRing& ring : mesh.large_rings())
    std::fill_n(owners.begin() + ring.first_sum, ring.sum_count(), topology.vertex_of(ring.start));
  return owners;
}

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
      for (const double part : {portable::cos(step * i), portable::sin(step * i)})
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

namespace {

using PatchItem = PatchPlan::Item;
using PatchBucket = PatchPlan::Bucket;

constexpr std::int64_t kWindowStep = 64;
constexpr std::uint64_t kWidestPoint = shared::kPointFloats * sizeof(float);
// A window of rows begins where a binding may.
constexpr std::uint64_t kRowSlack = 256;

std::uint32_t as_word(std::int64_t value) { return static_cast<std::uint32_t>(value); }

IndexWindow aligned_window(const IndexWindow& window) {
  const std::int64_t shift = window.first % kWindowStep;
  return {window.first - shift, window.count + shift};
}

std::uint32_t gather_of(const PatchPlace& place) {
  const PatchClass& patch = place.patch;
  if (patch.kind != PatchKind::Smooth || patch.has_ring_sums || patch.has_face_sums)
    return shared::kGatherList;
  switch (place.around) {
    case PatchPlace::Around::Face:
      return shared::kGatherFace;
    case PatchPlace::Around::Edge:
      return shared::kGatherEdge;
    case PatchPlace::Around::Vertex:
      break;
  }
  return patch.is_limit_only() ? shared::kGatherVertex : shared::kGatherCorner;
}

// What all patches of a dispatch have in common: how points are gathered, samples at once, chunks.
using PassKey = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;

struct Pass {
  std::vector<shared::PatchGroup> groups;
  std::vector<PatchSlice> slices;
  std::vector<std::int32_t> owners;
};

// values[0] + step * (places[i] - places[0]) for all i, if these are the values.
bool is_progression(std::span<const std::uint32_t> values, std::span<const std::uint32_t> places,
                    std::uint32_t& step) {
  step = 0;
  if (values.size() > 1 && places[1] > places[0])
    step = (values[1] - values[0]) / (places[1] - places[0]);
  for (std::size_t i = 1; i < values.size(); ++i)
    if (values[0] + step * (places[i] - places[0]) != values[i]) return false;
  return true;
}

class Packer {
 public:
  Packer(const PatchSurface& surface, const PatchLimits& limits, bool with_owners,
         std::span<const RowFrame> frames)
      : surface_(surface),
        mesh_(surface.mesh()),
        limits_(limits),
        with_owners_(with_owners),
        frames_(frames) {
    // Kernels read any of them.
    const auto points =
        static_cast<std::uint64_t>(std::max(mesh_.point_count(), mesh_.topology().vertex_count()));
    limits.range.require(points * kWidestPoint, "points of level 1");
  }

  PatchRecords pack() {
    records_.has_frames = !frames_.empty();
    add_links();
    PatchPlan plan;
    for (const PatchTile& tile : surface_.tiles()) {
      plan.clear();
      surface_.planner().add(tile, 0, plan);
      std::stable_sort(plan.items.begin(), plan.items.end(),
                       [](const PatchItem& x, const PatchItem& y) { return x.bucket < y.bucket; });
      std::size_t first = 0;
      for (const PatchBucket& bucket : plan.buckets) {
        const auto count = static_cast<std::size_t>(bucket.item_count);
        add_bucket(tile, bucket, std::span(plan.items).subspan(first, count));
        first += count;
      }
    }
    join_passes();
    return std::move(records_);
  }

 private:
  void add_links();
  void add_bucket(const PatchTile& tile, const PatchBucket& bucket,
                  std::span<const PatchItem> items);
  void add_group(const PatchTile& tile, const PatchBucket& bucket, std::span<const PatchItem> items,
                 Pass& pass, PatchSlice extent);
  [[nodiscard]] shared::PatchGroup group_of(const PatchTile& tile, const PatchBucket& bucket,
                                            const PatchSlice& extent,
                                            std::span<const PatchItem> items);
  void add_lanes(const PatchTile& tile, std::uint32_t gather, std::span<const PatchItem> items,
                 shared::PatchGroup& group);
  void add_list(std::span<const PatchItem> items);
  void add_frames(const PatchTile& tile, const PatchBucket& bucket,
                  std::span<const PatchItem> items);
  [[nodiscard]] std::uint32_t first_weight(const PatchBucket& bucket, std::uint32_t samples);
  void join_passes();

  [[nodiscard]] std::uint64_t row_bytes(const IndexWindow& rows) const {
    return static_cast<std::uint64_t>(rows.count) * limits_.row_stride + kRowSlack;
  }
  [[nodiscard]] bool fits(const PatchSlice& slice) const {
    return limits_.range.allows(largest_binding(slice)) &&
           std::uint64_t(slice.group_count) * slice.chunk_count <= limits_.max_units;
  }
  [[nodiscard]] std::uint64_t largest_binding(const PatchSlice& slice) const {
    return std::max({static_cast<std::uint64_t>(slice.words.count) * sizeof(std::uint32_t),
                     static_cast<std::uint64_t>(slice.weights.count) * kWidestPoint,
                     row_bytes(slice.rows)});
  }
  [[noreturn]] void refuse(const PatchSlice& slice) const;

  const PatchSurface& surface_;
  const PatchMesh& mesh_;
  const PatchLimits& limits_;
  bool with_owners_;
  std::span<const RowFrame> frames_;
  PatchRecords records_;
  std::map<PassKey, Pass> passes_;
  std::map<std::tuple<std::int32_t, std::int32_t, std::int32_t>, std::uint32_t> weights_;
  std::vector<std::int32_t> gathered_;
};

void Packer::add_links() {
  const MeshTopology& topology = mesh_.topology();
  records_.links.resize(static_cast<std::size_t>(topology.corner_count()));
  parallel_each(records_.links.size(), [&](std::int32_t c) {
    // -1 is kNone.
    records_.links[c] = {as_word(topology.ccw(c)), as_word(topology.next(c))};
  });
}

void Packer::add_bucket(const PatchTile& tile, const PatchBucket& bucket,
                        std::span<const PatchItem> items) {
  const auto count = static_cast<std::uint32_t>(bucket.sample_count);
  PatchSlice extent;
  extent.samples = count % shared::kSampleChunk == 0 ? shared::kSampleChunk : 1;
  extent.chunk_count = count / extent.samples;
  extent.group_count = 1;
  for (std::size_t first = 0; first < items.size();) {
    extent.gather = gather_of(items[first].place);
    std::size_t end = first;
    while (end < items.size() && end - first < shared::kPatchLanes &&
           gather_of(items[end].place) == extent.gather)
      ++end;
    Pass& pass =
        passes_[limits_.joins_ways ? PassKey{}
                                   : PassKey{extent.gather, extent.samples, extent.chunk_count}];
    add_group(tile, bucket, items.subspan(first, end - first), pass, extent);
    first = end;
  }
}

// A group for each block of chunks, of which each says what the dispatch would.
void join_ways(PatchSlice& extent) {
  extent.group_count = (extent.chunk_count + shared::kBlockChunks - 1) / shared::kBlockChunks;
  extent.gather = shared::kGatherAny;
  extent.samples = shared::kSampleChunk;
  extent.chunk_count = 1;
}

void Packer::add_group(const PatchTile& tile, const PatchBucket& bucket,
                       std::span<const PatchItem> items, Pass& pass, PatchSlice extent) {
  extent.rows = {};
  for (const PatchItem& item : items)
    extent.rows =
        extent.rows.joined({tile.first_row + item.target, std::int64_t{bucket.sample_count}});
  if (!fits(extent)) {
    if (items.size() == 1) refuse(extent);
    const std::size_t half = items.size() / 2;
    add_group(tile, bucket, items.first(half), pass, extent);
    add_group(tile, bucket, items.subspan(half), pass, extent);
    return;
  }
  shared::PatchGroup group = group_of(tile, bucket, extent, items);
  extent.first_group = static_cast<std::uint32_t>(pass.groups.size());
  extent.words = aligned_window(
      {group.first_word, std::ssize(records_.words) - std::int64_t{group.first_word}});
  extent.weights = aligned_window(
      {group.first_weight, std::int64_t{group.columns} * extent.samples * extent.chunk_count});
  const PatchSlice way = extent;
  if (limits_.joins_ways) join_ways(extent);
  if (!fits(extent)) refuse(extent);
  for (std::uint32_t block = 0; block < extent.group_count; ++block) {
    const std::uint32_t left = way.chunk_count - block * shared::kBlockChunks;
    group.form = way.gather | way.samples << shared::kFormSamples |
                 std::min(left, shared::kBlockChunks) << shared::kFormChunks |
                 block << shared::kFormBlock;
    pass.groups.push_back(group);
    if (!with_owners_) continue;
    for (const PatchItem& item : items)
      pass.owners.push_back(mesh_.topology().vertex_of(item.place.corner));
    pass.owners.resize(pass.groups.size() * shared::kPatchLanes, -1);
  }
  if (!pass.slices.empty()) {
    PatchSlice longer = pass.slices.back();
    longer.group_count += extent.group_count;
    longer.words = longer.words.joined(extent.words);
    longer.weights = longer.weights.joined(extent.weights);
    longer.rows = longer.rows.joined(extent.rows);
    if (fits(longer)) {
      pass.slices.back() = longer;
      return;
    }
  }
  pass.slices.push_back(extent);
}

shared::PatchGroup Packer::group_of(const PatchTile& tile, const PatchBucket& bucket,
                                    const PatchSlice& extent, std::span<const PatchItem> items) {
  const PatchClass& patch = items.front().place.patch;
  shared::PatchGroup group{};
  group.first_word = as_word(std::ssize(records_.words));
  group.lane_count = as_word(std::ssize(items));
  group.first_weight = first_weight(bucket, extent.samples);
  group.columns = as_word(patch.column_count() - 1);
  group.ring = as_word(patch.ring_size);
  group.face = as_word(extent.gather == shared::kGatherFace ? patch.ring_size : patch.face_size);
  if (bucket.results != PatchPlan::Results::Normals) group.flags |= shared::kHasPositions;
  if (bucket.results != PatchPlan::Results::Positions) group.flags |= shared::kHasNormals;
  add_lanes(tile, extent.gather, items, group);
  if (extent.gather == shared::kGatherList) add_list(items);
  if (!frames_.empty() && (group.flags & shared::kHasNormals) != 0) add_frames(tile, bucket, items);
  return group;
}

void Packer::add_list(std::span<const PatchItem> items) {
  gathered_.resize(static_cast<std::size_t>(items.front().place.patch.column_count()));
  const std::size_t first = records_.words.size();
  records_.words.resize(first + gathered_.size() * shared::kPatchLanes);
  for (std::size_t i = 0; i < items.size(); ++i) {
    mesh_.gather(items[i].place, gathered_.data(), 1);
    for (std::size_t k = 0; k < gathered_.size(); ++k)
      records_.words[first + k * shared::kPatchLanes + i] = as_word(gathered_[k]);
  }
}

void Packer::add_frames(const PatchTile& tile, const PatchBucket& bucket,
                        std::span<const PatchItem> items) {
  const std::size_t first = records_.words.size();
  const auto samples = static_cast<std::size_t>(bucket.sample_count);
  records_.words.resize(first + 2 * samples * shared::kPatchLanes);
  for (std::size_t i = 0; i < items.size(); ++i)
    for (std::size_t s = 0; s < samples; ++s)
      for (std::size_t k = 0; k < 2; ++k)
        records_.words[first + (2 * s + k) * shared::kPatchLanes + i] =
            frames_[static_cast<std::size_t>(tile.first_row + items[i].target) + s].tangents[k];
}

// Corners and rows of the lanes: as steps where they are even, else as words.
void Packer::add_lanes(const PatchTile& tile, std::uint32_t gather,
                       std::span<const PatchItem> items, shared::PatchGroup& group) {
  std::array<std::uint32_t, shared::kPatchLanes> all_corners{}, all_rows{}, all_lanes{};
  const auto corners = std::span(all_corners).first(items.size());
  const auto rows = std::span(all_rows).first(items.size());
  const auto lanes = std::span(all_lanes).first(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    const PatchPlace& place = items[i].place;
    // An edge's point is the next corner's.
    corners[i] =
        as_word(gather == shared::kGatherEdge ? mesh_.topology().prev(place.corner) : place.corner);
    rows[i] = as_word(tile.first_row + items[i].target);
    lanes[i] = as_word(static_cast<std::int64_t>(i));
  }
  group.corner = corners[0];
  group.row = rows[0];
  const auto add_words = [&](const auto& values) {
    records_.words.insert(records_.words.end(), values.begin(), values.end());
  };
  const bool has_corners = gather != shared::kGatherList;
  if (has_corners && !is_progression(corners, lanes, group.corner_step)) {
    group.corner_step = 0;
    group.flags |= shared::kCornersAreWords;
    add_words(all_corners);
  }
  if (is_progression(rows, lanes, group.row_step)) return;
  if (has_corners && is_progression(rows, corners, group.row_step)) {
    group.flags |= shared::kRowsFollowCorners;
    return;
  }
  group.flags |= shared::kRowsAreWords;
  add_words(all_rows);
}

// The weights of a bucket's samples: chunk by chunk, column by column, sample by sample.
std::uint32_t Packer::first_weight(const PatchBucket& bucket, std::uint32_t samples) {
  const auto [place, is_new] =
      weights_.try_emplace({bucket.class_index, bucket.first_sample, bucket.sample_count},
                           as_word(std::ssize(records_.weights)));
  if (!is_new) return place->second;
  const PatchTemplate& weights = surface_.classes().weights(bucket.class_index);
  const auto columns = static_cast<std::size_t>(weights.column_count);
  for (std::int32_t chunk = 0; chunk < bucket.sample_count; chunk += std::int32_t(samples))
    for (std::size_t k = 0; k < columns; ++k)
      for (std::int32_t s = 0; s < std::int32_t(samples); ++s) {
        const auto rows = weights.rows(bucket.first_sample + chunk + s);
        records_.weights.push_back({static_cast<float>(rows[k]),
                                    static_cast<float>(rows[columns + k]),
                                    static_cast<float>(rows[2 * columns + k]), 0});
      }
  return place->second;
}

void Packer::join_passes() {
  for (auto& [key, pass] : passes_) {
    const auto first = as_word(std::ssize(records_.groups));
    records_.groups.insert(records_.groups.end(), pass.groups.begin(), pass.groups.end());
    records_.owners.insert(records_.owners.end(), pass.owners.begin(), pass.owners.end());
    for (PatchSlice& slice : pass.slices) {
      slice.first_group += first;
      records_.slices.push_back(slice);
    }
  }
}

void Packer::refuse(const PatchSlice& slice) const {
  limits_.range.require(largest_binding(slice), "a patch's words, weights or rows",
                        "use --device cpu, a lower level or a smaller mesh");
  throw Error(ErrorCode::OutOfMemory,
              formatted("a patch takes more than the {} chunks of one dispatch that "
                        "maxComputeWorkGroupCount allows; use --device cpu or a lower level",
                        limits_.max_units));
}

}  // namespace

IndexWindow IndexWindow::joined(const IndexWindow& other) const {
  if (count == 0) return other;
  if (other.count == 0) return *this;
  const std::int64_t begin = std::min(first, other.first);
  return {begin, std::max(first + count, other.first + other.count) - begin};
}

PatchRecords patch_records(const PatchSurface& surface, const PatchLimits& limits, bool with_owners,
                           std::span<const RowFrame> frames) {
  return Packer(surface, limits, with_owners, frames).pack();
}

void add_rings(const PatchMesh& mesh, PatchRecords& records) {
  std::vector<std::uint32_t>& words = records.rings;
  const auto next_word = [&] { return static_cast<std::uint32_t>(words.size()); };
  const auto add_float = [&](double value) {
    words.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(value)));
  };
  records.ring_count = static_cast<std::uint32_t>(mesh.large_rings().size());
  records.first_sum = mesh.state_size();
  words.resize(std::size_t{shared::kRingWords} * records.ring_count);
  // Rings of one kind and size share their weights.
  std::map<std::pair<PatchKind, std::int32_t>, std::uint32_t> weights;
  std::vector<std::int32_t> points;
  std::size_t head = 0;
  for (const LargeRing& ring : mesh.large_rings()) {
    mesh.ring_points(ring, points);
    const std::uint32_t first_point = next_word();
    words.insert(words.end(), points.begin(), points.end());
    const auto [place, is_new] = weights.try_emplace({ring.kind, ring.size}, next_word());
    if (is_new) {
      for (const glm::dvec3& row : ring_weights(ring))
        for (int i = 0; i < 3; ++i) add_float(row[i]);
      const auto [first, step] = ring_angles(ring.kind, ring.size);
      for (std::int32_t i = 0; i < ring.size; ++i) {
        add_float(portable::cos(first + step * i));
        add_float(portable::sin(first + step * i));
      }
    }
    for (const auto word :
         {first_point, static_cast<std::uint32_t>(points.size()),
          static_cast<std::uint32_t>(ring.size), static_cast<std::uint32_t>(ring.first_sum),
          static_cast<std::uint32_t>(mesh.topology().vertex_of(ring.start)), place->second})
      words[head++] = word;
  }
}

namespace {

// Items that one binding spans.
template <class Items>
Buffer make_whole(const Maker& on, const Items& items, const char* name) {
  return make_bindable(on, std::as_bytes(std::span(items)).size(), name);
}

// Items of which bindings span windows: only all of them together may be more than a limit.
template <class Items>
Buffer make_windowed(const Maker& on, const Items& items, const char* name) {
  return {on, std::as_bytes(std::span(items)).size(), MemoryUse::Device, name};
}

}  // namespace

PatchLimits patch_limits(const Context& context, std::uint32_t row_stride) {
  PatchLimits limits;
  limits.range = context.binding_limit();
  limits.max_units = std::uint64_t(context.max_group_count()) * context.variant().chunks_per_group;
  limits.row_stride = row_stride;
  limits.joins_ways = context.variant().read_path == ReadPath::Storage;
  return limits;
}

PatchTables::PatchTables(const Maker& on, const PatchRecords& records, std::int64_t points)
    : point_count(points),
      ring_count(records.ring_count),
      has_frames(records.has_frames),
      first_sum(records.first_sum),
      slices(records.slices),
      links(make_whole(on, records.links, "planish corner links")),
      groups(make_whole(on, records.groups, "planish patch groups")),
      words(make_windowed(on, records.words, "planish patch words")),
      weights(make_windowed(on, records.weights, "planish patch weights")),
      rings(make_whole(on, records.rings, "planish rings")) {}

StepTables::StepTables(const Maker& on, const StepRecords& records)
    : parts(records.parts),
      rule(records.rule),
      vertices(make_whole(on, records.vertices, "planish corner vertices")),
      words(make_whole(on, records.words, "planish step words")) {}

BufferRange window_range(const Buffer& items, const IndexWindow& window, std::uint64_t item_bytes) {
  if (window.count == 0) return {items.handle(), 0, item_bytes};
  return {items.handle(), static_cast<std::uint64_t>(window.first) * item_bytes,
          static_cast<std::uint64_t>(window.count) * item_bytes};
}

}  // namespace planish::vulkan
