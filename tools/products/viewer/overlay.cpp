#include "overlay.h"

#include <imgui.h>
#include <imgui_impl_vulkan.h>

#include <cstdio>

#include "device.h"
#include "planish/core/error.h"
#include "shared.h"

namespace planish::viewer {
namespace {

constexpr float kFontPixels = 13;

OwnedDescriptorPool make_imgui_pool(VkDevice device) {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
  VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  info.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
  info.maxSets = 1;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  return OwnedDescriptorPool(device, info, "vkCreateDescriptorPool");
}

}  // namespace

Overlay::ImguiContext::ImguiContext() {
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // it would write a file into the folder that one is in
  ImGui::StyleColorsLight();
}

Overlay::ImguiContext::~ImguiContext() { ImGui::DestroyContext(); }

Overlay::Overlay(const Device& device, VkRenderPass pass, int scale)
    : device_(device), pool_(make_imgui_pool(device)) {
  ImFontConfig font;
  font.SizePixels = kFontPixels * static_cast<float>(scale);
  ImGui::GetIO().Fonts->AddFontDefault(&font);
  ImGui::GetStyle().ScaleAllSizes(static_cast<float>(scale));
  ImGui_ImplVulkan_InitInfo info{};
  info.Instance = device.instance();
  info.PhysicalDevice = device.physical();
  info.Device = device;
  info.QueueFamily = device.family();
  info.Queue = device.queue();
  info.DescriptorPool = pool_;
  info.MinImageCount = info.ImageCount = 2;  // sets of vertex buffers, taken in turn
  info.MSAASamples = kSamples;
  info.CheckVkResultFn = [](VkResult result) { vulkan::check(result, "Dear ImGui"); };
  ImGui_ImplVulkan_Init(&info, pass);
#if IMGUI_VERSION_NUM >= 19000
  ImGui_ImplVulkan_CreateFontsTexture();
#else
  device.run([](VkCommandBuffer commands) { ImGui_ImplVulkan_CreateFontsTexture(commands); });
  ImGui_ImplVulkan_DestroyFontUploadObjects();
#endif
}

Overlay::~Overlay() {
  vkDeviceWaitIdle(device_);
  ImGui_ImplVulkan_Shutdown();
}

void Overlay::begin(const std::optional<VkExtent2D>& off_screen) {
  ImGui_ImplVulkan_NewFrame();
  if (off_screen)
    ImGui::GetIO().DisplaySize = {static_cast<float>(off_screen->width),
                                  static_cast<float>(off_screen->height)};
  ImGui::NewFrame();
}

void Overlay::record(VkCommandBuffer commands) {
  ImGui::Render();
  ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), commands);
}

namespace {

constexpr ImU32 kInk = IM_COL32(30, 34, 42, 255), kPaper = IM_COL32(255, 255, 255, 205);
constexpr const char* kTitle = "distance from given points / diagonal";

ImU32 stop_colour(std::size_t stop) {
  const glm::vec3& colour = shared::kHeatStops[stop];
  return ImGui::ColorConvertFloat4ToU32({colour.x, colour.y, colour.z, 1});
}

}  // namespace

std::string error_text(double relative_error) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1e", relative_error);
  return text;
}

std::string solve_text(InterpolationMethod method, std::uint32_t iterations) {
  if (method == InterpolationMethod::Fair) return "the fair method";
  return std::to_string(iterations) + (iterations == 1 ? " iteration" : " iterations");
}

void draw_legend(const std::string& line) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float em = ImGui::GetFontSize(), pad = 0.8f * em, bar_height = 1.1f * em;
  const float width = 24 * em;
  const float height = 2 * pad + bar_height + 4.3f * em;
  const float left = em, top = ImGui::GetIO().DisplaySize.y - em - height;
  list.AddRectFilled({left, top}, {left + width + 2 * pad, top + height}, kPaper, 0.5f * em);
  const float x = left + pad;
  float y = top + pad;
  list.AddText({x, y}, kInk, kTitle);
  y += 1.4f * em;
  const float step = width / static_cast<float>(shared::kHeatStopCount - 1);
  for (std::size_t i = 0; i + 1 < shared::kHeatStopCount; ++i) {
    const float from = x + step * static_cast<float>(i);
    list.AddRectFilledMultiColor({from, y}, {from + step, y + bar_height}, stop_colour(i),
                                 stop_colour(i + 1), stop_colour(i + 1), stop_colour(i));
  }
  y += bar_height;
  const int lowest = static_cast<int>(shared::kHeatLowest);
  const int decades = static_cast<int>(shared::kHeatHighest) - lowest;
  for (int i = 0; i <= decades; ++i) {
    const std::string text = formatted("1e{}", lowest + i);
    const float at = x + width * static_cast<float>(i) / static_cast<float>(decades);
    const float text_width = ImGui::CalcTextSize(text.c_str()).x;
    // Inside the bar's ends, centred between them.
    const float shift = text_width * static_cast<float>(i) / static_cast<float>(decades);
    list.AddLine({at, y}, {at, y + 0.35f * em}, kInk);
    list.AddText({at - shift, y + 0.35f * em}, kInk, text.c_str());
  }
  list.AddText({x, y + 1.6f * em}, kInk, line.c_str());
}

namespace {

constexpr ImU32 kHandleInk = IM_COL32(255, 170, 30, 255), kHandleRim = IM_COL32(60, 40, 10, 255),
                kAlongInk = IM_COL32(255, 170, 30, 150);
constexpr std::size_t kMostDots = 300;  // of those that move along: more hide the surface
// Of the picture's height.
constexpr float kHandleSize = 0.0095f, kAlongSize = 0.0055f, kLeastAlong = 0.25f;

}  // namespace

void draw_selection(const EditSession& session, const OrbitCamera& camera, const glm::vec2& size) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float aspect = size.x / size.y;
  const auto points = session.points();
  const Selection reached = session.reached();
  const auto draw = [&](std::int32_t vertex, float radius, ImU32 ink, bool has_rim) {
    const auto place = camera.place_of(points[vertex], aspect);
    if (!place) return;
    const ImVec2 at{place->x * size.x, place->y * size.y};
    list.AddCircleFilled(at, radius * size.y, ink);
    if (has_rim) list.AddCircle(at, radius * size.y, kHandleRim, 0, 0.2f * radius * size.y);
  };
  const std::size_t stride = (reached.vertices.size() + kMostDots - 1) / kMostDots;
  for (std::size_t i = 0; i < reached.vertices.size(); i += stride) {
    const auto weight = static_cast<float>(reached.weights[i]);
    if (weight < 1)
      draw(reached.vertices[i], kAlongSize * (kLeastAlong + (1 - kLeastAlong) * weight), kAlongInk,
           false);
  }
  for (const std::int32_t vertex : session.selected()) draw(vertex, kHandleSize, kHandleInk, true);
}

namespace {

EditClicks draw_edit_tools(EditSession& session, float em) {
  EditClicks clicks;
  auto part = static_cast<float>(100 * session.radius() / session.diagonal());
  ImGui::PushItemWidth(12 * em);
  // Above the slider's range keys go on.
  if (ImGui::SliderFloat("falloff", &part, 0, 50, part > 0 ? "%.1f %%" : "none"))
    session.set_radius(part / 100 * session.diagonal());
  ImGui::PopItemWidth();
  clicks.undoes = ImGui::Button("undo");
  ImGui::SameLine();
  clicks.redoes = ImGui::Button("redo");
  ImGui::SameLine();
  clicks.saves = ImGui::Button("save");
  ImGui::Text("%zu selected, within %s of the diagonal", session.selected().size(),
              error_text(session.editor().error_bound()).c_str());
  return clicks;
}

}  // namespace

EditClicks draw_panel(const Renderer& renderer, const PanelFacts& facts, ViewSettings& settings,
                      EditSession* session, bool& edits) {
  const float em = ImGui::GetFontSize();
  ImGui::SetNextWindowPos({em, em}, ImGuiCond_FirstUseEver);
  ImGui::Begin("planish", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushItemWidth(12 * em);
  ImGui::SliderInt("level", &settings.level, 0, kMostLevel, "%d", ImGuiSliderFlags_AlwaysClamp);
  const bool iterates = renderer.scene().system.method == InterpolationMethod::Progressive;
  if (iterates)
    ImGui::SliderInt("iterations", &settings.iterations, 0, kMostIterations, "%d",
                     ImGuiSliderFlags_AlwaysClamp);
  ImGui::PopItemWidth();
  if (iterates) {
    ImGui::Checkbox("warm start", &settings.warm_start);
    ImGui::SameLine();
  }
  ImGui::Checkbox("pause", &settings.paused);
  ImGui::Checkbox("surface", &settings.surface);
  ImGui::SameLine();
  ImGui::Checkbox("cage", &settings.cage);
  ImGui::SameLine();
  ImGui::Checkbox("points", &settings.points);
  ImGui::SameLine();
  ImGui::Checkbox("errors", &settings.heat);
  if (renderer.scene().system.textured) {
    ImGui::SameLine();
    ImGui::Checkbox("texture", &settings.texture);
  }
  ImGui::Checkbox("edit", &edits);
  if (facts.tessellates) {
    ImGui::SameLine();
    ImGui::Checkbox("tessellation", &settings.tessellate);
  }
  const EditClicks clicks = session && edits ? draw_edit_tools(*session, em) : EditClicks{};
  ImGui::Separator();
  const vulkan::System& system = renderer.system();
  ImGui::Text("%s: %d points", renderer.scene().name.c_str(), system.given_count());
  if (!settings.draws_patches()) {
    ImGui::SameLine(0, 0);
    ImGui::Text(", %zu triangles", system.triangles().size() / 3);
  }
  if (renderer.status()) {
    const double error = renderer.status()->residual / system.diagonal();
    ImGui::Text("error %s of the diagonal", error_text(error).c_str());
  }
  ImGui::Text("%.0f frames/s, %s", static_cast<double>(facts.frames_per_second),
              facts.device.c_str());
  if (!facts.problem.empty()) ImGui::TextWrapped("%s", facts.problem.c_str());
  ImGui::End();
  return clicks;
}

}  // namespace planish::viewer
