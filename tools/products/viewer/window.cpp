#include "window.h"

#include <GLFW/glfw3.h>
#include <imgui.h>
#include <imgui_impl_glfw.h>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "edit_session.h"
#include "overlay.h"
#include "planish/core/error.h"

namespace planish::viewer {
namespace {

constexpr std::uint32_t kUndefinedExtent = 0xffffffff;  // the surface takes the swapchain's

VkSurfaceFormatKHR pick_format(const Device& device, VkSurfaceKHR surface) {
  std::uint32_t count = 0;
  vulkan::check(vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical(), surface, &count, nullptr),
                "vkGetPhysicalDeviceSurfaceFormatsKHR");
  std::vector<VkSurfaceFormatKHR> formats(count);
  vulkan::check(
      vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical(), surface, &count, formats.data()),
      "vkGetPhysicalDeviceSurfaceFormatsKHR");
  for (const VkFormat wanted : {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM})
    for (const VkSurfaceFormatKHR& format : formats)
      if (format.format == wanted) return format;
  throw Error(ErrorCode::NoDevice, device.name() + " shows no 8-bit format in this window");
}

// The display's pace; but a software device is slower than any display, and virtual displays, on
// which it mostly runs, have a pace of one frame a second.
VkPresentModeKHR present_mode(const Device& device, VkSurfaceKHR surface) {
  if (!device.is_software()) return VK_PRESENT_MODE_FIFO_KHR;
  std::uint32_t count = 0;
  vulkan::check(
      vkGetPhysicalDeviceSurfacePresentModesKHR(device.physical(), surface, &count, nullptr),
      "vkGetPhysicalDeviceSurfacePresentModesKHR");
  std::vector<VkPresentModeKHR> modes(count);
  vulkan::check(
      vkGetPhysicalDeviceSurfacePresentModesKHR(device.physical(), surface, &count, modes.data()),
      "vkGetPhysicalDeviceSurfacePresentModesKHR");
  const bool immediate = std::ranges::find(modes, VK_PRESENT_MODE_IMMEDIATE_KHR) != modes.end();
  return immediate ? VK_PRESENT_MODE_IMMEDIATE_KHR : VK_PRESENT_MODE_FIFO_KHR;
}

}  // namespace

std::optional<VkExtent2D> swapchain_extent(const VkSurfaceCapabilitiesKHR& surface,
                                           VkExtent2D framebuffer) {
  VkExtent2D extent = surface.currentExtent;
  if (extent.width == kUndefinedExtent) {
    if (framebuffer.width == 0 || framebuffer.height == 0) return std::nullopt;
    extent.width =
        std::clamp(framebuffer.width, surface.minImageExtent.width, surface.maxImageExtent.width);
    extent.height = std::clamp(framebuffer.height, surface.minImageExtent.height,
                               surface.maxImageExtent.height);
  }
  if (extent.width == 0 || extent.height == 0) return std::nullopt;
  return extent;
}

VkFormat surface_format(const Device& device, VkSurfaceKHR surface) {
  return pick_format(device, surface).format;
}

Swapchain::Swapchain(const Device& device, VkSurfaceKHR surface, VkRenderPass pass)
    : device_(device), surface_(surface), pass_(pass) {
  const VkSurfaceFormatKHR format = pick_format(device, surface);
  format_ = format.format;
  colour_space_ = format.colorSpace;
}

void Swapchain::resize(VkExtent2D framebuffer) {
  device_.wait_idle();
  targets_.reset();
  views_.clear();
  drawn_.clear();
  VkSurfaceCapabilitiesKHR surface;
  vulkan::check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical(), surface_, &surface),
                "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  const auto extent = swapchain_extent(surface, framebuffer);
  if (!extent) return;
  VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
  info.surface = surface_;
  // One more than the least, so that drawing need not wait for the display.
  info.minImageCount = surface.minImageCount + 1;
  if (surface.maxImageCount > 0)
    info.minImageCount = std::min(info.minImageCount, surface.maxImageCount);
  info.imageFormat = format_;
  info.imageColorSpace = colour_space_;
  info.imageExtent = *extent;
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  info.preTransform = surface.currentTransform;
  info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
  info.presentMode = present_mode(device_, surface_);
  info.clipped = VK_TRUE;
  info.oldSwapchain = swapchain_;
  swapchain_ = OwnedSwapchain(device_, info, "vkCreateSwapchainKHR");

  std::uint32_t count = 0;
  vulkan::check(vkGetSwapchainImagesKHR(device_, swapchain_, &count, nullptr),
                "vkGetSwapchainImagesKHR");
  std::vector<VkImage> images(count);
  vulkan::check(vkGetSwapchainImagesKHR(device_, swapchain_, &count, images.data()),
                "vkGetSwapchainImagesKHR");
  const VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
  for (const VkImage image : images) {
    views_.push_back(make_view(device_, image, format_, VK_IMAGE_ASPECT_COLOR_BIT));
    drawn_.emplace_back(device_, semaphore, "vkCreateSemaphore");
  }
  const std::vector<VkImageView> views(views_.begin(), views_.end());
  targets_.emplace(device_, pass_, format_, *extent, views);
}

std::optional<std::uint32_t> Swapchain::acquire(VkSemaphore ready) {
  std::uint32_t image = 0;
  const VkResult result =
      vkAcquireNextImageKHR(device_, swapchain_, UINT64_MAX, ready, VK_NULL_HANDLE, &image);
  if (result == VK_ERROR_OUT_OF_DATE_KHR) return std::nullopt;
  // A suboptimal image is there and has to be presented; present() tells then.
  if (result != VK_SUBOPTIMAL_KHR) vulkan::check(result, "vkAcquireNextImageKHR");
  return image;
}

bool Swapchain::present(std::uint32_t image) {
  VkPresentInfoKHR info{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
  info.waitSemaphoreCount = 1;
  info.pWaitSemaphores = drawn_[image].address();
  info.swapchainCount = 1;
  info.pSwapchains = swapchain_.address();
  info.pImageIndices = &image;
  const VkResult result = vkQueuePresentKHR(device_.queue(), &info);
  if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR) return false;
  vulkan::check(result, "vkQueuePresentKHR");
  return true;
}

namespace {

// After Vulkan, so that it declares glfwCreateWindowSurface.

// Of a key as GLFW names it, which Dear ImGui took up to 1.86; now it has names of its own.
bool is_pressed(int key, bool repeats) {
#if IMGUI_VERSION_NUM < 18700
  return ImGui::IsKeyPressed(key, repeats);
#else
  const auto name = [&] {
    if (key >= GLFW_KEY_A && key <= GLFW_KEY_Z)
      return static_cast<ImGuiKey>(ImGuiKey_A + key - GLFW_KEY_A);
    switch (key) {
      case GLFW_KEY_LEFT_BRACKET:
        return ImGuiKey_LeftBracket;
      case GLFW_KEY_RIGHT_BRACKET:
        return ImGuiKey_RightBracket;
      case GLFW_KEY_ESCAPE:
        return ImGuiKey_Escape;
      case GLFW_KEY_SPACE:
        return ImGuiKey_Space;
      default:
        return ImGuiKey_None;
    }
  };
  return ImGui::IsKeyPressed(name(), repeats);
#endif
}

[[noreturn]] void fail(const std::string& what) {
  const char* why = nullptr;
  glfwGetError(&why);
  throw Error(ErrorCode::NoDevice,
              what + (why ? std::string(": ") + why : "") + "; --headless needs no display");
}

struct Glfw {
  Glfw() {
    if (!glfwInit()) fail("no window system");
    if (!glfwVulkanSupported()) fail("no Vulkan in windows");
  }
  ~Glfw() { glfwTerminate(); }
};

struct DestroyWindow {
  void operator()(GLFWwindow* window) const { glfwDestroyWindow(window); }
};
using OwnedWindow = std::unique_ptr<GLFWwindow, DestroyWindow>;

OwnedWindow make_window(const WindowOptions& options, const std::string& title) {
  glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
  OwnedWindow window(
      glfwCreateWindow(options.width, options.height, title.c_str(), nullptr, nullptr));
  if (!window) fail("no window");
  return window;
}

InstanceOptions instance_options(const WindowOptions& options) {
  std::uint32_t count = 0;
  const char** names = glfwGetRequiredInstanceExtensions(&count);
  return {options.validation, options.message, {names, names + count}};
}

// From 1 % of the diagonal on; below that none.
void grow_radius(EditSession& session, float factor) {
  constexpr double kLeast = 0.01, kMost = 1;
  const double part = session.radius() / session.diagonal() * factor;
  if (factor > 1)
    session.set_radius(std::clamp(part, kLeast, kMost) * session.diagonal());
  else
    session.set_radius(part < kLeast ? 0 : part * session.diagonal());
}

// A surface, destroyed before its window and after its device.
struct Surface {
  Surface(const Instance& made_of, GLFWwindow* window) : instance(made_of) {
    if (glfwCreateWindowSurface(instance.handle(), window, nullptr, &handle) != VK_SUCCESS)
      fail("no surface");
  }
  ~Surface() { vkDestroySurfaceKHR(instance.handle(), handle, nullptr); }
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;

  const Instance& instance;
  VkSurfaceKHR handle = VK_NULL_HANDLE;
};

// ImGui's eyes and ears; made after its context.
struct ImguiInput {
  explicit ImguiInput(GLFWwindow* window) { ImGui_ImplGlfw_InitForVulkan(window, true); }
  ~ImguiInput() { ImGui_ImplGlfw_Shutdown(); }
};

class Window {
 public:
  Window(Scene scene, const WindowOptions& options)
      : options_(options),
        window_(make_window(options, "planish: " + scene.name)),
        instance_(instance_options(options)),
        surface_(instance_, window_.get()),
        device_(instance_, {options.device, surface_.handle}),
        pass_(make_render_pass(
            device_, {surface_format(device_, surface_.handle), VK_IMAGE_LAYOUT_PRESENT_SRC_KHR})),
        swapchain_(device_, surface_.handle, pass_),
        overlay_(device_, pass_, 1),
        input_(window_.get()),
        renderer_(device_, pass_, std::move(scene)),
        settings_(options.settings),
        camera_(options.camera),
        edits_(options.edits) {
    const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    for (OwnedSemaphore& ready : image_ready_)
      ready = OwnedSemaphore(device_, info, "vkCreateSemaphore");
    facts_.device = device_.name();
    facts_.tessellates = device_.has_tessellation();
    if (settings_.tessellate) device_.demand_tessellation();
  }

  WindowRun run();

 private:
  void fit_images();
  void show_frame();
  void read_input();
  void read_mouse();
  void read_edit_keys();
  void draw_interface();
  void begin_editing();
  void save_edited();
  template <class Act>
  void tell_problems(const Act& act);
  void prepare();

  using Clock = std::chrono::steady_clock;

  const WindowOptions& options_;
  Glfw glfw_;
  OwnedWindow window_;
  Instance instance_;
  Surface surface_;
  Device device_;
  OwnedRenderPass pass_;
  Swapchain swapchain_;
  Overlay overlay_;
  ImguiInput input_;
  std::array<OwnedSemaphore, 2> image_ready_;  // of the frames in flight
  Renderer renderer_;
  ViewSettings settings_;
  OrbitCamera camera_;
  PanelFacts facts_;
  int frame_ = 0;
  bool edits_ = false;
  std::optional<EditSession> session_;  // once it has edited
  std::optional<EditHand> hand_;
  int revision_ = 0;     // of the session's rules, that the renderer has
  bool orbits_ = false;  // while a button is down
  bool fits_ = false;    // whether the swapchain's images fit the window
  double seconds_ = 0;   // of the animation
};

// What cannot be done stands in the panel, and all is as it was.
template <class Act>
void Window::tell_problems(const Act& act) {
  try {
    facts_.problem.clear();
    act();
  } catch (const Error& error) {
    facts_.problem = error.what();
  }
}

void Window::begin_editing() {
  edits_ = true;
  if (session_) return;
  tell_problems([&] {
    session_.emplace(renderer_.scene());
    hand_.emplace(*session_);
  });
  edits_ = session_.has_value();
}

void Window::save_edited() {
  tell_problems([&] {
    SaveOptions save = save_options(renderer_.scene());
    save.level = settings_.level;
    const std::string& name = renderer_.scene().name;
    facts_.problem =
        save_all(*session_, options_.save.empty() ? name + "_edited" : options_.save, save);
  });
}

// The button that takes a point moves it until it is let go; any other drag orbits.
void Window::read_mouse() {
  const ImGuiIO& io = ImGui::GetIO();
  const float aspect = io.DisplaySize.x / io.DisplaySize.y;
  const glm::vec2 place(io.MousePos.x / io.DisplaySize.x, io.MousePos.y / io.DisplaySize.y);
  const bool is_left = ImGui::IsMouseDown(ImGuiMouseButton_Left);
  if (is_left && hand_ && hand_->is_holding()) {
    tell_problems([&] { hand_->drag(camera_, aspect, place); });
    return;
  }
  if (!is_left && hand_) hand_->release();
  if (!is_left && !ImGui::IsMouseDown(ImGuiMouseButton_Right)) orbits_ = false;
  if (io.WantCaptureMouse) return;
  if (edits_ && ImGui::IsMouseClicked(ImGuiMouseButton_Left) &&
      hand_->press(camera_, aspect, place, io.KeyCtrl))
    return;
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) || ImGui::IsMouseClicked(ImGuiMouseButton_Right))
    orbits_ = true;
  if (orbits_)
    camera_.orbit(io.MouseDelta.x / io.DisplaySize.y, io.MouseDelta.y / io.DisplaySize.y);
  if (io.MouseWheel == 0) return;
  constexpr float kZoom = 1.1f;
  const float factor = io.MouseWheel > 0 ? kZoom : 1 / kZoom;
  if (edits_ && io.KeyShift)
    grow_radius(*session_, factor);
  else
    camera_.zoom_by(factor);
}

void Window::read_edit_keys() {
  const ImGuiIO& io = ImGui::GetIO();
  const auto pressed = [](int key) { return is_pressed(key, true); };
  if (io.KeyCtrl) {
    if (pressed(GLFW_KEY_Z)) tell_problems([&] { session_->undo(); });
    if (pressed(GLFW_KEY_Y)) tell_problems([&] { session_->redo(); });
    if (is_pressed(GLFW_KEY_S, false)) save_edited();
    return;
  }
  constexpr float kGrowth = 1.25f;
  if (pressed(GLFW_KEY_LEFT_BRACKET)) grow_radius(*session_, 1 / kGrowth);
  if (pressed(GLFW_KEY_RIGHT_BRACKET)) grow_radius(*session_, kGrowth);
  const float aspect = io.DisplaySize.x / io.DisplaySize.y;
  const glm::vec2 place(io.MousePos.x / io.DisplaySize.x, io.MousePos.y / io.DisplaySize.y);
  // Not in a drag, whose positions are those before.
  if (hand_->is_holding()) return;
  if (is_pressed(GLFW_KEY_X, false))
    tell_problems([&] { hand_->toggle_crease(camera_, aspect, place); });
  if (is_pressed(GLFW_KEY_V, false)) {
    tell_problems([&] {
      if (const auto vertex = hand_->vertex_at(camera_, aspect, place))
        session_->toggle_corner(*vertex);
    });
  }
}

void Window::read_input() {
  const ImGuiIO& io = ImGui::GetIO();
  read_mouse();
  if (io.WantCaptureKeyboard) return;
  if (edits_) read_edit_keys();
  if (is_pressed(GLFW_KEY_E, false)) {
    if (edits_)
      edits_ = false;
    else
      begin_editing();
  }
  if (is_pressed(GLFW_KEY_ESCAPE, false)) glfwSetWindowShouldClose(window_.get(), true);
  if (io.KeyCtrl) return;
  const std::array<std::pair<int, bool*>, 6> toggles{{{GLFW_KEY_S, &settings_.surface},
                                                      {GLFW_KEY_C, &settings_.cage},
                                                      {GLFW_KEY_P, &settings_.points},
                                                      {GLFW_KEY_H, &settings_.heat},
                                                      {GLFW_KEY_T, &settings_.tessellate},
                                                      {GLFW_KEY_SPACE, &settings_.paused}}};
  for (const auto& [key, value] : toggles)
    if (is_pressed(key, false)) *value = !*value;
  settings_.tessellate &= device_.has_tessellation();
}

void Window::draw_interface() {
  ImGui_ImplGlfw_NewFrame();
  overlay_.begin();
  const ImGuiIO& io = ImGui::GetIO();
  if (!settings_.paused && !edits_) seconds_ += io.DeltaTime;
  facts_.frames_per_second = io.Framerate;
  read_input();
  bool edits = edits_;
  const EditClicks clicks =
      draw_panel(renderer_, facts_, settings_, session_ ? &*session_ : nullptr, edits);
  if (clicks.undoes) tell_problems([&] { session_->undo(); });
  if (clicks.redoes) tell_problems([&] { session_->redo(); });
  if (clicks.saves) save_edited();
  if (edits && !edits_) begin_editing();
  edits_ = edits && session_;
  if (edits_) draw_selection(*session_, camera_, {io.DisplaySize.x, io.DisplaySize.y});
  if (settings_.heat)
    draw_legend(renderer_.status() ? "largest " + error_text(renderer_.status()->residual /
                                                             renderer_.system().diagonal())
                                   : "");
}

// A level that does not fit the device leaves the old one and says why.
void Window::prepare() {
  const int shown = frame_ > 0 ? renderer_.system().level() : settings_.level;
  try {
    renderer_.prepare(settings_.level);
    if (settings_.level != shown) facts_.problem.clear();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::OutOfMemory || settings_.level == shown) throw;
    facts_.problem = error.what();
    settings_.level = shown;
    renderer_.prepare(shown);
  }
}

void Window::fit_images() {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_.get(), &width, &height);
  swapchain_.resize({static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)});
  fits_ = swapchain_.has_images();
}

void Window::show_frame() {
  if (session_ && session_->revision() != revision_) {
    renderer_.set_mesh(session_->rest());
    revision_ = session_->revision();
  }
  prepare();  // and so the semaphore is free
  const VkSemaphore ready = image_ready_[frame_ % image_ready_.size()];
  const auto image = swapchain_.acquire(ready);
  fits_ = image.has_value();
  if (!image) return;
  draw_interface();  // first, so that the frame has what was just dragged
  const VkCommandBuffer commands = edits_ ? renderer_.begin_frame(session_->points(), settings_)
                                          : renderer_.begin_frame(seconds_, settings_);
  swapchain_.targets().begin(commands, *image);
  renderer_.draw(commands, camera_, swapchain_.targets().extent(), settings_);
  overlay_.record(commands);
  vkCmdEndRenderPass(commands);
  renderer_.end_frame({ready, swapchain_.drawn(*image)});
  fits_ = swapchain_.present(*image);
  ++frame_;
}

WindowRun Window::run() {
  const auto began = Clock::now();
  if (edits_) begin_editing();
  while (!glfwWindowShouldClose(window_.get()) &&
         (options_.frames == 0 || frame_ < options_.frames)) {
    glfwPollEvents();
    if (options_.before_frame) options_.before_frame(window_.get(), frame_);
    if (!fits_) fit_images();
    if (fits_)
      show_frame();
    else
      glfwWaitEvents();  // a minimised window: until the user does something
  }
  renderer_.finish();
  return {frame_, std::chrono::duration<double>(Clock::now() - began).count()};
}

}  // namespace

WindowRun run_window(Scene scene, const WindowOptions& options) {
  Window window(std::move(scene), options);
  return window.run();
}

}  // namespace planish::viewer
