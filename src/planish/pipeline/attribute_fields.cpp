#include "planish/pipeline/attribute_fields.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/lower_case.h"
#include "planish/core/parallel.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

bool is_same_name(const std::string& a, const std::string& b) {
  return lower_case(a) == lower_case(b);
}

void require_memory_of(std::uint64_t count, std::int64_t rows) {
  const std::uint64_t needed = sizeof(float) * count * static_cast<std::uint64_t>(rows),
                      free = available_memory_bytes();
  if (needed > free)
    throw Error(ErrorCode::OutOfMemory, formatted("{} numbers of vertices at {} rows need {} MiB "
                                                  "of memory where {} are free; take a lower level",
                                                  count, rows, needed >> 20, free >> 20));
}

constexpr int kWidestField = 4;  // glTF's VEC4

VertexAttribute column_of(const VertexAttribute& of, int column) {
  VertexAttribute made = attribute_of_size(formatted("{}_{}", of.name, column), 1, of.count());
  for (std::size_t i = 0; i < made.values.size(); ++i)
    made.values[i] =
        of.values[static_cast<std::size_t>(of.width) * i + static_cast<std::size_t>(column)];
  return made;
}

}  // namespace

std::vector<float> rows_of_vertices(std::span<const float> given, int width,
                                    const FittedMesh& fitted, const SurfaceBlocks& surface) {
  const auto numbers = static_cast<std::size_t>(width);
  std::vector<glm::vec4> vertices(fitted.mesh.positions.size(), glm::vec4(0.0f));
  const std::size_t own = vertices.size() - fitted.added_vertices.size();
  for (std::size_t v = 0; v < own; ++v) {
    const std::size_t source =
        fitted.source_vertices.empty() ? v : static_cast<std::size_t>(fitted.source_vertices[v]);
    for (std::size_t k = 0; k < numbers; ++k)
      vertices[v][static_cast<int>(k)] = given[numbers * source + k];
  }
  for (std::size_t v = own; v < vertices.size(); ++v) {
    const AddedVertex& added = fitted.added_vertices[v - own];
    for (int k = 0; k < 3; ++k)
      vertices[v] += static_cast<float>(added.weights[k]) * vertices[added.vertices[k]];
  }
  std::vector<glm::vec4> made(static_cast<std::size_t>(surface.info().row_count));
  (void)surface.rows_of(vertices, made);
  std::vector<float> values(numbers * made.size());
  for (std::size_t i = 0; i < made.size(); ++i)
    for (std::size_t k = 0; k < numbers; ++k)
      values[numbers * i + k] = made[i][static_cast<int>(k)];
  return values;
}

std::vector<VertexAttribute> add_attributes(const SurfaceBlocks& surface,
                                            std::vector<NamedField>& fields,
                                            const Callbacks& callbacks) {
  const std::vector<AttributeName>& given = surface.info().attributes;
  std::vector<std::size_t> wanted;
  std::uint64_t numbers = 0;
  std::string left_out;
  for (std::size_t k = 0; k < given.size(); ++k) {
    const bool is_taken = std::ranges::any_of(
        fields, [&](const NamedField& field) { return is_same_name(field.name, given[k].name); });
    if (is_taken) {
      left_out += (left_out.empty() ? "" : ", ") + given[k].name;
    } else {
      wanted.push_back(k);
      numbers += static_cast<std::uint64_t>(given[k].width);
    }
  }
  if (!left_out.empty())
    callbacks.warn({"left-out-properties",
                    "properties of the vertices are left out: " + left_out +
                        "; fields of the surface have these names",
                    static_cast<std::int64_t>(given.size() - wanted.size())});
  require_memory_of(numbers, surface.info().row_count);
  std::vector<VertexAttribute> made;
  for (const std::size_t k : wanted) {
    VertexAttribute all = all_rows(surface, k);
    if (all.width <= kWidestField) {
      made.push_back(std::move(all));
    } else {
      for (int column = 0; column < all.width; ++column) made.push_back(column_of(all, column));
    }
  }
  for (const VertexAttribute& attribute : made)
    fields.push_back({attribute.name, attribute.values, attribute.width});
  return made;
}

}  // namespace planish
