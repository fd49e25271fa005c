#include "output/answers_ply.h"

#include <bit>
#include <type_traits>

namespace planish::command {
namespace {

template <class Number>
void append(std::string& text, Number number) {
  using Bits = std::conditional_t<sizeof(Number) == 8, std::uint64_t, std::uint32_t>;
  const Bits bits = std::bit_cast<Bits>(number);
  for (std::size_t i = 0; i < sizeof(Number); ++i)
    text.push_back(static_cast<char>(bits >> (8 * i) & 0xff));
}

}  // namespace

std::string answers_ply(std::span<const PlyAnswer> answers, std::string_view distance_name) {
  std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                     std::to_string(answers.size()) + "\n";
  for (const char* const name : {"x", "y", "z"})
    text += "property double " + std::string(name) + "\n";
  for (const char* const name : {"nx", "ny", "nz"})
    text += "property float " + std::string(name) + "\n";
  text += "property double " + std::string(distance_name) +
          "\nproperty int face\nproperty double u\nproperty double v\nend_header\n";
  for (const PlyAnswer& answer : answers) {
    for (int d = 0; d < 3; ++d) append(text, answer.position[d]);
    for (int d = 0; d < 3; ++d) append(text, static_cast<float>(answer.normal[d]));
    append(text, answer.distance);
    append(text, answer.face);
    append(text, answer.u);
    append(text, answer.v);
  }
  return text;
}

}  // namespace planish::command
