// Alone in its compilation: Xlib's macros have names of everybody's.
#include "viewer/x11_user.h"

#include <GLFW/glfw3.h>
#include <X11/Xlib.h>

// As in GLFW/glfw3native.h, which includes headers of extensions that nobody needs here.
extern "C" ::Window glfwGetX11Window(GLFWwindow* window);

namespace planish::testing {

struct X11User::Connection {
  ::Window to;
  Display* display;

  void send(XEvent& event, long mask) const {
    event.xany.window = to;
    event.xany.display = display;
    XSendEvent(display, to, False, mask, &event);
    XSync(display, False);
  }
};

X11User::X11User(GLFWwindow* window)
    : connection_(std::make_unique<Connection>(
          Connection{glfwGetX11Window(window), XOpenDisplay(nullptr)})) {}

X11User::~X11User() { XCloseDisplay(connection_->display); }

// Not by glfwSetCursorPos(), of which GLFW tells no callback: Dear ImGui from 1.87 on sees only
// these.
void X11User::point_at(int x, int y) {
  XWarpPointer(connection_->display, None, connection_->to, 0, 0, 0, 0, x, y);
  XSync(connection_->display, False);
}

void X11User::left_button(bool is_down) {
  XEvent event{};
  event.xbutton.type = is_down ? ButtonPress : ButtonRelease;
  event.xbutton.button = Button1;
  connection_->send(event, is_down ? ButtonPressMask : ButtonReleaseMask);
}

void X11User::key(const std::string& name, bool is_down) {
  XEvent event{};
  event.xkey.type = is_down ? KeyPress : KeyRelease;
  event.xkey.keycode = XKeysymToKeycode(connection_->display, XStringToKeysym(name.c_str()));
  connection_->send(event, is_down ? KeyPressMask : KeyReleaseMask);
}

}  // namespace planish::testing
