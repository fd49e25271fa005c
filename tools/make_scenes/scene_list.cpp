#include "make_scenes/scene_list.h"

#include "make_scenes/bust.h"
#include "make_scenes/mesh_builder.h"
#include "make_scenes/obj_text.h"
#include "make_scenes/random_mesh.h"
#include "make_scenes/revolve.h"
#include "make_scenes/rocker_arm.h"
#include "make_scenes/shapes.h"

namespace planish::shapes {

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> kScenes{
      {"cube_with_holes.obj", "Cube with three crossing tunnels, genus 5",
       [] { return cube_with_tunnels(31, 11); }},
      {"goblet.obj", "Wine goblet, genus 0", [] { return goblet(); }},
      {"rocker_arm.obj", "Rocker arm of an engine, genus 1", [] { return rocker_arm(); }},
      {"bust.obj", "Bust of a composer, genus 0", [] { return bust(); }},
      {"torus.obj", "Torus, R = 1, r = 0.4, 64 x 32 quads", [] { return torus(); }},
      {"icosphere.obj", "Icosphere of level 4", [] { return icosphere(4); }},
      {"pole64.obj", "Sphere with a pole of valence 64 and a cap of 64 corners",
       [] { return pole_sphere(64, 30); }},
      {"mixed_polygons.obj", "Ellipsoid of 3- to 12-gons", [] { return mixed_polygons(); }},
      {"plate_with_holes.obj", "Open planar plate with four round holes",
       [] { return plate_with_holes(); }},
      {"open_grid.obj", "Open planar grid of 16 x 12 quads", [] { return open_grid(16, 12); }},
      {"wavy_patch.obj", "Open patch of 24 x 24 quads, z = 0.1 sin(2 pi x) cos(2 pi y)",
       [] { return wavy_patch(24, 24); }},
      {"bearing_block.obj", "Bearing block with tagged creases, genus 1",
       [] { return bearing_block(); }},
      {"l_bracket.obj", "L-bracket with two concave faces", [] { return l_bracket(); }},
      {"cube.obj", "Cube of six quads", [] { return cube(); }},
      {"mapped_cube.obj", "Cube with six charts, two materials and colours",
       [] { return mapped_cube(4); }},
      {"cube_with_windows.obj", "Cube with a hole in every side",
       [] { return cube_with_windows(); }},
  };
  return kScenes;
}

PolygonMesh scene_mesh(const Scene& scene) {
  PolygonMesh mesh = scene.make();
  round_positions(mesh);
  return mesh;
}

std::string scene_text(const Scene& scene) { return obj_text(scene_mesh(scene), scene.comment); }

}  // namespace planish::shapes
