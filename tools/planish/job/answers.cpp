#include "job/answers.h"

#include <algorithm>
#include <bit>
#include <type_traits>
#include <vector>

#include "planish/core/formatted.h"
#include "planish/core/json.h"
#include "planish/core/parallel.h"
#include "planish/job/report_json.h"

namespace planish::command {
namespace {

constexpr std::size_t kAnswersAtOnce = 8192;
constexpr std::size_t kTextGrain = 256;  // answers that a thread writes out at once

template <class Number>
void append(std::string& text, Number number) {
  using Bits = std::conditional_t<sizeof(Number) == 8, std::uint64_t, std::uint32_t>;
  const Bits bits = std::bit_cast<Bits>(number);
  for (std::size_t i = 0; i < sizeof(Number); ++i)
    text.push_back(static_cast<char>(bits >> (8 * i) & 0xff));
}

void append_ply(std::string& text, const QueryAnswer& answer) {
  for (int d = 0; d < 3; ++d) append(text, answer.position[d]);
  for (int d = 0; d < 3; ++d) append(text, static_cast<float>(answer.normal[d]));
  append(text, answer.distance);
  append(text, answer.at.face);
  append(text, answer.at.u);
  append(text, answer.at.v);
}

nlohmann::ordered_json point_json(const glm::dvec3& p) { return {p.x, p.y, p.z}; }

nlohmann::ordered_json answer_json(const QueryAnswer& answer, std::string_view distance_name) {
  if (answer.at.face < 0) return nullptr;
  nlohmann::ordered_json json;
  json[std::string(distance_name)] = answer.distance;
  json["position"] = point_json(answer.position);
  json["normal"] = point_json(answer.normal);
  json["at"] = {{"face", answer.at.face}, {"u", answer.at.u}, {"v", answer.at.v}};
  if (distance_name == "t") return json;
  const PointCurvature& curvature = answer.curvature;
  json["mean_curvature"] = curvature.is_known ? nlohmann::ordered_json(curvature.mean) : nullptr;
  json["gaussian_curvature"] =
      curvature.is_known ? nlohmann::ordered_json(curvature.gaussian) : nullptr;
  return json;
}

// As an entry of a list in an object, with the line's end before it.
void append_json(std::string& text, const nlohmann::ordered_json& json) {
  text += "\n    ";
  for (const char c : json.dump(2)) {
    text += c;
    if (c == '\n') text += "    ";
  }
}

// Some answers at a time; write(text, answer) makes the text of one, on any thread.
template <class Write>
void for_answers(std::span<const glm::dvec3> points, const Answer& answer, const Write& write,
                 const TakeBytes& take) {
  std::vector<QueryAnswer> answers;
  std::vector<std::string> texts;
  for (std::size_t first = 0; first < points.size(); first += kAnswersAtOnce) {
    const auto some = points.subspan(first, std::min(kAnswersAtOnce, points.size() - first));
    answers.assign(some.size(), {});
    answer(some, answers);
    texts.resize((some.size() + kTextGrain - 1) / kTextGrain);
    parallel_each(texts.size(), 1, [&](std::size_t t) {
      texts[t].clear();
      const std::size_t last = std::min(some.size(), (t + 1) * kTextGrain);
      for (std::size_t i = t * kTextGrain; i < last; ++i) write(texts[t], answers[i], first + i);
    });
    for (const std::string& text : texts) take(text);
  }
}

}  // namespace

void answers_ply(std::span<const glm::dvec3> points, const Answer& answer,
                 std::string_view distance_name, const TakeBytes& take) {
  std::string text =
      formatted("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", points.size());
  for (const char* const name : {"x", "y", "z"})
    text += "property double " + std::string(name) + "\n";
  for (const char* const name : {"nx", "ny", "nz"})
    text += "property float " + std::string(name) + "\n";
  text += "property double " + std::string(distance_name) +
          "\nproperty int face\nproperty double u\nproperty double v\nend_header\n";
  take(text);
  for_answers(
      points, answer,
      [](std::string& bytes, const QueryAnswer& of, std::size_t) { append_ply(bytes, of); }, take);
}

void answers_json(const nlohmann::ordered_json& head, std::string_view list,
                  std::span<const glm::dvec3> points, const Answer& answer,
                  std::string_view distance_name, const TakeBytes& take) {
  nlohmann::ordered_json whole = head;
  whole[std::string(list)] = nlohmann::ordered_json::array();
  const std::string text = json_text(whole);
  constexpr std::string_view kEnd = "]\n}\n";
  take(std::string_view(text).substr(0, text.size() - kEnd.size()));
  for_answers(
      points, answer,
      [&](std::string& json, const QueryAnswer& of, std::size_t index) {
        if (index > 0) json += ',';
        append_json(json, answer_json(of, distance_name));
      },
      take);
  if (!points.empty()) take("\n  ");
  take(kEnd);
}

}  // namespace planish::command
