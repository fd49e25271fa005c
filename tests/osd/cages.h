#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace planish::testing {

/// A control mesh with all that OpenSubdiv knows of one.
struct Cage {
  std::string name;
  OpenSubdiv::Sdc::SchemeType scheme = OpenSubdiv::Sdc::SCHEME_CATMARK;
  OpenSubdiv::Sdc::Options options;
  std::vector<std::array<float, 3>> positions;
  std::vector<int> face_sizes, corners;
  std::vector<int> crease_pairs;        // two vertices for each sharp edge
  std::vector<float> crease_sharpness;  // one for each sharp edge
  std::vector<int> corner_vertices;
  std::vector<float> corner_sharpness;
  std::vector<int> holes;
  std::vector<int> face_varying;  // an index for each corner of each face; or none
  int face_varying_count = 0;

  void add_face(const std::vector<int>& vertices);
  void crease(int a, int b, float sharpness);
  void corner(int vertex, float sharpness);
};

/// Shapes, in cages.cpp: closed unless they say otherwise.
[[nodiscard]] Cage cube();
[[nodiscard]] Cage tetrahedron();
[[nodiscard]] Cage bipyramid(int sides);
[[nodiscard]] Cage icosahedron();
[[nodiscard]] Cage pyramid(int sides);
[[nodiscard]] Cage prism(int sides);
[[nodiscard]] Cage torus(int width, int height);
[[nodiscard]] Cage triangle_torus(int width, int height);
[[nodiscard]] Cage sphere(int around, int rings);  ///< poles of valence `around`
[[nodiscard]] Cage grid(int width, int height);    ///< open
[[nodiscard]] Cage triangle_grid(int width, int height);
[[nodiscard]] Cage tube(int around, int height);  ///< open at both ends
[[nodiscard]] Cage mobius(int around);            ///< open, one side, seam of reversed faces
[[nodiscard]] Cage pillow();                      ///< two quads back to back: valence 2
[[nodiscard]] Cage fan_of_pages(int pages);       ///< quads around one edge: not manifold
[[nodiscard]] Cage bow_tie();                     ///< two cubes that share a vertex: not manifold

/// The cages of the conformance tests, each of another feature.
[[nodiscard]] std::vector<Cage> all_cages();

/// A refiner of the cage, not refined. Throws std::runtime_error where OpenSubdiv refuses it.
[[nodiscard]] std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> make_refiner(const Cage& cage);

}  // namespace planish::testing
