// planish-render: a picture of a surface, drawn by the CPU.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "picture.h"
#include "planish/core/error.h"
#include "planish/files/images.h"
#include "planish/files/mesh_file.h"

namespace planish::render {
namespace {

struct Arguments {
  std::vector<std::string> inputs, views;
  std::string output, overlay, size = "1200x900", colour, zoom, attribute;
  double scale = 0;
  std::size_t columns = 0;  // 0: as many as there are inputs
  bool stripes = false, heat = false;
  PictureOptions picture;
};

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::InvalidArgument, what); }

void parse_texts(Arguments& arguments) {
  PictureOptions& picture = arguments.picture;
  constexpr int kMaxSide = 8192;
  char rest = 0;
  if (std::sscanf(arguments.size.c_str(), "%dx%d%c", &picture.width, &picture.height, &rest) != 2 ||
      std::min(picture.width, picture.height) < 1 ||
      std::max(picture.width, picture.height) > kMaxSide) {
    refuse("--size " + arguments.size + ": is not WIDTHxHEIGHT up to 8192x8192");
  }
  if (arguments.views.size() > 1 && arguments.views.size() != arguments.inputs.size()) {
    refuse("--view: give one, or one for each input");
  }
  unsigned r = 0, g = 0, b = 0;
  if (!arguments.colour.empty()) {
    if (std::sscanf(arguments.colour.c_str(), "%2x%2x%2x%c", &r, &g, &b, &rest) != 3) {
      refuse("--color " + arguments.colour + ": is not RRGGBB");
    }
    picture.colour = glm::vec3(r, g, b) / 255.0f;
  }
  if (arguments.stripes) picture.look = Look::Stripes;
  if (arguments.heat) picture.look = Look::Heat;
  if (!arguments.attribute.empty()) picture.look = Look::Values;
  if (!(arguments.scale >= 0) || !std::isfinite(arguments.scale))
    refuse("--scale: is a number above 0");
}

// Of the input of that number.
ViewOptions view_of(const Arguments& arguments, std::size_t input) {
  ViewOptions view;
  char left = 0;
  if (!arguments.zoom.empty() && (std::sscanf(arguments.zoom.c_str(), "%f,%f,%f%c", &view.zoom,
                                              &view.middle.x, &view.middle.y, &left) != 3 ||
                                  !(view.zoom > 0))) {
    refuse("--zoom " + arguments.zoom + ": is not FACTOR,X,Y");
  }
  if (arguments.views.empty()) return view;
  const std::string& text = arguments.views[arguments.views.size() == 1 ? 0 : input];
  char rest = 0;
  if (std::sscanf(text.c_str(), "%f,%f%c", &view.azimuth_degrees, &view.elevation_degrees, &rest) !=
      2) {
    refuse("--view " + text + ": is not AZIMUTH,ELEVATION in degrees");
  }
  return view;
}

void run(Arguments& arguments) {
  parse_texts(arguments);
  InputFiles read;
  for (const std::string& input : arguments.inputs) read.add(input);
  if (!arguments.overlay.empty()) read.add(arguments.overlay);
  if (const std::string objection = read.objection(arguments.output); !objection.empty())
    refuse(objection);
  std::optional<PolygonMesh> overlay;
  if (!arguments.overlay.empty()) overlay = read_mesh(arguments.overlay).mesh;
  const std::size_t row = std::size_t{3} * arguments.picture.width;
  const std::size_t count = arguments.inputs.size();
  const std::size_t columns = arguments.columns > 0 ? std::min(arguments.columns, count) : count;
  const std::size_t whole_row = row * columns;
  const std::size_t tile_row = whole_row * arguments.picture.height;
  std::vector<std::uint8_t> pixels(tile_row * ((count + columns - 1) / columns), 255);
  for (std::size_t i = 0; i < count; ++i) {
    arguments.picture.view = view_of(arguments, i);
    const RenderMesh mesh = read_glb(arguments.inputs[i], arguments.attribute);
    arguments.picture.overlay = overlay;
    if (overlay)
      for (glm::dvec3& p : arguments.picture.overlay->positions) p -= mesh.origin;
    if (!arguments.attribute.empty()) {
      PictureOptions& picture = arguments.picture;
      picture.scale =
          arguments.scale > 0 ? static_cast<float>(arguments.scale) : usual_magnitude(mesh.values);
      std::printf("%s: %s from %.3g (blue) to %.3g (red)\n", arguments.inputs[i].c_str(),
                  arguments.attribute.c_str(), -picture.scale, picture.scale);
    }
    const auto tile = draw_picture(mesh, arguments.picture);
    const std::size_t place = tile_row * (i / columns) + row * (i % columns);
    for (int y = 0; y < arguments.picture.height; ++y)
      std::copy_n(&tile[row * y], row, &pixels[place + whole_row * y]);
  }
  write_png(arguments.output, static_cast<int>(whole_row / 3), pixels);
}

}  // namespace
}  // namespace planish::render

int main(int argc, char** argv) {
  planish::render::Arguments arguments;
  CLI::App app("A picture of a surface that planish wrote", "planish-render");
  app.add_option("input", arguments.inputs, "GLBs; drawn side by side")->required();
  app.add_option("-o,--output", arguments.output, "the PNG")->required();
  app.add_option("--size", arguments.size, "WIDTHxHEIGHT of each in pixels")->capture_default_str();
  app.add_option("--columns", arguments.columns, "so many side by side, the others below");
  app.add_option("--view", arguments.views, "AZIMUTH,ELEVATION of the eye in degrees");
  app.add_option("--zoom", arguments.zoom,
                 "FACTOR,X,Y: enlarges what lies there, in fractions of the picture");
  app.add_option("--color", arguments.colour, "RRGGBB of the material");
  app.add_flag("--stripes", arguments.stripes, "reflection lines, to judge smoothness");
  app.add_flag("--heat", arguments.heat, "colours by curvature")->excludes("--stripes");
  app.add_option("--attribute", arguments.attribute,
                 "colours by numbers of the file, _MEAN_CURVATURE for one: blue below 0, red above")
      ->excludes("--stripes", "--heat");
  app.add_option("--scale", arguments.scale,
                 "what the ends of those colours stand for [what 19 of 20 do not exceed]");
  app.add_flag("--wire", arguments.picture.wire, "edges of the surface's quads");
  app.add_option("--overlay", arguments.overlay, "mesh whose edges and vertices are drawn too");
  app.add_option("--edge-width", arguments.picture.overlay_options.edge_width,
                 "of the overlay, in quarters of a pixel; 0 for none")
      ->capture_default_str();
  app.add_option("--vertex-width", arguments.picture.overlay_options.vertex_width,
                 "of the overlay, in quarters of a pixel; 0 for none")
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    planish::render::run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "planish-render: %s\n", error.what());
    return 1;
  }
  return 0;
}
