#include "planish/pipeline/vertex_properties.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

bool is_same_name(const std::string& a, const std::string& b) {
  return std::ranges::equal(
      a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

bool knows_its_mesh(const SurfaceBlocks& surface, const FittedMesh& fitted) {
  const std::vector<glm::vec4> nothing(fitted.mesh.positions.size());
  std::array<glm::vec4, 1> one;
  return surface.info().row_count > 0 && surface.rows_of(nothing, {0, 1}, one);
}

void require_memory_of(std::size_t count, std::int64_t rows) {
  const std::uint64_t needed =
                          std::uint64_t{sizeof(float)} * count * static_cast<std::uint64_t>(rows),
                      free = available_memory_bytes();
  if (needed > free)
    throw Error(ErrorCode::OutOfMemory,
                std::to_string(count) + " properties of vertices at " + std::to_string(rows) +
                    " rows need " + std::to_string(needed >> 20) + " MiB of memory where " +
                    std::to_string(free >> 20) + " are free; take a lower level");
}

}  // namespace

std::vector<float> rows_of_vertices(std::span<const float> given, int width,
                                    const FittedMesh& fitted, const SurfaceBlocks& surface) {
  constexpr std::int64_t kRows = std::int64_t{1} << 14;
  const auto numbers = static_cast<std::size_t>(width);
  std::vector<glm::vec4> vertices(fitted.mesh.positions.size(), glm::vec4(0.0f));
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const std::size_t source =
        fitted.source_vertices.empty() ? v : static_cast<std::size_t>(fitted.source_vertices[v]);
    for (std::size_t k = 0; k < numbers; ++k)
      vertices[v][static_cast<int>(k)] = given[numbers * source + k];
  }
  std::vector<float> values(numbers * static_cast<std::size_t>(surface.info().row_count));
  const std::vector<RowRange> ranges = surface.row_blocks(kRows);
  parallel_for(ranges.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<glm::vec4> made;
    for (std::size_t r = begin; r < end; ++r) {
      made.resize(static_cast<std::size_t>(ranges[r].count));
      (void)surface.rows_of(vertices, ranges[r], made);
      for (std::size_t i = 0; i < made.size(); ++i)
        for (std::size_t k = 0; k < numbers; ++k)
          values[numbers * (static_cast<std::size_t>(ranges[r].first) + i) + k] =
              made[i][static_cast<int>(k)];
    }
  });
  return values;
}

std::vector<VertexProperty> add_properties(std::span<const VertexProperty> given,
                                           const FittedMesh& fitted, const SurfaceBlocks& surface,
                                           std::vector<NamedField>& fields,
                                           const Callbacks& callbacks) {
  std::vector<VertexProperty> made;
  if (given.empty()) return made;
  const bool has_rows = knows_its_mesh(surface, fitted);
  std::vector<const VertexProperty*> wanted;
  std::string left_out;
  for (const VertexProperty& property : given) {
    const bool is_taken = std::ranges::any_of(
        fields, [&](const NamedField& field) { return is_same_name(field.name, property.name); });
    if (has_rows && !is_taken) {
      wanted.push_back(&property);
    } else {
      left_out += (left_out.empty() ? "" : ", ") + property.name;
    }
  }
  if (!left_out.empty())
    callbacks.warn({"left-out-properties",
                    "properties of the vertices are left out: " + left_out +
                        (has_rows ? "; fields of the surface have these names"
                                  : "; they need levels of Doo-Sabin surfaces"),
                    static_cast<std::int64_t>(given.size() - wanted.size())});
  require_memory_of(wanted.size(), surface.info().row_count);
  for (const VertexProperty* property : wanted)
    made.push_back({property->name, rows_of_vertices(property->values, 1, fitted, surface)});
  for (const VertexProperty& property : made) fields.push_back({property.name, property.values});
  return made;
}

}  // namespace planish
