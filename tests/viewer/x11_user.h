#pragma once

#include <memory>
#include <string>

struct GLFWwindow;

namespace planish::testing {

/// What a user's mouse and keys send to a window of an X server.
class X11User {
 public:
  explicit X11User(GLFWwindow* window);
  ~X11User();
  X11User(const X11User&) = delete;
  X11User& operator=(const X11User&) = delete;

  void point_at(int x, int y);
  void left_button(bool is_down);
  /// By X's name of it: "s", "Control_L".
  void key(const std::string& name, bool is_down);

 private:
  struct Connection;
  std::unique_ptr<Connection> connection_;
};

}  // namespace planish::testing
