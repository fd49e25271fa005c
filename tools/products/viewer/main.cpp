// planish-viewer: planish embedded in an application that owns its Vulkan device, its memory and
// its frame loop. Read scene.cpp, renderer.cpp, frame.cpp and renderer.cpp, in this order.
#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>

#include "arguments.h"
#include "crowd.h"
#include "headless.h"
#include "overlay.h"
#include "planish/core/error.h"
#include "planish/files/images.h"
#include "terminal.h"
#include "window.h"

namespace planish::viewer {
namespace {

using command::ExitCode;

OrbitCamera camera_of(const Arguments& arguments, const Scene& scene) {
  OrbitCamera camera = camera_around(scene.mesh.positions);
  camera.azimuth_degrees = arguments.azimuth_degrees;
  camera.elevation_degrees = arguments.elevation_degrees;
  return camera;
}

void show_window(const Arguments& arguments, Scene scene, const InstanceOptions& instance) {
  WindowOptions options;
  options.width = arguments.width;
  options.height = arguments.height;
  options.device = arguments.device;
  options.validation = instance.validation;
  options.message = instance.message;
  options.camera = camera_of(arguments, scene);
  options.settings = arguments.settings;
  options.frames = arguments.frames;
  options.edits = arguments.edit;
  options.save = arguments.save;
  const WindowRun shown = run_window(std::move(scene), options);
  std::printf("%d frames in %.2f s\n", shown.frames, shown.seconds);
}

void run_headless(const Arguments& arguments, Scene scene,
                  const InstanceOptions& instance_options) {
  HeadlessOptions options;
  options.extent = {static_cast<std::uint32_t>(arguments.width),
                    static_cast<std::uint32_t>(arguments.height)};
  options.settings = arguments.settings;
  options.camera = camera_of(arguments, scene);
  const Instance instance(instance_options);
  const Device device(instance, {arguments.device});
  const std::string name = scene.name;
  Headless headless(device, std::move(scene), options);
  const int frames = std::max(arguments.frames, 1);
  const auto began = std::chrono::steady_clock::now();
  headless.run(frames);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  const std::string how = arguments.settings.draws_patches()
                              ? "tessellated"
                              : formatted("at level {}", headless.system().level());
  const double error = headless.status().residual / headless.system().diagonal();
  std::printf("%s %s on %s: %d frames of %s in %.2f s, error %s of the diagonal\n", name.c_str(),
              how.c_str(), device.name().c_str(), frames,
              solve_text(headless.scene().system.method,
                         static_cast<std::uint32_t>(arguments.settings.iterations))
                  .c_str(),
              took.count(), error_text(error).c_str());
  if (!arguments.png.empty()) write_png(arguments.png, arguments.width, headless.picture());
}

void run_crowd(const Arguments& arguments, Scene scene, const InstanceOptions& instance_options) {
  CrowdOptions options;
  options.extent = {static_cast<std::uint32_t>(arguments.width),
                    static_cast<std::uint32_t>(arguments.height)};
  options.count = static_cast<std::uint32_t>(arguments.instances);
  options.iterations = arguments.settings.iterations;
  scene.system.textured = arguments.settings.texture && !scene.mesh.uvs.empty();
  const Instance instance(instance_options);
  const Device device(instance, {arguments.device});
  const std::string name = scene.name;
  Crowd crowd(device, std::move(scene), options);
  const int frames = std::max(arguments.frames, 1);
  const auto began = std::chrono::steady_clock::now();
  crowd.run(frames);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  const CrowdFigures figures = crowd.figures();
  std::printf("%u of %s on %s: %d frames in %.2f s; the last has %llu triangles, of instances\n",
              options.count, name.c_str(), device.name().c_str(), frames, took.count(),
              static_cast<unsigned long long>(figures.triangles));
  for (std::size_t k = 0; k < figures.instances.size(); ++k)
    std::printf("%6u at level %d\n", figures.instances[k], options.levels[k]);
  std::printf("%6u off screen\n", figures.unseen);
  if (!arguments.png.empty()) write_png(arguments.png, arguments.width, crowd.picture());
}

// What is wrong with a script is said before a device is sought.
void run_edit(const Arguments& arguments, Scene scene, const InstanceOptions& instance_options) {
  const std::vector<ScriptStep> script = read_script(arguments.script);
  EditSession session(scene);
  const SaveOptions save{scene.settings, scene.source, arguments.settings.level};
  HeadlessOptions options;
  options.extent = {static_cast<std::uint32_t>(arguments.width),
                    static_cast<std::uint32_t>(arguments.height)};
  options.settings = arguments.settings;
  options.camera = camera_of(arguments, scene);
  const Instance instance(instance_options);
  const Device device(instance, {arguments.device});
  const std::string name = scene.name;
  Headless headless(device, std::move(scene), options);
  const int frames = run_script(script, session, headless, save);
  std::printf("%s on %s: %zu steps, %d frames; the surface is within %s of the diagonal\n",
              name.c_str(), device.name().c_str(), script.size(), frames,
              error_text(session.editor().error_bound()).c_str());
  if (!arguments.png.empty()) {
    headless.show(session, Headless::Solved::Anew);
    write_png(arguments.png, arguments.width, headless.picture());
  }
}

ExitCode run(int argc, char** argv) {
  std::optional<Arguments> arguments = parse_arguments(argc, argv);
  if (!arguments) return ExitCode::Done;
  std::atomic<int> messages = 0;
  InstanceOptions instance;
  instance.validation = arguments->validate;
  instance.message = [&](std::string_view message) {
    ++messages;
    std::cerr << message << '\n';
  };
  std::optional<InterpolationMethod> method;
  if (arguments->instances > 0) method = InterpolationMethod::Progressive;
  Scene scene = load_scene(arguments->scene, arguments->job, method);
  if (arguments->settings.texture && scene.mesh.uvs.empty())
    throw Error(ErrorCode::InvalidArgument,
                "--texture: " + scene.name + " has no texture coordinates");
  arguments->settings.level = arguments->level.value_or(std::min(scene.system.level, kMostLevel));
  if (!arguments->script.empty())
    run_edit(*arguments, std::move(scene), instance);
  else if (arguments->instances > 0)
    run_crowd(*arguments, std::move(scene), instance);
  else if (arguments->headless)
    run_headless(*arguments, std::move(scene), instance);
  else
    show_window(*arguments, std::move(scene), instance);
  if (arguments->validate) std::printf("validation: %d messages\n", messages.load());
  return messages == 0 ? ExitCode::Done : ExitCode::InternalError;
}

}  // namespace
}  // namespace planish::viewer

int main(int argc, char** argv) {
  using planish::command::ExitCode;
  ExitCode code = ExitCode::InternalError;
  try {
    code = planish::viewer::run(argc, argv);
  } catch (const planish::Error& error) {
    std::fprintf(stderr, "planish-viewer: error: %s\n", error.what());
    code = planish::command::exit_code_of(error.code());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "planish-viewer: error: out of memory\n");
    code = ExitCode::NoDevice;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "planish-viewer: error: %s\n", error.what());
  }
  return static_cast<int>(code);
}
