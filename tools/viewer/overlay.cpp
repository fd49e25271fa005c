#include "overlay.h"

#include <imgui.h>
#include <imgui_impl_vulkan.h>

#include "targets.h"

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

}  // namespace planish::viewer
