#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "planish/pipeline/fit_mesh.h"
#include "quality/figures.h"
#include "quality/tally.h"

namespace planish::quality {

/// A surface that was made and measured.
struct Outcome {
  std::string flags;   ///< what a user says for it
  std::string choice;  ///< what it is: method, whether with creases and joined triangles
  Figures figures;
  double milliseconds = 0;
};

[[nodiscard]] double milliseconds_since(std::chrono::steady_clock::time_point start);
[[nodiscard]] Outcome fitted(const Case& what, const std::string& flags,
                             const MeshFitOptions& options, Backend& backend);

/// What a user could have said instead: methods, creases and quads.
[[nodiscard]] std::vector<std::pair<std::string, MeshFitOptions>> mesh_flags();

/// What came out without a flag, beside the best of others; printed row by row.
class OutcomeTable {
 public:
  /// With a column of what came out before, or one of what was chosen instead.
  explicit OutcomeTable(bool has_before);
  /// `before` is looked at where there is a column for it.
  void add(const Case& what, const Outcome* before, const Outcome& now,
           const std::vector<Outcome>& others);
  /// Prints the sums; returns what is more than a tenth farther off the shape's normals.
  [[nodiscard]] std::vector<std::string> finish();

 private:
  bool has_before_;
  Tally tallies_[2];
  double before_ = 0, now_ = 0;
  std::vector<std::string> wrong_;
};

}  // namespace planish::quality
