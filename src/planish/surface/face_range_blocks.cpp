#include "planish/surface/face_range_blocks.h"

#include <atomic>
#include <bit>

#include "planish/core/parallel.h"
#include "planish/core/prefix_sum.h"

namespace planish {

namespace {

constexpr std::int64_t kMarkedFaces = std::int64_t{1} << 14;
constexpr std::int32_t kWordBits = 64;

// of(range, place) for numbers that follow one another, from that place of `wanted` on.
template <class Of>
void for_runs(std::span<const std::int32_t> wanted, const Of& of) {
  for (std::size_t i = 0; i < wanted.size();) {
    std::size_t count = 1;
    while (i + count < wanted.size() && wanted[i + count] == wanted[i + count - 1] + 1) ++count;
    of(RowRange{wanted[i], static_cast<std::int64_t>(count)}, i);
    i += count;
  }
}

}  // namespace

SubsetNumbers::SubsetNumbers(std::int64_t limit)
    : marks_(static_cast<std::size_t>((limit + kWordBits - 1) / kWordBits), 0) {}

void SubsetNumbers::add(std::span<const std::int32_t> numbers) {
  for (const std::int32_t number : numbers) {
    const std::atomic_ref word(marks_[number / kWordBits]);
    const std::uint64_t bit = std::uint64_t{1} << (number % kWordBits);
    // Most are there by a face before: no need to own the word then.
    if ((word.load(std::memory_order_relaxed) & bit) == 0)
      word.fetch_or(bit, std::memory_order_relaxed);
  }
}

void SubsetNumbers::finish() {
  constexpr std::size_t kWords = std::size_t{1} << 12;
  before_.resize(marks_.size());
  parallel_each(marks_.size(), kWords,
                [&](std::size_t w) { before_[w] = std::popcount(marks_[w]); });
  numbers_.resize(static_cast<std::size_t>(exclusive_sum(before_)));
  parallel_each(marks_.size(), kWords, [&](std::int32_t w) {
    std::int32_t* to = numbers_.data() + before_[w];
    for (std::uint64_t left = marks_[w]; left != 0; left &= left - 1)
      *to++ = w * kWordBits + std::countr_zero(left);
  });
}

std::int32_t SubsetNumbers::place_of(std::int32_t number) const {
  const auto word = static_cast<std::size_t>(number / kWordBits);
  const std::uint64_t lower = (std::uint64_t{1} << (number % kWordBits)) - 1;
  return before_[word] + std::popcount(marks_[word] & lower);
}

FaceRangeBlocks::FaceRangeBlocks(const SurfaceBlocks& surface, RowRange faces)
    : surface_(surface), faces_(faces) {
  const SurfaceInfo& all = surface.info();
  info_.level = all.level;
  info_.face_count = faces.count;
  info_.corner_count = all.first_corner(faces.first + faces.count) - all.first_corner(faces.first);
  info_.has_colors = all.has_colors;
  info_.has_groups = all.has_groups;
  info_.attributes = all.attributes;
  info_.groups = all.groups;
  info_.corners_per_face = all.corners_per_face;
  if (!all.face_offsets.empty()) {
    const auto begin = all.face_offsets.begin() + faces.first;
    info_.face_offsets.assign(begin, begin + faces.count + 1);
    for (std::int32_t& offset : info_.face_offsets) offset -= *begin;
  }
  find_numbers();
  info_.row_count = static_cast<std::int64_t>(rows_.all().size());
  info_.uv_count = static_cast<std::int64_t>(uvs_.all().size());
  for (const std::int32_t row : rows_.all()) {
    if (static_cast<std::size_t>(row) >= all.base_vertices.size()) break;
    info_.base_vertices.push_back(all.base_vertices[row]);
  }
}

void FaceRangeBlocks::find_numbers() {
  const SurfaceInfo& all = surface_.info();
  rows_ = SubsetNumbers(all.row_count);
  if (all.uv_count > 0) uvs_ = SubsetNumbers(all.uv_count);
  const std::vector<RowRange> pieces = ranges_of(faces_.count, kMarkedFaces);
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    RawVector<std::int32_t> numbers;
    for (std::size_t i = begin; i < end; ++i) {
      const RowRange piece = there(pieces[i]);
      numbers.resize(static_cast<std::size_t>(all.first_corner(piece.first + piece.count) -
                                              all.first_corner(piece.first)));
      surface_.face_vertices(piece, numbers);
      rows_.add(numbers);
      if (all.uv_count == 0) continue;
      surface_.face_uvs(piece, numbers);
      uvs_.add(numbers);
    }
  });
  rows_.finish();
  uvs_.finish();
}

// What is here of the surface's own blocks: most are here whole, and cheaper than rows by number.
std::vector<RowRange> FaceRangeBlocks::row_blocks(std::int64_t row_count) const {
  std::vector<RowRange> ranges;
  for (const RowRange& block : surface_.row_blocks(row_count)) {
    const auto place = [&](std::int64_t row) -> std::int64_t {
      return row < surface_.info().row_count ? rows_.place_of(static_cast<std::int32_t>(row))
                                             : info_.row_count;
    };
    const std::int64_t first = place(block.first), end = place(block.first + block.count);
    if (end > first) ranges.push_back({first, end - first});
  }
  return ranges;
}

DegenerateRows FaceRangeBlocks::rows(RowRange rows, const RowTarget& target) const {
  if (rows.count == 0) return {};
  const std::span<const std::int32_t> wanted = part(rows_, rows);
  if (wanted.back() - wanted.front() == static_cast<std::int32_t>(rows.count) - 1)
    return surface_.rows({wanted.front(), rows.count}, target);
  return surface_.rows_at(wanted, target);
}

void FaceRangeBlocks::face_vertices(RowRange faces, std::span<std::int32_t> rows) const {
  surface_.face_vertices(there(faces), rows);
  for (std::int32_t& row : rows) row = rows_.place_of(row);
}

void FaceRangeBlocks::face_uvs(RowRange faces, std::span<std::int32_t> uvs) const {
  surface_.face_uvs(there(faces), uvs);
  for (std::int32_t& uv : uvs) uv = uvs_.place_of(uv);
}

void FaceRangeBlocks::uvs(RowRange uvs, std::span<glm::dvec2> values) const {
  for_runs(part(uvs_, uvs), [&](RowRange there, std::size_t i) {
    surface_.uvs(there, values.subspan(i, static_cast<std::size_t>(there.count)));
  });
}

void FaceRangeBlocks::attribute(std::size_t index, RowRange rows, std::span<float> values) const {
  const auto width = static_cast<std::size_t>(info_.attributes[index].width);
  for_runs(part(rows_, rows), [&](RowRange there, std::size_t i) {
    surface_.attribute(index, there,
                       values.subspan(width * i, width * static_cast<std::size_t>(there.count)));
  });
}

}  // namespace planish
