#include "planish/mesh/vertex_attribute.h"

#include <cctype>
#include <cmath>
#include <set>

#include "planish/core/error.h"
#include "planish/core/first_where.h"
#include "planish/core/lower_case.h"
#include "planish/core/number_text.h"
#include "planish/core/visible_text.h"

namespace planish {
namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw Error(ErrorCode::InvalidArgument, formatted("attribute \"{}\": {}", visible(name), what));
}

bool is_name(const std::string& name) {
  const auto is_of_name = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  return !name.empty() && std::ranges::all_of(name, is_of_name) &&
         std::isdigit(static_cast<unsigned char>(name[0])) == 0;
}

}  // namespace

VertexAttribute attribute_of_size(const std::string& name, int width, std::size_t count) {
  return {name, std::vector<float>(static_cast<std::size_t>(width) * count), width};
}

std::uint64_t numbers_of(std::span<const VertexAttribute> attributes) {
  std::uint64_t sum = 0;
  for (const VertexAttribute& attribute : attributes)
    sum += static_cast<std::uint64_t>(attribute.width);
  return sum;
}

void VertexAttribute::set_run(std::size_t vertex, const NumberRun& run, const glm::vec4& four) {
  const std::size_t first =
      static_cast<std::size_t>(width) * vertex + static_cast<std::size_t>(run.column);
  for (int k = 0; k < run.count; ++k)
    values[first + static_cast<std::size_t>(k)] = four[run.lane + k];
}

std::vector<NumberRun> runs_of(std::span<const VertexAttribute> attributes, std::size_t index) {
  // Where an attribute would not fit into a four that is begun, the next one begins.
  std::size_t before = 0;
  const auto begin = [&](const VertexAttribute& attribute) {
    if (before % 4 + static_cast<std::size_t>(attribute.width) > 4) before += (4 - before % 4) % 4;
  };
  for (const VertexAttribute& attribute : attributes.first(index)) {
    begin(attribute);
    before += static_cast<std::size_t>(attribute.width);
  }
  begin(attributes[index]);
  const int width = attributes[index].width;
  std::vector<NumberRun> runs;
  for (int column = 0; column < width;) {
    const std::size_t number = before + static_cast<std::size_t>(column);
    const int lane = static_cast<int>(number % 4), count = std::min(4 - lane, width - column);
    runs.push_back({number / 4, lane, column, count});
    column += count;
  }
  return runs;
}

std::vector<glm::vec4> four_of(std::span<const VertexAttribute> attributes, std::size_t four) {
  const std::size_t count = attributes.empty() ? 0 : attributes.front().count();
  std::vector<glm::vec4> values(count, glm::vec4(0.0f));
  for (std::size_t index = 0; index < attributes.size(); ++index) {
    const VertexAttribute& from = attributes[index];
    for (const NumberRun& run : runs_of(attributes, index)) {
      if (run.four != four) continue;
      for (std::size_t v = 0; v < count; ++v)
        for (int k = 0; k < run.count; ++k)
          values[v][run.lane + k] = from.values[static_cast<std::size_t>(from.width) * v +
                                                static_cast<std::size_t>(run.column + k)];
    }
  }
  return values;
}

std::vector<VertexAttribute> attributes_of(std::span<const VertexAttribute> given,
                                           std::span<const std::int32_t> vertices) {
  std::vector<VertexAttribute> result;
  for (const VertexAttribute& from : given) {
    VertexAttribute& to =
        result.emplace_back(attribute_of_size(from.name, from.width, vertices.size()));
    for (std::size_t i = 0; i < vertices.size(); ++i)
      std::copy_n(from.values.begin() + std::ptrdiff_t{from.width} * vertices[i], from.width,
                  to.values.begin() + static_cast<std::ptrdiff_t>(i) * from.width);
  }
  return result;
}

void require_attributes(std::span<const VertexAttribute> attributes) {
  std::set<std::string> names;
  for (const VertexAttribute& attribute : attributes) {
    const std::string& name = attribute.name;
    if (!is_name(name))
      refuse(name, "is no name that files hold; letters, digits and '_' are, no digit first");
    if (!names.insert(lower_case(name)).second)
      refuse(name, "is there twice; names differ by more than case");
    const std::vector<float>& values = attribute.values;
    const std::size_t wild =
        first_where(values.size(), [&](std::size_t i) { return !std::isfinite(values[i]); });
    if (wild < values.size())
      refuse(name,
             formatted("of vertex {} is {}; finite numbers are wanted",
                       wild / static_cast<std::size_t>(attribute.width), shortest(values[wild])));
  }
}

}  // namespace planish
