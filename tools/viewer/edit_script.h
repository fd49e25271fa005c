#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "save_edit.h"

namespace planish::viewer {

namespace steps {

struct Pick {
  glm::vec2 pixel;
  bool adds = false;
};
struct Select {
  std::vector<std::int32_t> vertices;
};
struct Radius {
  double length = 0;
};
struct Move {
  glm::dvec3 way{};
  int frames = 1;
};
struct Drag {
  glm::vec2 from, to;
  int frames = 1;
};
struct Crease {
  std::int32_t v0 = 0, v1 = 0;
};
struct CreaseAt {
  glm::vec2 pixel;
};
struct Corner {
  std::int32_t vertex = 0;
};
struct Undo {
  int count = 1;
};
struct Redo {
  int count = 1;
};
struct Frames {
  int count = 1;
};
struct Picture {
  std::string path;
};
struct Save {
  SavedPart part = SavedPart::Mesh;
  std::string path;
};

}  // namespace steps

/// One line of a script.
struct ScriptStep {
  std::string where;  ///< file and line
  std::variant<steps::Pick, steps::Select, steps::Radius, steps::Move, steps::Drag, steps::Crease,
               steps::CreaseAt, steps::Corner, steps::Undo, steps::Redo, steps::Frames,
               steps::Picture, steps::Save>
      what;
};

/// The steps of a script: one a line; what follows # is left out. `name` stands in messages. Throws
/// Error{InvalidArgument}: `name:line: what is wanted, what stands there`.
[[nodiscard]] std::vector<ScriptStep> parse_script(std::string_view text, const std::string& name);
/// The same of a file. Throws Error{UnreadableInput}, too.
[[nodiscard]] std::vector<ScriptStep> read_script(const std::string& path);

}  // namespace planish::viewer
