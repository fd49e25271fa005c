#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "planish/surface/surface_quality.h"

namespace planish {

/// Gathers SurfaceQuality::folded_places from faces in ascending order.
class FoldedPlaces {
 public:
  /// `is_elsewhere`: counts in folded_area_elsewhere.
  void add(const FoldedPlace& place, bool is_elsewhere) {
    add_to(all_, place);
    if (is_elsewhere) add_to(elsewhere_, place);
  }

  /// Of later faces.
  void add(const FoldedPlaces& later) {
    for (const FoldedPlace& place : later.all_) add_to(all_, place);
    for (const FoldedPlace& place : later.elsewhere_) add_to(elsewhere_, place);
  }

  [[nodiscard]] const std::vector<FoldedPlace>& all() const { return all_; }
  [[nodiscard]] const std::vector<FoldedPlace>& elsewhere() const { return elsewhere_; }
  [[nodiscard]] std::vector<FoldedPlace> take() {
    return std::move(elsewhere_.empty() ? all_ : elsewhere_);
  }

 private:
  static void add_to(std::vector<FoldedPlace>& places, const FoldedPlace& place) {
    if (places.size() == kNamedFolds) return;
    if (places.empty() || places.back().face != place.face) places.push_back(place);
  }

  std::vector<FoldedPlace> all_, elsewhere_;
};

}  // namespace planish
