// Based on: Pineda, "A parallel algorithm for polygon rasterization", 1988.
#include "planish/job/page/rasterise.h"

#include <algorithm>
#include <cmath>

namespace planish::render {

namespace {

struct Span {
  int first, last;
};

// Where a row crosses a triangle, and a sample more on both sides: of slivers little of their box.
Span span_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double y, Span box) {
  const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  double least = box.first, most = box.last;
  const auto cut = [&](const glm::dvec3& from, const glm::dvec3& to) {
    // Left of the edge, where the triangle's inside is: slope * x >= bound.
    const double slope = -(to.y - from.y) * area;
    const double bound = slope * from.x - (to.x - from.x) * area * (y - from.y);
    if (slope == 0) return;
    const double x = bound / slope - 0.5;
    if (slope > 0) {
      least = std::max(least, std::floor(x) - 1);
    } else {
      most = std::min(most, std::ceil(x) + 1);
    }
  };
  cut(a, b);
  cut(b, c);
  cut(c, a);
  if (!(least <= most)) return {0, -1};
  return {static_cast<int>(least), static_cast<int>(most)};
}

}  // namespace

void rasterise(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> indices,
               int row_begin, int row_end, VisibilityBuffer& buffer) {
  for (std::size_t t = 0; t + 2 < indices.size(); t += 3) {
    const glm::vec3 &a = vertices[indices[t]], &b = vertices[indices[t + 1]],
                    &c = vertices[indices[t + 2]];
    const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) continue;
    // Samples lie at the middle of their square.
    const int x0 = std::max(0, static_cast<int>(std::ceil(std::min({a.x, b.x, c.x}) - 0.5f)));
    const int x1 =
        std::min(buffer.width - 1, static_cast<int>(std::floor(std::max({a.x, b.x, c.x}) - 0.5f)));
    const int y0 =
        std::max(row_begin, static_cast<int>(std::ceil(std::min({a.y, b.y, c.y}) - 0.5f)));
    const int y1 =
        std::min(row_end - 1, static_cast<int>(std::floor(std::max({a.y, b.y, c.y}) - 0.5f)));
    const float scale = 1 / area;
    for (int y = y0; y <= y1; ++y) {
      const float py = static_cast<float>(y) + 0.5f;
      const auto [first, last] = span_of(a, b, c, py, {x0, x1});
      for (int x = first; x <= last; ++x) {
        const float px = static_cast<float>(x) + 0.5f;
        const float v = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) * scale;
        const float w = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) * scale;
        if (v < 0 || w < 0 || v + w > 1) continue;
        const float nearness = a.z + v * (b.z - a.z) + w * (c.z - a.z);
        const std::size_t sample = buffer.at(x, y);
        if (nearness <= buffer.nearness[sample]) continue;
        buffer.nearness[sample] = nearness;
        buffer.what[sample] = static_cast<std::uint32_t>(t / 3);
      }
    }
  }
}

}  // namespace planish::render
