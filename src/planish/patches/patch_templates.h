#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/patches/patch_class.h"

namespace planish {

class PatchRings;

/// The samples (a, b), 0 <= a, b <= N = 2^(level - 1), of a patch at u = a/N, v = b/N. First those
/// that a corner owns, in the order of its rows: (1..N-1, 0), then for b = 1..N-1 (1..N, b). Then
/// (0, 1..N-1), which it owns where its trailing edge is sharp; then the rest.
class PatchSamples {
 public:
  explicit PatchSamples(int level) : n_(1 << (level - 1)) {}

  [[nodiscard]] std::int32_t side() const { return n_; }  ///< N
  [[nodiscard]] std::int32_t count() const { return (n_ + 1) * (n_ + 1); }
  [[nodiscard]] std::int32_t leading_count() const { return n_ - 1; }
  [[nodiscard]] std::int32_t owned_count() const { return n_ * n_ - 1; }
  [[nodiscard]] std::int32_t trailing_count() const { return n_ - 1; }
  [[nodiscard]] std::int32_t first_trailing() const { return owned_count(); }
  [[nodiscard]] std::int32_t index(std::int32_t a, std::int32_t b) const {
    const std::int32_t shared = owned_count() + trailing_count();
    if (b == n_) return shared + 2 + a;
    if (a == 0) return b == 0 ? shared : owned_count() + b - 1;
    if (b == 0) return a == n_ ? shared + 1 : a - 1;
    return n_ - 1 + (b - 1) * n_ + a - 1;
  }
  struct Place {
    std::int32_t a, b;
  };
  /// Of a sample that is owned, or of the trailing edge: what index() leads from.
  [[nodiscard]] Place place(std::int32_t index) const {
    if (index < leading_count()) return {index + 1, 0};
    if (index >= first_trailing()) return {0, index - first_trailing() + 1};
    const std::int32_t inner = index - leading_count();
    return {inner % n_ + 1, inner / n_ + 1};
  }

 private:
  std::int32_t n_;
};

/// What a class's patches are of their control points: rows of weights for all but the own point,
/// which is the origin of the others and of the result. Positions' rows sum to 1 with the own
/// point's weight, tangents' to 0.
struct PatchTemplate {
  std::int32_t column_count = 0;  ///< K - 1
  std::int32_t sample_count = 0;
  /// Per sample in the order of PatchSamples three rows: point, du, dv.
  std::vector<double> weights;

  [[nodiscard]] std::span<const double> rows(std::int32_t sample) const {
    const auto size = 3 * static_cast<std::size_t>(column_count);
    return {weights.data() + size * static_cast<std::size_t>(sample), size};
  }
};

/// Makes templates. A patch of level L is four of level L - 1 of a step's points, so each class's
/// template is those of its quarters times small matrices.
class PatchTemplates {
 public:
  explicit PatchTemplates(Weights weights) : weights_(weights) {}

  /// Of a limit point at any level: one sample.
  [[nodiscard]] PatchTemplate make(const PatchClass& patch, int level);

 private:
  // All samples, row b (N + 1) + a, three rows of K weights each.
  using Grid = std::vector<double>;
  const Grid& grid(const PatchClass& patch, int level);
  void add_quarter(const PatchRings& rings, int quarter, int level, std::size_t columns,
                   Grid& result);

  FaceWeights weights_;
  std::map<std::pair<PatchClass, int>, std::unique_ptr<Grid>> grids_;
};

}  // namespace planish
