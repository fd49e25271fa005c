// planish-render: a picture of a surface, drawn by the CPU.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

#include "picture.h"
#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/mesh/mesh_file.h"

namespace planish::render {
namespace {

struct Arguments {
  std::string input, output, overlay, size = "1200x900", colour, view;
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
  if (!arguments.view.empty() &&
      std::sscanf(arguments.view.c_str(), "%f,%f%c", &picture.view.azimuth_degrees,
                  &picture.view.elevation_degrees, &rest) != 2) {
    refuse("--view " + arguments.view + ": is not AZIMUTH,ELEVATION in degrees");
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
}

void write_png(const Arguments& arguments, const std::vector<std::uint8_t>& pixels) {
  OutputFile file(arguments.output);
  const auto send = [](void* context, void* data, int size) {
    static_cast<OutputFile*>(context)->write(
        std::span(static_cast<const std::byte*>(data), static_cast<std::size_t>(size)));
  };
  constexpr int kChannels = 3;
  const int width = arguments.picture.width, height = arguments.picture.height;
  stbi_write_png_compression_level = 9;
  if (!stbi_write_png_to_func(send, &file, width, height, kChannels, pixels.data(),
                              kChannels * width)) {
    throw Error(ErrorCode::OutOfMemory, arguments.output + ": no memory for the PNG");
  }
  file.commit();
}

void run(Arguments& arguments) {
  parse_texts(arguments);
  if (!arguments.overlay.empty()) {
    const auto format = format_of(arguments.overlay);
    if (!format) refuse(arguments.overlay + ": unknown mesh format");
    arguments.picture.overlay =
        read_mesh(read_file(arguments.overlay), arguments.overlay, *format).mesh;
  }
  write_png(arguments, draw_picture(read_glb(arguments.input), arguments.picture));
}

}  // namespace
}  // namespace planish::render

int main(int argc, char** argv) {
  planish::render::Arguments arguments;
  CLI::App app("A picture of a surface that planish wrote", "planish-render");
  app.add_option("input", arguments.input, "the GLB")->required();
  app.add_option("-o,--output", arguments.output, "the PNG")->required();
  app.add_option("--size", arguments.size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  app.add_option("--view", arguments.view, "AZIMUTH,ELEVATION of the eye in degrees");
  app.add_option("--color", arguments.colour, "RRGGBB of the material");
  app.add_flag("--stripes", arguments.stripes, "reflection lines, to judge smoothness");
  app.add_flag("--heat", arguments.heat, "colours by curvature")->excludes("--stripes");
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
