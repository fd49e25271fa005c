#include <cmath>
#include <future>
#include <string>
#include <vector>

#include "fuzz/fuzz_command.h"
#include "fuzz/fuzz_read.h"
#include "inspect_command.h"
#include "limit/limit_case.h"
#include "planish/core/json.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/job/job_text.h"
#include "query_command.h"

namespace planish::test {

namespace {

// A small surface to ask, with a sharp edge and borders, and places on it.
struct Asked {
  LimitCase surface{interpolating_cage(with_random_creases(open_fan(5), 0.3, 1))};
  SurfaceQueries queries{surface.limit};
  RawVector<glm::dvec3> places = surface.tessellated(3).positions;
};

const Asked& asked() {
  static const Asked surface;
  return surface;
}

// Rounding, of a distance that large.
double slack(double distance) { return 1e-9 * (1 + distance); }

void require_on_surface(const command::QueryAnswer& answer) {
  const SurfacePoint there = asked().surface.limit.evaluate(answer.at);
  require(safe_length(there.position - answer.position) <= slack(0));
  require(std::abs(safe_length(answer.normal) - 1) <= slack(0));
}

// No place of the surface is nearer.
void require_closest(const glm::dvec3& point, const command::QueryAnswer& answer) {
  require_on_surface(answer);
  const double distance = answer.distance;
  require(std::abs(safe_length(point - answer.position) - distance) <= slack(distance));
  for (const glm::dvec3& place : asked().places)
    require(distance <= safe_length(point - place) + slack(distance));
}

void require_hit(const glm::dvec3& origin, const glm::dvec3& direction,
                 const command::QueryAnswer& answer) {
  if (answer.at.face < 0) return;
  require_on_surface(answer);
  require(answer.distance >= 0 && std::isfinite(answer.distance));
  const glm::dvec3 reached = origin + answer.distance * direction;
  require(safe_length(reached - answer.position) <= slack(safe_length(origin)));
}

using Answers = std::vector<command::QueryAnswer>;

Answers answers_to(std::span<const glm::dvec3> points, const std::string& rays) {
  Answers answers(points.size());
  if (rays.empty()) {
    command::answer_closest(asked().queries, points, true, answers);
    for (std::size_t i = 0; i < points.size(); ++i) require_closest(points[i], answers[i]);
  } else {
    const glm::dvec3 direction = command::parse_direction(rays);
    command::answer_rays(asked().queries, direction, points, answers);
    for (std::size_t i = 0; i < points.size(); ++i) require_hit(points[i], direction, answers[i]);
  }
  return answers;
}

// JSON and PLY have an answer for each point, and the PLY can be asked again.
void require_written(std::span<const glm::dvec3> points, const Answers& given, bool are_rays) {
  const char* const distance = are_rays ? "t" : "distance";
  const command::Answer answer = [&](std::span<const glm::dvec3>,
                                     std::span<command::QueryAnswer> answers) {
    std::ranges::copy(given, answers.begin());
  };
  std::string text;
  const command::TakeBytes take = [&](std::string_view bytes) { text += bytes; };
  command::answers_json(nlohmann::ordered_json::object(), "closest", points, answer, distance,
                        take);
  const nlohmann::json json = nlohmann::json::parse(text)["closest"];
  require(json.size() == points.size());
  for (const nlohmann::json& entry : json)
    require(entry.is_null() ? are_rays : entry[distance].is_number());
  text.clear();
  command::answers_ply(points, answer, distance, take);
  const PointCloud cloud = read_points(std::as_bytes(std::span(text)), "answers", FileFormat::Ply);
  require(cloud.points.size() == points.size() && cloud.missing_count == 0);
}

}  // namespace

void fuzz_query(std::span<const std::byte> bytes, FileFormat format) {
  constexpr std::size_t kMostPoints = 32;
  const std::string_view text = text_of(bytes);
  const std::string rays(text.substr(0, text.find('\n')));
  try {
    const auto file = bytes.subspan(std::min(rays.size() + 1, bytes.size()));
    std::vector<glm::dvec3> points =
        command::questions_of(read_points(file, "fuzz", format), "fuzz");
    points.resize(std::min(points.size(), kMostPoints));
    require_written(points, answers_to(points, rays), !rays.empty());
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::UnreadableInput, ErrorCode::InvalidArgument});
  }
}

void fuzz_inspect(std::span<const std::byte> bytes, FileFormat) {
  const std::optional<FileFormat> format = sniff_format(bytes);
  if (!format) return;
  InputFile file;
  file.name = "fuzz";
  file.bytes.assign(bytes.begin(), bytes.end());
  file.format = *format;
  file.digest = std::async(std::launch::deferred, [] { return std::string("none"); });
  try {
    const command::Inspection inspection = command::inspect(file);
    const std::string text = command::inspection_text(inspection);
    require(visible_lines(text) == text);
    require(std::isfinite(inspection.diagonal) && std::isfinite(inspection.spacing));
    const nlohmann::json json =
        nlohmann::json::parse(json_text(command::inspection_json(inspection)));
    require(json["format"] == name_of(inspection.format));
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::UnreadableInput});
  }
}

}  // namespace planish::test
