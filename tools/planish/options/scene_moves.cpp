#include "options/scene_moves.h"

#include "options/scene_settings.h"
#include "planish/core/json.h"
#include "planish/core/refuse.h"

namespace planish::command {
namespace {

// So many numbers: a point, or a row of a matrix.
std::vector<double> numbers_of(const Json& json, const std::string& where, std::size_t count) {
  if (!json.is_array() || json.size() != count) refuse(where, "{} numbers are wanted", count);
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i)
    numbers.push_back(number_of(json[i], entry_path(where, i)));
  return numbers;
}

glm::dvec3 point_of(const Json& json, const std::string& where) {
  const std::vector<double> numbers = numbers_of(json, where, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

glm::dmat4 affine_map(const Json& json, const std::string& where) {
  if (!json.is_array() || json.size() != 3)
    refuse(where, "three rows of four numbers are wanted, the fourth of each what is added");
  glm::dmat4 map(1.0);
  for (int r = 0; r < 3; ++r) {
    const auto row = static_cast<std::size_t>(r);
    const std::vector<double> numbers = numbers_of(json[row], entry_path(where, row), 4);
    for (int c = 0; c < 4; ++c) map[c][r] = numbers[c];
  }
  return map;
}

SceneMove move_of(const Json& json, const std::string& where) {
  check_keys(json, SceneObject::Move, where);
  const auto path = [&](const char* key) { return key_path(where, key); };
  SceneMove move;
  move.where = where;
  if (json.contains("undo")) {
    if (json.size() > 1) refuse(where, "\"undo\" stands by itself");
    move.undo = count_of(json["undo"], path("undo"), 1, INT32_MAX);
    return move;
  }
  if (!json.contains("vertices")) refuse(where, "has no \"vertices\"");
  for_entries(
      json["vertices"], path("vertices"), [&](const Json& vertex, const std::string& entry) {
        move.vertices.push_back(static_cast<std::int32_t>(count_of(vertex, entry, 0, INT32_MAX)));
      });
  if (json.contains("to") + json.contains("by") + json.contains("matrix") != 1)
    refuse(where, "one of \"to\", \"by\" and \"matrix\" is wanted");
  if (json.contains("to")) {
    if (json.contains("radius"))
      refuse(path("radius"), "goes with \"by\" or \"matrix\", which say where others move to");
    for_entries(json["to"], path("to"), [&](const Json& point, const std::string& entry) {
      move.to.push_back(point_of(point, entry));
    });
    if (move.to.size() != move.vertices.size())
      refuse(path("to"), "{} positions stand there, and {} vertices", move.to.size(),
             move.vertices.size());
  }
  if (json.contains("by")) move.map[3] = glm::dvec4(point_of(json["by"], path("by")), 1.0);
  if (json.contains("matrix")) move.map = affine_map(json["matrix"], path("matrix"));
  if (json.contains("radius")) {
    move.radius = number_of(json["radius"], path("radius"));
    if (!(move.radius > 0)) refuse(path("radius"), "a length above 0 is wanted");
  }
  return move;
}

}  // namespace

std::vector<SceneMove> moves_of(const Json& json, const std::string& where) {
  if (json.is_array() && json.empty()) refuse(where, "is empty");
  std::vector<SceneMove> moves;
  for_entries(json, where, [&](const Json& move, const std::string& entry) {
    moves.push_back(move_of(move, entry));
  });
  return moves;
}

}  // namespace planish::command
