#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>

#include "camera.h"
#include "edit_session.h"

namespace planish::viewer {

/// What the mouse does to a session, in a window and by a script alike. Places are in parts of the
/// picture, (0, 0) its upper left, (1, 1) its lower right.
class EditHand {
 public:
  explicit EditHand(EditSession& session) : session_(session) {}

  /// The vertex under the place: of the face that is seen there, or, beside the surface, one whose
  /// handle is less than 1.5 % of the height away.
  [[nodiscard]] std::optional<std::int32_t> vertex_at(const OrbitCamera& camera, float aspect,
                                                      const glm::vec2& place);
  /// Takes hold of the vertex there, so that drag() moves it with the place; it becomes the
  /// selection unless it belongs to it. `adds`: it joins the selection, or leaves it, and is not
  /// held. Returns it.
  std::optional<std::int32_t> press(const OrbitCamera& camera, float aspect, const glm::vec2& place,
                                    bool adds);
  [[nodiscard]] bool is_holding() const { return held_.has_value(); }
  /// The held vertex goes to that place, at its distance along the view; the selection goes along.
  void drag(const OrbitCamera& camera, float aspect, const glm::vec2& place);
  void release();
  /// Toggles the edge under the place; false where there is none.
  bool toggle_crease(const OrbitCamera& camera, float aspect, const glm::vec2& place);

 private:
  struct Held {
    glm::dvec3 start;  // of the vertex
    glm::vec2 from;    // the place that was pressed
    glm::vec2 handle;  // the vertex's place then
    bool has_moved = false;
  };
  EditSession& session_;
  std::optional<Held> held_;
};

}  // namespace planish::viewer
