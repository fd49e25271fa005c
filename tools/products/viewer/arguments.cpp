#include "arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "help.h"
#include "planish/core/error.h"
#include "planish/core/version.h"

namespace planish::viewer {
namespace {

constexpr int kLeastSide = 16, kLargestSide = 8192, kMostFrames = 1000000, kMostInstances = 65535;
const command::CommandText kText{
    .examples = {"planish-viewer --scene scenes/goblet.json",
                 "planish-viewer --headless --scene scenes/goblet.json --frames 120 --png out.png",
                 "planish-viewer --headless --scene bust.obj --level 3 --iterations 2 --heat --png "
                 "heat.png",
                 "planish-viewer --headless --scene scenes/goblet.json --script moves.txt",
                 "planish-viewer --headless --scene scenes/mixed_polygons.obj --instances 1000 "
                 "--png a.png"},
    .first_flags = {},
    .notes =
        "In the window: drag to orbit, scroll to zoom; S surface, C cage, P points, H errors, T "
        "tessellation, space pause, E edit, Esc close.\nWhile editing: drag a point of the surface "
        "to move it, Ctrl+click adds it to those that move together or takes it out, [ and ] or "
        "Shift+scroll "
        "change how far around they take others along; X creases the edge under the cursor, V the "
        "vertex as a corner, or smooths them; Ctrl+Z undo, Ctrl+Y redo, Ctrl+S save; drag beside "
        "the surface or with the right button to orbit.\n"
        "Steps of a script, one a line; # begins a comment:\n"
        "  pick X Y [add]               selects the vertex under a pixel\n"
        "  vertices V [V ...]           or by number, from 0\n"
        "  radius R                     vertices up to R away, along edges, move along; 0: none\n"
        "  move DX DY DZ [FRAMES]       moves the selection\n"
        "  drag X Y X2 Y2 [FRAMES]      takes the vertex under a pixel to another pixel\n"
        "  crease V V, crease at X Y    makes an edge sharp, or smooth again\n"
        "  corner V                     the same of a vertex\n"
        "  undo [N], redo [N]           takes steps back, or does them again\n"
        "  frames N                     draws so many\n"
        "  picture FILE.png             solved from a cold start\n"
        "  save mesh|cage|surface FILE\nExit codes are those of planish; 1 also "
        "where --validate had "
        "messages."};

std::string footer() {
  std::string text = "Examples:\n";
  for (const std::string& example : kText.examples) text += "  " + example + "\n";
  return text + kText.notes + "\n";
}

[[noreturn]] void refuse_arguments(const std::string& what) {
  throw Error(ErrorCode::InvalidArgument, what);
}

void parse_size(const std::string& text, Arguments& arguments) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &arguments.width, &arguments.height, &rest) != 2 ||
      std::min(arguments.width, arguments.height) < kLeastSide ||
      std::max(arguments.width, arguments.height) > kLargestSide)
    refuse_arguments("--size " + text + ": is not WIDTHxHEIGHT from 16x16 to 8192x8192");
}

void parse_view(const std::string& text, Arguments& arguments) {
  constexpr float kMostDegrees = 89;  // at the pole "up" has no direction in the picture
  char rest = 0;
  if (std::sscanf(text.c_str(), "%f,%f%c", &arguments.azimuth_degrees, &arguments.elevation_degrees,
                  &rest) != 2 ||
      !(std::abs(arguments.azimuth_degrees) <= 360) ||
      !(std::abs(arguments.elevation_degrees) <= kMostDegrees))
    refuse_arguments("--view " + text + ": is not AZIMUTH,ELEVATION in degrees, up to 360 and 89");
}

}  // namespace

std::optional<Arguments> parse_arguments(int argc, const char* const* argv) {
  Arguments arguments;
  ViewSettings& settings = arguments.settings;
  std::string size, view;
  int level = -1;
  bool cold_start = false, no_surface = false, wants_manual = false;
  CLI::App app(
      "Animates the given points of a scene and draws the surface through them, all on "
      "the device: the example of embedding planish in a Vulkan application.",
      "planish-viewer");
  app.footer(footer());
  app.set_version_flag("--version", "planish-viewer " PLANISH_VERSION);
  app.add_option("--scene", arguments.scene, "scene file (.json) or mesh")->capture_default_str();
  app.add_option("--job", arguments.job, "which job of the scene file; its first");
  app.add_option("--level", level, "quad splits of the surface, 0 to 5; the scene's")
      ->check(CLI::Range(0, kMostLevel));
  app.add_option("--iterations", settings.iterations, "of each frame, 0 to 64")
      ->check(CLI::Range(0, kMostIterations))
      ->capture_default_str();
  app.add_flag("--cold-start", cold_start, "each frame starts without what the last one found");
  app.add_flag("--heat", settings.heat, "colours by interpolation error, with a legend");
  app.add_flag("--texture", settings.texture,
               "squares by the mesh's texture coordinates, redder along u and bluer along v");
  app.add_flag(
      "--tessellate", settings.tessellate,
      "as fine as it is seen, within a quarter of a pixel; errors and squares are shown at the "
      "level");
  app.add_flag("--cage", settings.cage, "the control cage's edges");
  app.add_flag("--points", settings.points, "the given points");
  app.add_flag("--no-surface", no_surface, "hides the surface");
  app.add_option("--view", view, "AZIMUTH,ELEVATION of the eye in degrees; 35,20");
  app.add_option("--size", size, "WIDTHxHEIGHT in pixels; 1280x720");
  app.add_option("--device", arguments.device, "number or part of the name of a Vulkan device");
  auto* frames =
      app.add_option("--frames", arguments.frames, "how many, then it ends; off-screen 1")
          ->check(CLI::Range(1, kMostFrames));
  auto* headless = app.add_flag("--headless", arguments.headless, "renders off-screen");
  app.add_option("--instances", arguments.instances,
                 "so many of the mesh from near to far, each at the level that it needs")
      ->check(CLI::Range(1, kMostInstances))
      ->needs(headless);
  app.add_option("--script", arguments.script, "moves of points to make and draw, see below")
      ->needs(headless)
      ->excludes(frames)
      ->excludes("--instances");
  app.add_flag("--edit", arguments.edit, "the window begins with points to drag, at rest")
      ->excludes(headless);
  app.add_option("--save", arguments.save, "Ctrl+S writes PREFIX.obj, PREFIX_cage.obj, PREFIX.glb")
      ->excludes(headless);
  app.add_option("--png", arguments.png, "the last frame's picture, of --headless")
      ->needs(headless);
  app.add_flag("--validate", arguments.validate,
               "Vulkan's validation layer with synchronization validation");
  app.add_flag("--manual", wants_manual)->group("");  // for the build, which installs it
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    app.exit(help);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    refuse_arguments(std::string(error.what()) + "; planish-viewer --help lists the flags");
  }
  if (wants_manual) {
    const command::HelpPage page = command::help_page(app, {{"", kText}});
    std::fputs(manual_page(page, page).c_str(), stdout);
    return std::nullopt;
  }
  if (!size.empty()) parse_size(size, arguments);
  if (!view.empty()) parse_view(view, arguments);
  if (level >= 0) arguments.level = level;
  settings.warm_start = !cold_start;
  settings.surface = !no_surface;
  return arguments;
}

}  // namespace planish::viewer
