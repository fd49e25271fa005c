#pragma once

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "viewer/headless.h"
#include "vulkan/fixture.h"

namespace planish::testing {

/// Renders off-screen with validation and synchronization validation on; a message fails the test.
class ViewerTest : public VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    viewer::InstanceOptions options;
    options.validation = true;
    options.message = [this](std::string_view message) {
      const std::lock_guard lock(mutex_);
      messages_.emplace_back(message);
    };
    instance_ = std::make_unique<viewer::Instance>(options);
    device_ = std::make_unique<viewer::Device>(*instance_, viewer::DeviceOptions{});
  }

  static viewer::Scene scene_of(PolygonMesh mesh) {
    viewer::Scene scene;
    scene.mesh = std::move(mesh);
    return scene;
  }

  /// Of the fair method, with the decisions of the mesh as it is.
  static viewer::Scene fair_scene_of(PolygonMesh mesh) {
    viewer::Scene scene = scene_of(std::move(mesh));
    scene.system.method = InterpolationMethod::Fair;
    const Fit rest = fit(scene.mesh, *make_cpu_backend(), {.method = InterpolationMethod::Fair});
    scene.decisions = std::make_shared<FairDecisions>(rest.fair->decisions);
    scene.system.fair_decisions = scene.decisions.get();
    return scene;
  }

  /// The scene's surface through the vertices of another pose of its mesh, at level 2.
  static SurfaceMesh surface_by_cpu(const viewer::Scene& scene, const PolygonMesh& pose) {
    const auto backend = make_cpu_backend();
    const FitOptions options{.method = scene.system.method,
                             .fair_decisions = scene.system.fair_decisions};
    EvaluateOptions evaluation{.level = 2};
    evaluation.rest_positions = scene.mesh.positions;
    return evaluate(pose, fit(pose, *backend, options), *backend, evaluation);
  }

  /// A small picture that frames the mesh.
  static viewer::HeadlessOptions options_for(const PolygonMesh& mesh) {
    viewer::HeadlessOptions options;
    options.extent = {160, 120};
    options.camera = viewer::camera_around(mesh.positions);
    return options;
  }

  /// The mesh as the animation has it in that frame.
  static PolygonMesh posed(const PolygonMesh& rest, int frame) {
    std::vector<glm::vec3> points(rest.positions.size());
    viewer::Animation(rest.positions).pose(frame / viewer::kFramesPerSecond, points);
    PolygonMesh mesh = rest;
    mesh.positions.assign(points.begin(), points.end());
    return mesh;
  }

  [[nodiscard]] bool has_extension(std::string_view name) const {
    std::uint32_t count = 0;
    vkEnumerateDeviceExtensionProperties(device_->physical(), nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> extensions(count);
    vkEnumerateDeviceExtensionProperties(device_->physical(), nullptr, &count, extensions.data());
    return std::ranges::any_of(
        extensions, [&](const auto& extension) { return name == extension.extensionName; });
  }

  /// With extensions that it has.
  void remake_device(const std::vector<const char*>& extensions, const void* features) {
    viewer::DeviceOptions options;
    options.extensions = extensions;
    options.features = features;
    device_ = std::make_unique<viewer::Device>(*instance_, options);
  }

  std::unique_ptr<viewer::Instance> instance_;
  std::unique_ptr<viewer::Device> device_;
};

/// The same on a device that tessellates and tells what it made; skipped elsewhere.
class CaptureTest : public ViewerTest {
 protected:
  void SetUp() override {
    ViewerTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    if (!device_->has_tessellation() || !has_extension(VK_EXT_TRANSFORM_FEEDBACK_EXTENSION_NAME))
      GTEST_SKIP() << device_->name() << " does not tessellate, or cannot tell what it made";
    VkPhysicalDeviceTransformFeedbackFeaturesEXT feedback{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TRANSFORM_FEEDBACK_FEATURES_EXT};
    feedback.transformFeedback = VK_TRUE;
    remake_device({VK_EXT_TRANSFORM_FEEDBACK_EXTENSION_NAME}, &feedback);
  }
};

}  // namespace planish::testing
