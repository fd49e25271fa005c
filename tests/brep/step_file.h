#pragma once

#include <glm/geometric.hpp>

#include <map>

#include "brep/part21.h"

namespace planish::test {

/// Splines of a STEP file by their numbers.
class StepFile : public Part21File {
 public:
  using Part21File::Part21File;

  struct Surface {
    KnotLine u, v;
    std::vector<std::vector<glm::dvec3>> rows;  // by u, then v
    [[nodiscard]] glm::dvec3 at(double s, double t) const {
      return u.at<glm::dvec3>(rows.size(), s, [&](std::size_t i) { return v.at(rows[i], t); });
    }
  };
  struct Curve {
    KnotLine t;
    std::vector<glm::dvec3> points;
    [[nodiscard]] glm::dvec3 at(double s) const { return t.at(points, s); }
  };
  struct Plane {
    glm::dvec3 origin{}, normal{};
  };
  struct PlaneLine {
    std::int64_t surface = 0;
    glm::dvec2 from{}, direction{};
  };

  [[nodiscard]] glm::dvec3 point(const Part21Value& value) const {
    const auto& xyz = at(value).values[1].items;
    return {xyz[0].number(), xyz[1].number(), xyz.size() > 2 ? xyz[2].number() : 0};
  }
  /// Made when first asked for.
  [[nodiscard]] const Surface& surface(std::int64_t id) const {
    Surface& result = surfaces_[id];
    if (!result.rows.empty()) return result;
    const auto& values = at(id).values;
    result.u = line(values[1], values[8], values[10]);
    result.v = line(values[2], values[9], values[11]);
    for (const Part21Value& row : values[3].items) {
      result.rows.emplace_back();
      for (const Part21Value& p : row.items) result.rows.back().push_back(point(p));
    }
    return result;
  }
  [[nodiscard]] Curve curve(std::int64_t id) const {
    const auto& values = at(id).values;
    Curve result{line(values[1], values[6], values[7]), {}};
    for (const Part21Value& p : values[2].items) result.points.push_back(point(p));
    return result;
  }
  [[nodiscard]] Plane plane(std::int64_t id) const {
    const auto& place = at(at(id).values[1]).values;
    return {point(place[1]), point(place[2])};
  }
  [[nodiscard]] PlaneLine plane_line(const Part21Value& pcurve) const {
    const auto& values = at(pcurve).values;
    const auto& straight = at(at(values[2]).values[1].items[0]).values;
    const auto& vector = at(straight[2]).values;
    return {values[1].reference, glm::dvec2(point(straight[1])),
            vector[2].number() * glm::dvec2(point(vector[1]))};
  }

 private:
  mutable std::map<std::int64_t, Surface> surfaces_;

  static KnotLine line(const Part21Value& degree, const Part21Value& counts,
                       const Part21Value& values) {
    KnotLine result{static_cast<int>(degree.number()), {}};
    for (std::size_t i = 0; i < values.items.size(); ++i)
      result.knots.insert(result.knots.end(), static_cast<std::size_t>(counts.items[i].number()),
                          values.items[i].number());
    return result;
  }
};

}  // namespace planish::test
