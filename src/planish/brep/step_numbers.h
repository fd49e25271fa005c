#pragma once

#include <cstdint>
#include <vector>

#include "planish/brep/brep.h"

namespace planish {

/// Numbers of a STEP file's entities, which are known before any text is. Points, and lines of
/// curves in parameters, stand once: a face's points on its border are those of its edges where
/// both have the same knots.
class StepNumbers {
 public:
  /// `brep` must outlive it. `first`: of the entities behind the head.
  StepNumbers(const Brep& brep, std::int64_t first);

  // First and last entity of each; those of an edge and a face are what others refer to.
  [[nodiscard]] std::int64_t first_of_vertex(std::int64_t v) const { return vertices_ + 2 * v; }
  [[nodiscard]] std::int64_t vertex(std::int64_t v) const { return first_of_vertex(v) + 1; }
  [[nodiscard]] std::int64_t first_of_edge(std::int64_t e) const { return edges_[e]; }
  [[nodiscard]] std::int64_t edge(std::int64_t e) const { return first_of_edge(e + 1) - 1; }
  [[nodiscard]] std::int64_t first_of_face(std::int64_t f) const { return faces_[f]; }
  [[nodiscard]] std::int64_t face(std::int64_t f) const { return first_of_face(f + 1) - 1; }
  /// The surface of a face, which stands before its loop.
  [[nodiscard]] std::int64_t surface(std::int64_t f) const;
  [[nodiscard]] std::int64_t end() const { return faces_.back(); }

  /// Of a face, in their order: the points' numbers, those of its own counted from first_of_face()
  /// on. Returns how many these are.
  std::int64_t points(std::int64_t f, std::vector<std::int64_t>& numbers) const;

  /// Distinct lines of curves in parameters, three entities each, before all vertices.
  struct PlaneLine {
    std::int32_t x = 0, y = 0, direction = 0;
    friend auto operator<=>(const PlaneLine&, const PlaneLine&) = default;
  };
  [[nodiscard]] const std::vector<PlaneLine>& lines() const { return lines_; }
  /// What a curve in parameters refers to.
  [[nodiscard]] std::int64_t line(const Brep::Line& line) const;
  [[nodiscard]] static PlaneLine plane_line(const Brep::Line& line);
  /// Whether a side of an edge has a curve in parameters: those of planes need none.
  [[nodiscard]] bool has_curve(const Brep::Line& line) const {
    return line.face >= 0 && !brep_.faces[line.face].plane;
  }

 private:
  [[nodiscard]] std::int64_t of_edge(const Brep::Edge& edge) const;

  const Brep& brep_;
  std::vector<PlaneLine> lines_;
  std::int64_t first_, vertices_ = 0;
  std::vector<std::int64_t> edges_, faces_;
};

}  // namespace planish
