#include "planish/files/shared/line_records.h"

#include <limits>

#include "planish/core/formatted.h"
#include "planish/files/shared/read_progress.h"

namespace planish {

LineRecords::LineRecords(const FileBytes& file, const TextLines& lines, std::size_t part_bytes)
    : start_(lines), parts_(lines.rest().cut(part_bytes)) {
  expect_passes(file, 2);
  first_.resize(parts_.size() + 1, 0);
  std::vector<std::int64_t> line_counts(parts_.size());
  parallel_each(parts_.size(), 1, [&](std::size_t p) {
    TextLines part = parts_[p];
    while (part.next_with_words()) ++first_[p + 1];
    line_counts[p] = part.lines_passed();
    part.count();
  });
  last_line_ = lines.lines_passed();
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    first_[p + 1] += first_[p];
    parts_[p].count_from(last_line_);
    last_line_ += line_counts[p];
  }
}

TextLines LineRecords::before(std::int64_t record) const {
  TextLines lines = start_;
  if (record == 0) return lines;
  const auto behind = std::ranges::lower_bound(first_, record);
  const auto part = static_cast<std::size_t>(behind - first_.begin()) - 1;
  lines.move_before(parts_[part]);
  for (std::int64_t r = first_[part]; r < record; ++r) (void)lines.next_with_words();
  return lines;
}

void LineRecords::fail_at_end(const std::string& what, std::int64_t index,
                              std::int64_t total) const {
  start_.fail_at(std::max<std::int64_t>(last_line_, 1),
                 formatted("the file ends at {} {} of {}", what, index, total), index);
}

std::int64_t FaceParts::append_to(PolygonMesh& mesh) const {
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  std::size_t face_count = 0, corner_count = mesh.face_vertices.size();
  for (const Part& part : parts) {
    for (const std::int32_t size : part.sizes) {
      corner_count += static_cast<std::size_t>(size);
      if (corner_count >= kMost) return static_cast<std::int64_t>(face_count);
      ++face_count;
    }
  }
  mesh.face_offsets.reserve(mesh.face_offsets.size() + face_count);
  mesh.face_vertices.reserve(corner_count);
  for (const Part& part : parts) {
    for (const std::int32_t size : part.sizes)
      mesh.face_offsets.push_back(mesh.face_offsets.back() + size);
    mesh.face_vertices.insert(mesh.face_vertices.end(), part.vertices.begin(), part.vertices.end());
  }
  return -1;
}

}  // namespace planish
