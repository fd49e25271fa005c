#include "planish/reconstruct/thin_points.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "planish/core/stop.h"

namespace planish {
namespace {

constexpr std::size_t kPointsPerLook = 1 << 14;  // at the host

// Samples by cells that are as wide as the radius, in a hash table.
class SampleGrid {
 public:
  explicit SampleGrid(double radius) : radius_(radius), slots_(1 << 12) {}

  // Samples that are near are in the cell or beside it. Points of one cell often follow each
  // other: what is near is looked up for the first.
  [[nodiscard]] bool has_near(const glm::dvec3& place) {
    const Cell cell = cell_of(place);
    if (!knows_cell_ || !(cell == cell_)) {
      knows_cell_ = true;
      cell_ = cell;
      list_nearby();
    }
    for (const glm::dvec3& sample : nearby_) {
      const glm::dvec3 offset = sample - place;
      if (glm::dot(offset, offset) < radius_ * radius_) return true;
    }
    return false;
  }
  void add(const glm::dvec3& place) {
    const Cell cell = cell_of(place);
    Slot& slot = slot_of(cell);
    if (slot.head < 0) {
      slot.cell = cell;
      ++used_;
    }
    next_.push_back(slot.head);
    slot.head = static_cast<std::int32_t>(places_.size());
    places_.push_back(place);
    if (knows_cell_ && cell == cell_) nearby_.push_back(place);
    if (4 * used_ > 3 * slots_.size()) grow();
  }

 private:
  // Whole numbers as doubles: clouds far larger than the radius have no cells beyond reach.
  using Cell = glm::dvec3;
  struct Slot {
    Cell cell{0.0};
    std::int32_t head = -1;
  };

  [[nodiscard]] Cell cell_of(const glm::dvec3& place) const { return glm::floor(place / radius_); }
  [[nodiscard]] Slot& slot_of(const Cell& cell) {
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {
      hash ^= static_cast<std::uint64_t>(static_cast<std::int64_t>(std::fmod(cell[axis], 0x1p62)));
      hash *= 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
    std::size_t at = hash & (slots_.size() - 1);
    while (slots_[at].head >= 0 && !(slots_[at].cell == cell)) at = (at + 1) & (slots_.size() - 1);
    return slots_[at];
  }
  void grow() {
    std::vector<Slot> before(2 * slots_.size());
    std::swap(before, slots_);
    for (const Slot& slot : before)
      if (slot.head >= 0) slot_of(slot.cell) = slot;
  }
  void list_nearby() {
    nearby_.clear();
    for (int i = 0; i < 27; ++i) {
      const Cell beside = cell_ + glm::dvec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      for (std::int32_t s = slot_of(beside).head; s >= 0; s = next_[s])
        nearby_.push_back(places_[s]);
    }
  }

  double radius_;
  std::vector<Slot> slots_;
  std::size_t used_ = 0;
  std::vector<glm::dvec3> places_;
  std::vector<std::int32_t> next_;  // sample of the same cell
  bool knows_cell_ = false;
  Cell cell_{0.0};
  std::vector<glm::dvec3> nearby_;  // samples in and beside cell_
};

}  // namespace

std::vector<std::int32_t> thin_points(const OrderedPoints& points,
                                      std::optional<std::span<const std::int32_t>> asked,
                                      double radius, std::span<const std::int32_t> samples) {
  SampleGrid grid(radius);
  for (const std::int32_t sample : samples) grid.add(points[sample]);
  std::vector<std::int32_t> chosen;
  const std::size_t count = asked ? asked->size() : points.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (i % kPointsPerLook == 0) check_stop();
    const std::int32_t point = asked ? (*asked)[i] : static_cast<std::int32_t>(i);
    const glm::dvec3 place = points[point];
    if (grid.has_near(place)) continue;
    grid.add(place);
    chosen.push_back(point);
  }
  return chosen;
}

}  // namespace planish
