#pragma once

#include <cstdint>
#include <fstream>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace planish::test {

/// A value in an entity: a word, text or number as it stands, a reference, or a list.
struct Part21Value {
  std::string text;
  std::int64_t reference = 0;  ///< 0: none
  std::vector<Part21Value> items;

  [[nodiscard]] double number() const { return std::stod(text); }
};

struct Part21Entity {
  std::string keyword;  ///< empty for complex ones
  std::vector<Part21Value> values;
};

/// A STEP file, read with no code of the writer.
class Part21File {
 public:
  explicit Part21File(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream all;
    all << file.rdbuf();
    text_ = all.str();
    at_ = text_.find("DATA;");
    if (text_.rfind("ISO-10303-21;", 0) != 0 || at_ == std::string::npos)
      throw std::runtime_error("no STEP");
    at_ += 5;
    for (skip(); text_[at_] == '#'; skip()) {
      const std::int64_t id = reference();
      expect('=');
      Part21Entity& entity = entities_[id];
      if (!entity.keyword.empty() || !entity.values.empty()) throw std::runtime_error("twice");
      entity.keyword = word();
      entity.values = list();
      expect(';');
    }
    if (text_.compare(at_, 7, "ENDSEC;") != 0)
      throw std::runtime_error("no ENDSEC at " + std::to_string(at_));
    for (const auto& [id, entity] : entities_)
      for (const Part21Value& value : entity.values) require(value);
  }

  [[nodiscard]] const std::map<std::int64_t, Part21Entity>& entities() const { return entities_; }
  [[nodiscard]] const Part21Entity& at(std::int64_t id) const { return entities_.at(id); }
  [[nodiscard]] const Part21Entity& at(const Part21Value& value) const {
    return entities_.at(value.reference);
  }
  [[nodiscard]] std::vector<std::int64_t> all(const std::string& keyword) const {
    std::vector<std::int64_t> ids;
    for (const auto& [id, entity] : entities_)
      if (entity.keyword == keyword) ids.push_back(id);
    return ids;
  }

 private:
  void require(const Part21Value& value) const {
    if (value.reference != 0 && !entities_.contains(value.reference))
      throw std::runtime_error("no entity #" + std::to_string(value.reference));
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
  std::string word() {
    skip();
    const std::size_t begin = at_;
    while (std::isalnum(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '_') ++at_;
    return text_.substr(begin, at_ - begin);
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
      result.text = text_.substr(at_, end + 1 - at_);
      at_ = end + 1;
    } else {
      while (text_[at_] != ',' && text_[at_] != ')' && text_[at_] != '(')
        result.text += text_[at_++];
      if (text_[at_] == '(') result.items = list();
    }
    return result;
  }

  std::string text_;
  std::size_t at_ = 0;
  std::map<std::int64_t, Part21Entity> entities_;
};

/// B-spline by de Boor's recursion, of any degree and knots.
struct KnotLine {
  int degree = 2;
  std::vector<double> knots;  ///< with multiplicity

  [[nodiscard]] double low() const { return knots.front(); }
  [[nodiscard]] double high() const { return knots.back(); }
  template <class Point>
  [[nodiscard]] Point at(const std::vector<Point>& points, double t) const {
    auto span = static_cast<std::size_t>(degree);
    while (span + 1 < points.size() && t >= knots[span + 1]) ++span;
    const auto p = static_cast<std::size_t>(degree);
    std::vector<Point> d(points.begin() + static_cast<std::ptrdiff_t>(span - p),
                         points.begin() + static_cast<std::ptrdiff_t>(span + 1));
    for (std::size_t r = 1; r <= p; ++r) {
      for (std::size_t j = p; j >= r; --j) {
        const double a = knots[j + span - p], b = knots[j + 1 + span - r];
        const double w = (t - a) / (b - a);
        d[j] = (1 - w) * d[j - 1] + w * d[j];
      }
    }
    return d[p];
  }
};

}  // namespace planish::test
