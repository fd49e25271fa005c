#include "planish/vulkan/evaluate/patch_records.h"

#include <algorithm>
#include <map>
#include <string>
#include <tuple>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/vulkan/evaluate/state_owners.h"

namespace planish::vulkan {

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

}  // namespace planish::vulkan
