#pragma once

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace planish::test {

/// A value in an entity: a word, text or number as it stands, a reference, or a list.
struct Part21Value {
  std::string_view text;       ///< in the file's
  std::int64_t reference = 0;  ///< 0: none
  std::vector<Part21Value> items;

  [[nodiscard]] double number() const {
    double value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || stop < text.data() + text.size())
      throw std::runtime_error("no number: " + std::string(text));
    return value;
  }
};

struct Part21Entity {
  std::string_view keyword;  ///< empty for complex ones
  std::vector<Part21Value> values;
  bool is_there = false;
};

/// A STEP file, read with no code of the writer.
class Part21File {
 public:
  explicit Part21File(const std::string& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    text_.resize(static_cast<std::size_t>(file.tellg()));
    file.seekg(0).read(text_.data(), std::ssize(text_));
    at_ = text_.find("DATA;");
    if (text_.rfind("ISO-10303-21;", 0) != 0 || at_ == std::string::npos)
      throw std::runtime_error("no STEP");
    at_ += 5;
    for (skip(); text_[at_] == '#'; skip()) {
      const std::int64_t id = reference();
      expect('=');
      // Numbers are dense.
      if (id > std::ssize(text_)) throw std::runtime_error("#" + std::to_string(id));
      if (id >= std::ssize(entities_)) entities_.resize(static_cast<std::size_t>(id) + 1);
      Part21Entity& entity = entities_[id];
      if (entity.is_there) throw std::runtime_error("twice");
      entity.is_there = true;
      entity.keyword = word();
      entity.values = list();
      by_keyword_[entity.keyword].push_back(id);
      expect(';');
    }
    if (text_.compare(at_, 7, "ENDSEC;") != 0)
      throw std::runtime_error("no ENDSEC at " + std::to_string(at_));
    for (const Part21Entity& entity : entities_)
      for (const Part21Value& value : entity.values) require(value);
    for (auto& [keyword, ids] : by_keyword_) std::ranges::sort(ids);
  }

  // What it holds names places in its text.
  Part21File(const Part21File&) = delete;
  Part21File& operator=(const Part21File&) = delete;

  [[nodiscard]] const Part21Entity& at(std::int64_t id) const {
    if (!has(id)) throw std::runtime_error("no entity #" + std::to_string(id));
    return entities_[id];
  }
  [[nodiscard]] const Part21Entity& at(const Part21Value& value) const {
    return entities_.at(value.reference);
  }
  /// Ascending.
  [[nodiscard]] std::vector<std::int64_t> all(std::string_view keyword) const {
    const auto found = by_keyword_.find(keyword);
    return found == by_keyword_.end() ? std::vector<std::int64_t>() : found->second;
  }

 private:
  [[nodiscard]] bool has(std::int64_t id) const {
    return id > 0 && id < std::ssize(entities_) && entities_[id].is_there;
  }
  void require(const Part21Value& value) const {
    if (value.reference != 0) (void)at(value.reference);
    for (const Part21Value& item : value.items) require(item);
  }
  void skip() {
    while (std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  void expect(char letter) {
    skip();
    if (text_[at_] != letter)
      throw std::runtime_error(std::string("expected ") + letter + " at " + std::to_string(at_));
    ++at_;
  }
  std::int64_t reference() {
    expect('#');
    std::int64_t id = 0;
    while (std::isdigit(static_cast<unsigned char>(text_[at_])) != 0)
      id = 10 * id + (text_[at_++] - '0');
    return id;
  }
  std::string_view word() {
    skip();
    const std::size_t begin = at_;
    while (std::isalnum(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '_') ++at_;
    return std::string_view(text_).substr(begin, at_ - begin);
  }
  std::vector<Part21Value> list() {
    std::vector<Part21Value> values;
    expect('(');
    for (skip(); text_[at_] != ')'; skip()) {
      if (text_[at_] == ',') {
        ++at_;
        continue;
      }
      values.push_back(value());
    }
    ++at_;
    return values;
  }
  Part21Value value() {
    Part21Value result;
    skip();
    if (text_[at_] == '#') {
      result.reference = reference();
    } else if (text_[at_] == '(') {
      result.items = list();
    } else if (text_[at_] == '\'') {
      std::size_t end = text_.find('\'', at_ + 1);
      while (text_[end + 1] == '\'') end = text_.find('\'', end + 2);  // a quote stands twice
      result.text = std::string_view(text_).substr(at_, end + 1 - at_);
      at_ = end + 1;
    } else {
      const std::size_t begin = at_;
      while (text_[at_] != ',' && text_[at_] != ')' && text_[at_] != '(') ++at_;
      result.text = std::string_view(text_).substr(begin, at_ - begin);
      if (text_[at_] == '(') result.items = list();
    }
    return result;
  }

  std::string text_;
  std::size_t at_ = 0;
  std::vector<Part21Entity> entities_;
  std::map<std::string_view, std::vector<std::int64_t>> by_keyword_;
};

/// B-spline by de Boor's recursion, of any degree and knots.
struct KnotLine {
  int degree = 2;
  std::vector<double> knots;  ///< with multiplicity

  [[nodiscard]] double low() const { return knots.front(); }
  [[nodiscard]] double high() const { return knots.back(); }
  /// Of `count` points, of which only those that have a say are asked for.
  template <class Point, class PointOf>
  [[nodiscard]] Point at(std::size_t count, double t, const PointOf& point_of) const {
    auto span = static_cast<std::size_t>(degree);
    while (span + 1 < count && t >= knots[span + 1]) ++span;
    const auto p = static_cast<std::size_t>(degree);
    std::array<Point, kMostDegree + 1> d;
    for (std::size_t j = 0; j <= p; ++j) d[j] = point_of(j + span - p);
    for (std::size_t r = 1; r <= p; ++r) {
      for (std::size_t j = p; j >= r; --j) {
        const double a = knots[j + span - p], b = knots[j + 1 + span - r];
        const double w = (t - a) / (b - a);
        d[j] = (1 - w) * d[j - 1] + w * d[j];
      }
    }
    return d[p];
  }
  template <class Point>
  [[nodiscard]] Point at(const std::vector<Point>& points, double t) const {
    return at<Point>(points.size(), t, [&](std::size_t i) { return points[i]; });
  }
  static constexpr std::size_t kMostDegree = 3;
};

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
