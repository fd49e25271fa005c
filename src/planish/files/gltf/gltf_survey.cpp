#include "planish/files/gltf/gltf_survey.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <mutex>
#include <string>
#include <utility>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/files/gltf/float_box.h"
#include "planish/files/gltf/gltf_checks.h"
#include "planish/files/gltf/stored_position.h"
#include "planish/files/shared/finite_numbers.h"

namespace planish {
namespace {

// Rows surveyed at once, which fit into a core's own cache.
constexpr std::int64_t kSurveyedRows = std::int64_t{1} << 13;

// As the Khronos validator allows.
constexpr float kUnitLengthTolerance = 5e-4f;

// The first row with a fault, whatever the threads do.
struct Fault {
  std::int64_t row = -1;
  bool is_position = false;
  float normal_length = 1;
  glm::vec3 position{};
  // Positions come before normals.
  [[nodiscard]] bool before(const Fault& other) const {
    if (other.row < 0 || row < 0) return row >= 0;
    return is_position != other.is_position ? is_position : row < other.row;
  }
};

struct Survey {
  std::vector<FloatBox> parts;
  DegenerateRows degenerate;
  Fault fault;

  void add(const Survey& other) {
    parts.resize(other.parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) parts[i].add(other.parts[i]);
    degenerate.add(other.degenerate);
    if (other.fault.before(fault)) fault = other.fault;
  }
};

// One range of rows.
class Surveyor {
 public:
  // `copied` is copied_rows() of the vertices.
  Surveyor(const SurfaceBlocks& surface, const GltfVertices& vertices,
           std::span<const CopiedRow> copied, const GltfOptions& options)
      : surface_(surface),
        vertices_(vertices),
        copied_(copied),
        stored_(options),
        origin_(options.origin) {}

  Survey operator()(RowRange range) {
    const auto count = static_cast<std::size_t>(range.count);
    positions_.resize(count);
    normals_.resize(count);
    RowTarget target;
    target.stored = positions_;
    target.normals = normals_;
    target.origin = origin_;
    Survey survey;
    survey.degenerate = surface_.rows(range, target);
    const FloatBox box = box_of(positions_);
    if (!box.is_finite || !are_surely_units(normals_, kUnitLengthTolerance))
      look_for_faults(range, survey);
    add_bounds(range, box, survey);
    return survey;
  }

 private:
  void look_for_faults(RowRange range, Survey& survey) const {
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      const auto row = range.first + static_cast<std::int64_t>(i);
      if (!is_finite(positions_[i])) note({row, true, 0, positions_[i]}, survey);
      const float length = glm::length(normals_[i]);
      if (!(std::abs(length - 1.0f) <= kUnitLengthTolerance)) note({row, false, length}, survey);
    }
  }
  void add_bounds(RowRange range, const FloatBox& box, Survey& survey) const {
    survey.parts.resize(vertices_.parts.size());
    // One primitive has all rows: its copies have the places of others.
    if (survey.parts.size() == 1) {
      for (const glm::vec3& corner : {box.minimum, box.maximum})
        survey.parts[0].add(stored_.turn(corner));
      return;
    }
    for (const CopiedRow& copy : copies_in(copied_, range)) {
      const auto part = std::ranges::upper_bound(vertices_.parts, copy.vertex, std::less<>(),
                                                 &GltfPart::first_vertex) -
                        1;
      survey.parts[part - vertices_.parts.begin()].add(
          stored_.turn(positions_[copy.row - range.first]));
    }
  }

  static void note(const Fault& fault, Survey& survey) {
    if (fault.before(survey.fault)) survey.fault = fault;
  }

  const SurfaceBlocks& surface_;
  const GltfVertices& vertices_;
  std::span<const CopiedRow> copied_;
  StoredPosition stored_;
  glm::dvec3 origin_;
  RawVector<glm::vec3> positions_, normals_;
};

[[noreturn]] void refuse(const Fault& fault, const GltfOptions& options) {
  if (fault.is_position) {
    refuse_to_write(options,
                    formatted("vertex {} has a coordinate that float32 cannot hold: {}; scale the "
                              "model down, or mend what made it",
                              fault.row, number_words(fault.position)),
                    fault.row);
  }
  refuse_to_write(options,
                  "the normal of vertex " + std::to_string(fault.row) + " has length " +
                      std::to_string(fault.normal_length) + ", not 1",
                  fault.row);
}

}  // namespace

GltfSurvey gltf_survey(const SurfaceBlocks& surface, const GltfVertices& vertices,
                       const GltfOptions& options, std::span<const std::int32_t> surface_rows) {
  const std::vector<CopiedRow> copied = copied_rows(vertices);
  const std::vector<RowRange> pieces = surface.row_blocks(kSurveyedRows);
  Survey all;
  std::mutex mutex;
  LoopProgress progress(options.callbacks, "write", 0, kGltfSurveyed, std::ssize(pieces));
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    Surveyor survey(surface, vertices, copied, options);
    for (std::size_t i = begin; i < end; ++i) {
      const Survey part = survey(pieces[i]);
      const std::lock_guard lock(mutex);
      all.add(part);
      progress.add();
    }
  });
  if (all.fault.row >= 0) {
    if (!surface_rows.empty()) all.fault.row = surface_rows[all.fault.row];
    refuse(all.fault, options);
  }
  return {std::move(all.parts), all.degenerate};
}

std::vector<FloatBox> gltf_bounds(const SurfaceBlocks& surface, const GltfVertices& vertices,
                                  const GltfOptions& options) {
  GltfSurvey found = gltf_survey(surface, vertices, options);
  warn_of(found.degenerate, options.callbacks);
  return std::move(found.bounds);
}

}  // namespace planish
