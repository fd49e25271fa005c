#include "osd/cages.h"

#include <opensubdiv/far/topologyDescriptor.h>

#include <stdexcept>
#include <utility>

namespace planish::testing {

namespace {

using namespace OpenSubdiv;
using Options = Sdc::Options;

const float kInfinite = Sdc::Crease::SHARPNESS_INFINITE;

Cage named(const std::string& name, Cage cage) {
  cage.name = name;
  return cage;
}

Cage as_loop(Cage cage) {
  cage.scheme = Sdc::SCHEME_LOOP;
  return cage;
}

Cage as_bilinear(Cage cage) {
  cage.scheme = Sdc::SCHEME_BILINEAR;
  return cage;
}

Cage with_boundary(Options::VtxBoundaryInterpolation boundary, Cage cage) {
  cage.options.SetVtxBoundaryInterpolation(boundary);
  return cage;
}

/// Sharpness of the edges around face 0.
Cage with_crease_around(const std::vector<float>& sharpness, Cage cage) {
  const int size = cage.face_sizes[0];
  for (int i = 0; i < size; ++i)
    cage.crease(cage.corners[i], cage.corners[(i + 1) % size], sharpness[i % sharpness.size()]);
  return cage;
}

Cage with_crease(int a, int b, float sharpness, Cage cage) {
  cage.crease(a, b, sharpness);
  return cage;
}

Cage with_corner(int vertex, float sharpness, Cage cage) {
  cage.corner(vertex, sharpness);
  return cage;
}

Cage with_holes(std::vector<int> holes, Cage cage) {
  cage.holes = std::move(holes);
  return cage;
}

/// Face-varying values with a seam: every third face has values of its own.
Cage with_face_varying(Options::FVarLinearInterpolation interpolation, Cage cage) {
  cage.options.SetFVarLinearInterpolation(interpolation);
  const int vertex_count = static_cast<int>(cage.positions.size());
  cage.face_varying_count = vertex_count;
  std::size_t corner = 0;
  for (std::size_t face = 0; face < cage.face_sizes.size(); ++face)
    for (int i = 0; i < cage.face_sizes[face]; ++i, ++corner)
      cage.face_varying.push_back(face % 3 == 0 ? cage.face_varying_count++ : cage.corners[corner]);
  return cage;
}

void add_boundaries(std::vector<Cage>& cages) {
  const auto none = Options::VTX_BOUNDARY_NONE;
  const auto edges = Options::VTX_BOUNDARY_EDGE_ONLY;
  const auto corners = Options::VTX_BOUNDARY_EDGE_AND_CORNER;
  for (const auto& [boundary, name] :
       {std::pair{none, "none"}, std::pair{edges, "edges"}, std::pair{corners, "corners"}}) {
    cages.push_back(
        named(std::string("grid boundary ") + name, with_boundary(boundary, grid(5, 4))));
    cages.push_back(named(std::string("loop grid boundary ") + name,
                          with_boundary(boundary, as_loop(triangle_grid(5, 4)))));
  }
  cages.push_back(named("tube", with_boundary(edges, tube(6, 3))));
  cages.push_back(named("one quad", with_boundary(corners, grid(2, 2))));
  cages.push_back(named("mobius band", with_boundary(edges, mobius(7))));
  cages.push_back(named("pages on an edge", with_boundary(edges, fan_of_pages(3))));
  cages.push_back(named("pages on an edge, corners", with_boundary(corners, fan_of_pages(4))));
}

void add_sharp(std::vector<Cage>& cages) {
  cages.push_back(named("cube crease", with_crease_around({kInfinite}, cube())));
  cages.push_back(named("cube semi-sharp", with_crease_around({2.5f}, cube())));
  cages.push_back(
      named("cube mixed sharpness", with_crease_around({0.5f, 1.5f, kInfinite, 3.2f}, cube())));
  cages.push_back(named("cube dart", with_crease(0, 1, 3, cube())));
  cages.push_back(named("cube infinite corner", with_corner(0, kInfinite, cube())));
  cages.push_back(named("cube semi-sharp corner", with_corner(7, 1.7f, cube())));
  cages.push_back(
      named("cube corner on crease", with_corner(1, 2.5f, with_crease_around({1.2f}, cube()))));
  cages.push_back(named("torus crease", with_crease_around({kInfinite}, torus(6, 5))));
  cages.push_back(named("torus semi-sharp", with_crease(7, 8, 2.2f, torus(6, 5))));
  cages.push_back(
      named("loop icosahedron crease", as_loop(with_crease_around({kInfinite}, icosahedron()))));
  cages.push_back(
      named("loop icosahedron semi-sharp", as_loop(with_crease_around({1.4f}, icosahedron()))));
  cages.push_back(named("loop octahedron corner", as_loop(with_corner(4, 2.3f, bipyramid(4)))));
  Cage chaikin = with_crease_around({0.5f, 1.5f, 2.5f, 3.5f}, cube());
  chaikin.options.SetCreasingMethod(Options::CREASE_CHAIKIN);
  cages.push_back(named("cube chaikin", chaikin));
  Cage grid_crease = with_boundary(Options::VTX_BOUNDARY_EDGE_AND_CORNER, grid(5, 5));
  for (int x = 0; x < 4; ++x) grid_crease.crease(10 + x, 11 + x, 1.5f);
  cages.push_back(named("grid crease to boundary", grid_crease));
}

void add_topologies(std::vector<Cage>& cages) {
  cages.push_back(named("cube", cube()));
  cages.push_back(named("tetrahedron", tetrahedron()));
  cages.push_back(named("octahedron", bipyramid(4)));
  cages.push_back(named("pyramid of 7", pyramid(7)));
  cages.push_back(named("prism of 5", prism(5)));
  cages.push_back(named("prism of 12", prism(12)));
  cages.push_back(named("regular torus", torus(5, 4)));
  cages.push_back(named("sphere with poles of 24", sphere(24, 3)));
  cages.push_back(named("pillow of valence 2", pillow()));
  cages.push_back(named("cubes at a vertex", bow_tie()));
  cages.push_back(named("loop tetrahedron", as_loop(tetrahedron())));
  cages.push_back(named("loop icosahedron", as_loop(icosahedron())));
  cages.push_back(named("loop regular torus", as_loop(triangle_torus(6, 5))));
  cages.push_back(named("loop poles of 9", as_loop(bipyramid(9))));
  Cage smooth = bipyramid(4);
  smooth.options.SetTriangleSubdivision(Options::TRI_SUB_SMOOTH);
  cages.push_back(named("octahedron smooth triangles", smooth));
  cages.push_back(named("bilinear cube", as_bilinear(cube())));
  cages.push_back(named("bilinear prism of 5", as_bilinear(prism(5))));
  cages.push_back(named("torus with holes", with_holes({0, 7}, torus(6, 5))));
  cages.push_back(named("prism with a hole", with_holes({5}, prism(5))));
}

void add_face_varying(std::vector<Cage>& cages) {
  for (const auto& [interpolation, name] :
       {std::pair{Options::FVAR_LINEAR_NONE, "none"},
        std::pair{Options::FVAR_LINEAR_CORNERS_ONLY, "corners only"},
        std::pair{Options::FVAR_LINEAR_CORNERS_PLUS1, "corners plus 1"},
        std::pair{Options::FVAR_LINEAR_CORNERS_PLUS2, "corners plus 2"},
        std::pair{Options::FVAR_LINEAR_BOUNDARIES, "boundaries"},
        std::pair{Options::FVAR_LINEAR_ALL, "all"}})
    cages.push_back(
        named(std::string("face-varying ") + name, with_face_varying(interpolation, torus(5, 4))));
  cages.push_back(
      named("face-varying cube", with_face_varying(Options::FVAR_LINEAR_CORNERS_ONLY, cube())));
  cages.push_back(named("face-varying loop", with_face_varying(Options::FVAR_LINEAR_CORNERS_PLUS1,
                                                               as_loop(icosahedron()))));
  cages.push_back(named("face-varying bilinear",
                        with_face_varying(Options::FVAR_LINEAR_ALL, as_bilinear(prism(5)))));
}

}  // namespace

std::vector<Cage> all_cages() {
  std::vector<Cage> cages;
  add_topologies(cages);
  add_sharp(cages);
  add_boundaries(cages);
  add_face_varying(cages);
  return cages;
}

std::unique_ptr<Far::TopologyRefiner> make_refiner(const Cage& cage) {
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(cage.positions.size());
  descriptor.numFaces = static_cast<int>(cage.face_sizes.size());
  descriptor.numVertsPerFace = cage.face_sizes.data();
  descriptor.vertIndicesPerFace = cage.corners.data();
  descriptor.numCreases = static_cast<int>(cage.crease_sharpness.size());
  descriptor.creaseVertexIndexPairs = cage.crease_pairs.data();
  descriptor.creaseWeights = cage.crease_sharpness.data();
  descriptor.numCorners = static_cast<int>(cage.corner_sharpness.size());
  descriptor.cornerVertexIndices = cage.corner_vertices.data();
  descriptor.cornerWeights = cage.corner_sharpness.data();
  descriptor.numHoles = static_cast<int>(cage.holes.size());
  descriptor.holeIndices = cage.holes.data();
  Far::TopologyDescriptor::FVarChannel channel;
  channel.numValues = cage.face_varying_count;
  channel.valueIndices = cage.face_varying.data();
  if (cage.face_varying_count > 0) {
    descriptor.numFVarChannels = 1;
    descriptor.fvarChannels = &channel;
  }
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(cage.scheme, cage.options)));
  if (!refiner) throw std::runtime_error(cage.name + ": OpenSubdiv refuses the cage");
  return refiner;
}

}  // namespace planish::testing
