#pragma once

#include <cstdint>
#include <vector>

#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_numbering.h"
#include "planish/patches/patch_templates.h"

namespace planish {

/// Rows that follow one another, of one part.
struct PatchTile {
  PatchNumbering::Part part;
  std::int64_t first_item, item_count;
  std::int64_t first_row, row_count;
};

/// Which patches make which rows, by class and samples.
struct PatchPlan {
  /// Which results a bucket's rows take: at a cut the further side's rows take their positions from
  /// the first side's patch, so that both are equal to the last bit.
  enum class Results : std::uint8_t { All, Positions, Normals };

  struct Bucket {
    std::int32_t class_index;
    std::int32_t first_sample, sample_count;
    Results results;
    std::int32_t item_count;

    [[nodiscard]] bool has_results_of(const Bucket& other) const {
      return first_sample == other.first_sample && sample_count == other.sample_count &&
             results == other.results;
    }
  };
  std::vector<Bucket> buckets;

  struct Item {
    PatchPlace place;
    std::int32_t bucket;
    std::int32_t target;  ///< the row of the bucket's first sample
  };
  std::vector<Item> items;

  void clear() {
    buckets.clear();
    items.clear();
  }
};

/// The classes of a mesh's patches by number, with their templates at one level.
class PatchClasses {
 public:
  PatchClasses(const PatchNumbering& numbering, const PatchMesh& mesh, Weights weights);

  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(classes_.size()); }
  [[nodiscard]] const PatchClass& patch(std::int32_t index) const { return classes_[index]; }
  [[nodiscard]] const PatchTemplate& weights(std::int32_t index) const { return templates_[index]; }
  [[nodiscard]] std::int32_t index_of(const PatchClass& patch) const;
  /// Of the smooth class with a ring and a face of few corners; -1 where there is none of them.
  [[nodiscard]] std::int32_t smooth_index(std::int32_t ring_size, std::int32_t face_size) const {
    return ring_size < kTableSize && face_size < kTableSize
               ? table_[static_cast<std::size_t>(ring_size) * kTableSize + face_size]
               : -1;
  }
  /// The largest K.
  [[nodiscard]] std::int32_t max_column_count() const { return max_column_count_; }

 private:
  // Smooth classes of few faces are found in a table.
  static constexpr std::int32_t kTableSize = 32;

  std::vector<PatchClass> classes_;  // ascending
  std::vector<PatchTemplate> templates_;
  std::vector<std::int32_t> table_;
  std::int32_t max_column_count_ = 0;
};

/// Cuts rows into tiles and lists their patches. All of it must outlive the planner.
class PatchPlanner {
 public:
  PatchPlanner(const PatchMesh& mesh, const PatchNumbering& numbering, const PatchClasses& classes)
      : mesh_(mesh), numbering_(numbering), classes_(classes) {}

  /// All tiles, ascending by rows.
  [[nodiscard]] std::vector<PatchTile> tiles() const;
  /// Adds a tile's items to a plan; its first row is `target` there.
  void add(const PatchTile& tile, std::int64_t target, PatchPlan& plan) const;

 private:
  const PatchMesh& mesh_;
  const PatchNumbering& numbering_;
  const PatchClasses& classes_;
};

}  // namespace planish
