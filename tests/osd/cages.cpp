#include "osd/cages.h"

#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "osd/conformance.h"

namespace planish::testing {
namespace {

constexpr double kPi = std::numbers::pi;

std::array<float, 3> point(double x, double y, double z) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

// A point of a ring of `count` around z, at radius 1.
std::array<float, 3> on_ring(int i, int count, double radius, double z) {
  const double angle = 2 * kPi * i / count;
  return point(radius * std::cos(angle), radius * std::sin(angle), z);
}

// Quads of width x height vertices, with wrap-around where asked for.
void add_quads(Cage& cage, int width, int height, bool wrap_x, bool wrap_y) {
  for (int y = 0; y < (wrap_y ? height : height - 1); ++y)
    for (int x = 0; x < (wrap_x ? width : width - 1); ++x) {
      const int right = (x + 1) % width, up = (y + 1) % height;
      cage.add_face({y * width + x, y * width + right, up * width + right, up * width + x});
    }
}

// Every quad becomes two triangles.
Cage split(const Cage& quads) {
  Cage result = quads;
  result.face_sizes.clear();
  result.corners.clear();
  for (std::size_t i = 0; i < quads.corners.size(); i += 4) {
    const int* v = &quads.corners[i];
    result.add_face({v[0], v[1], v[2]});
    result.add_face({v[0], v[2], v[3]});
  }
  return result;
}

}  // namespace

void Cage::add_face(const std::vector<int>& vertices) {
  face_sizes.push_back(static_cast<int>(vertices.size()));
  corners.insert(corners.end(), vertices.begin(), vertices.end());
}

void Cage::crease(int a, int b, float sharpness) {
  crease_pairs.insert(crease_pairs.end(), {a, b});
  crease_sharpness.push_back(sharpness);
}

void Cage::corner(int vertex, float sharpness) {
  corner_vertices.push_back(vertex);
  corner_sharpness.push_back(sharpness);
}

Cage cube() {
  Cage cage;
  for (int i = 0; i < 8; ++i) cage.positions.push_back(point(i & 1, (i >> 1) & 1, (i >> 2) & 1));
  for (const auto& face : std::vector<std::vector<int>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    cage.add_face(face);
  return cage;
}

Cage tetrahedron() {
  Cage cage;
  cage.positions = {point(1, 1, 1), point(1, -1, -1), point(-1, 1, -1), point(-1, -1, 1)};
  for (const auto& face : std::vector<std::vector<int>>{{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}})
    cage.add_face(face);
  return cage;
}

Cage bipyramid(int sides) {
  Cage cage;
  for (int i = 0; i < sides; ++i) cage.positions.push_back(on_ring(i, sides, 1, 0));
  cage.positions.push_back(point(0, 0, 1.2));
  cage.positions.push_back(point(0.1, 0, -0.9));
  for (int i = 0; i < sides; ++i) {
    cage.add_face({i, (i + 1) % sides, sides});
    cage.add_face({(i + 1) % sides, i, sides + 1});
  }
  return cage;
}

Cage icosahedron() {
  Cage cage;
  for (int i = 0; i < 5; ++i) cage.positions.push_back(on_ring(i, 5, 1, -0.5));
  for (int i = 0; i < 5; ++i) cage.positions.push_back(on_ring(2 * i + 1, 10, 1, 0.5));
  cage.positions.push_back(point(0, 0, -1.1));
  cage.positions.push_back(point(0, 0, 1.1));
  for (int i = 0; i < 5; ++i) {
    const int next = (i + 1) % 5;
    cage.add_face({next, i, 10});
    cage.add_face({i, next, 5 + i});
    cage.add_face({5 + next, 5 + i, next});
    cage.add_face({5 + i, 5 + next, 11});
  }
  return cage;
}

Cage pyramid(int sides) {
  Cage cage;
  std::vector<int> base;
  for (int i = 0; i < sides; ++i) {
    cage.positions.push_back(on_ring(i, sides, 1, 0));
    base.insert(base.begin(), i);
  }
  cage.positions.push_back(point(0.1, 0.05, 1.3));
  for (int i = 0; i < sides; ++i) cage.add_face({i, (i + 1) % sides, sides});
  cage.add_face(base);
  return cage;
}

Cage prism(int sides) {
  Cage cage;
  std::vector<int> bottom, top;
  for (int i = 0; i < 2 * sides; ++i)
    cage.positions.push_back(on_ring(i % sides, sides, i < sides ? 1 : 0.8, i < sides ? 0 : 1));
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    cage.add_face({i, next, sides + next, sides + i});
    bottom.insert(bottom.begin(), i);
    top.push_back(sides + i);
  }
  cage.add_face(bottom);
  cage.add_face(top);
  return cage;
}

Cage torus(int width, int height) {
  Cage cage;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double angle = 2 * kPi * y / height;
      cage.positions.push_back(on_ring(x, width, 1 + 0.4 * std::cos(angle), 0.4 * std::sin(angle)));
    }
  add_quads(cage, width, height, true, true);
  return cage;
}

Cage triangle_torus(int width, int height) { return split(torus(width, height)); }

Cage sphere(int around, int rings) {
  Cage cage;
  for (int y = 0; y < rings; ++y)
    for (int x = 0; x < around; ++x) {
      const double angle = kPi * (y + 1) / (rings + 1);
      cage.positions.push_back(on_ring(x, around, std::sin(angle), -std::cos(angle)));
    }
  add_quads(cage, around, rings, true, false);
  const int south = around * rings, last = around * (rings - 1);
  cage.positions.push_back(point(0, 0, -1));
  cage.positions.push_back(point(0, 0, 1));
  for (int x = 0; x < around; ++x) {
    const int next = (x + 1) % around;
    cage.add_face({next, x, south});
    cage.add_face({last + x, last + next, south + 1});
  }
  return cage;
}

Cage grid(int width, int height) {
  Cage cage;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      cage.positions.push_back(
          point(x - width / 2.0, y - height / 2.0, 0.5 * std::sin(x + 2.0 * y)));
  add_quads(cage, width, height, false, false);
  return cage;
}

Cage triangle_grid(int width, int height) { return split(grid(width, height)); }

Cage tube(int around, int height) {
  Cage cage;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < around; ++x)
      cage.positions.push_back(on_ring(x, around, 1 + 0.1 * y, 0.6 * y));
  add_quads(cage, around, height, true, false);
  return cage;
}

Cage mobius(int around) {
  Cage cage;
  for (int x = 0; x < around; ++x)
    for (int side : {-1, 1}) {
      const double turn = kPi * x / around;
      cage.positions.push_back(
          on_ring(x, around, 1 + 0.3 * side * std::cos(turn), 0.3 * side * std::sin(turn)));
    }
  for (int x = 0; x + 1 < around; ++x) cage.add_face({2 * x, 2 * x + 2, 2 * x + 3, 2 * x + 1});
  cage.add_face({2 * around - 2, 1, 0, 2 * around - 1});
  return cage;
}

Cage pillow() {
  Cage cage;
  for (int i = 0; i < 4; ++i) cage.positions.push_back(on_ring(i, 4, 1, 0.2 * (i % 2)));
  cage.add_face({0, 1, 2, 3});
  cage.add_face({3, 2, 1, 0});
  return cage;
}

Cage fan_of_pages(int pages) {
  Cage cage;
  cage.positions = {point(0, 0, 0), point(0, 0, 1)};
  for (int i = 0; i < pages; ++i) {
    const int outer = static_cast<int>(cage.positions.size());
    cage.positions.push_back(on_ring(i, pages, 1, 0));
    cage.positions.push_back(on_ring(i, pages, 1.1, 1));
    cage.add_face({0, outer, outer + 1, 1});
  }
  return cage;
}

Cage bow_tie() {
  Cage cage = cube();
  const Cage other = cube();
  // Its corner 0 is the first one's corner 7.
  const auto moved = [](int vertex) { return vertex == 0 ? 7 : 7 + vertex; };
  for (std::size_t i = 1; i < other.positions.size(); ++i) {
    std::array<float, 3> position = other.positions[i];
    for (float& coordinate : position) coordinate += 1;
    cage.positions.push_back(position);
  }
  for (std::size_t i = 0; i < other.corners.size(); i += 4)
    cage.add_face({moved(other.corners[i]), moved(other.corners[i + 1]),
                   moved(other.corners[i + 2]), moved(other.corners[i + 3])});
  return cage;
}

namespace {

using namespace OpenSubdiv;
using Options = Sdc::Options;

const float kInfinite = Sdc::Crease::SHARPNESS_INFINITE;

void add_named(std::vector<Cage>& cages, const std::vector<std::pair<std::string, Cage>>& named) {
  for (const auto& [name, cage] : named) cages.emplace_back(cage).name = name;
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

// Sharpness of the edges around face 0.
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

// Face-varying values with a seam: every third face has values of its own.
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
    add_named(cages, {{std::string("grid boundary ") + name, with_boundary(boundary, grid(5, 4))},
                      {std::string("loop grid boundary ") + name,
                       with_boundary(boundary, as_loop(triangle_grid(5, 4)))}});
  }
  add_named(cages, {{"tube", with_boundary(edges, tube(6, 3))},
                    {"one quad", with_boundary(corners, grid(2, 2))},
                    {"mobius band", with_boundary(edges, mobius(7))},
                    {"pages on an edge", with_boundary(edges, fan_of_pages(3))},
                    {"pages on an edge, corners", with_boundary(corners, fan_of_pages(4))}});
}

void add_sharp(std::vector<Cage>& cages) {
  Cage chaikin = with_crease_around({0.5f, 1.5f, 2.5f, 3.5f}, cube());
  chaikin.options.SetCreasingMethod(Options::CREASE_CHAIKIN);
  Cage grid_crease = with_boundary(Options::VTX_BOUNDARY_EDGE_AND_CORNER, grid(5, 5));
  for (int x = 0; x < 4; ++x) grid_crease.crease(10 + x, 11 + x, 1.5f);
  const Cage icosahedral = as_loop(icosahedron());
  add_named(cages,
            {{"cube crease", with_crease_around({kInfinite}, cube())},
             {"cube semi-sharp", with_crease_around({2.5f}, cube())},
             {"cube mixed sharpness", with_crease_around({0.5f, 1.5f, kInfinite, 3.2f}, cube())},
             {"cube dart", with_crease(0, 1, 3, cube())},
             {"cube infinite corner", with_corner(0, kInfinite, cube())},
             {"cube semi-sharp corner", with_corner(7, 1.7f, cube())},
             {"cube corner on crease", with_corner(1, 2.5f, with_crease_around({1.2f}, cube()))},
             {"torus crease", with_crease_around({kInfinite}, torus(6, 5))},
             {"torus semi-sharp", with_crease(7, 8, 2.2f, torus(6, 5))},
             {"loop icosahedron crease", with_crease_around({kInfinite}, icosahedral)},
             {"loop icosahedron semi-sharp", with_crease_around({1.4f}, icosahedral)},
             {"loop octahedron corner", as_loop(with_corner(4, 2.3f, bipyramid(4)))},
             {"cube chaikin", chaikin},
             {"grid crease to boundary", grid_crease}});
}

void add_topologies(std::vector<Cage>& cages) {
  Cage smooth = bipyramid(4);
  smooth.options.SetTriangleSubdivision(Options::TRI_SUB_SMOOTH);
  add_named(cages, {{"cube", cube()},
                    {"tetrahedron", tetrahedron()},
                    {"octahedron", bipyramid(4)},
                    {"pyramid of 7", pyramid(7)},
                    {"prism of 5", prism(5)},
                    {"prism of 12", prism(12)},
                    {"regular torus", torus(5, 4)},
                    {"sphere with poles of 24", sphere(24, 3)},
                    {"pillow of valence 2", pillow()},
                    {"cubes at a vertex", bow_tie()},
                    {"loop tetrahedron", as_loop(tetrahedron())},
                    {"loop icosahedron", as_loop(icosahedron())},
                    {"loop regular torus", as_loop(triangle_torus(6, 5))},
                    {"loop poles of 9", as_loop(bipyramid(9))},
                    {"octahedron smooth triangles", smooth},
                    {"bilinear cube", as_bilinear(cube())},
                    {"bilinear prism of 5", as_bilinear(prism(5))},
                    {"torus with holes", with_holes({0, 7}, torus(6, 5))},
                    {"prism with a hole", with_holes({5}, prism(5))}});
}

void add_face_varying(std::vector<Cage>& cages) {
  for (const auto& [interpolation, name] :
       {std::pair{Options::FVAR_LINEAR_NONE, "none"},
        std::pair{Options::FVAR_LINEAR_CORNERS_ONLY, "corners only"},
        std::pair{Options::FVAR_LINEAR_CORNERS_PLUS1, "corners plus 1"},
        std::pair{Options::FVAR_LINEAR_CORNERS_PLUS2, "corners plus 2"},
        std::pair{Options::FVAR_LINEAR_BOUNDARIES, "boundaries"},
        std::pair{Options::FVAR_LINEAR_ALL, "all"}})
    add_named(cages, {{std::string("face-varying ") + name,
                       with_face_varying(interpolation, torus(5, 4))}});
  add_named(cages,
            {{"face-varying cube", with_face_varying(Options::FVAR_LINEAR_CORNERS_ONLY, cube())},
             {"face-varying loop",
              with_face_varying(Options::FVAR_LINEAR_CORNERS_PLUS1, as_loop(icosahedron()))},
             {"face-varying bilinear",
              with_face_varying(Options::FVAR_LINEAR_ALL, as_bilinear(prism(5)))}});
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

namespace {

constexpr float kGridPlaces[] = {0.0f, 0.125f, 0.5f, 0.8f, 1.0f};

// The stencils of `table` and after them those of the patches' own points, which may be none.
std::unique_ptr<const Far::StencilTable> with_local_points(const Far::TopologyRefiner& refiner,
                                                           const Far::StencilTable* table,
                                                           const Far::StencilTable* local,
                                                           int channel) {
  std::unique_ptr<const Far::StencilTable> stencils(table);
  if (!local) return stencils;
  const Far::StencilTable* both =
      channel < 0 ? Far::StencilTableFactory::AppendLocalPointStencilTable(refiner, table, local)
                  : Far::StencilTableFactory::AppendLocalPointStencilTableFaceVarying(
                        refiner, table, local, channel);
  if (both) stencils.reset(both);
  return stencils;
}

// Five by five places on every face, corners among them.
std::unique_ptr<const Far::LimitStencilTable> limit_table(const Refined& refined) {
  Far::LimitStencilTableFactory::LocationArrayVec locations;
  std::vector<float> s, t;
  const bool triangles = refined.refiner->GetSchemeType() == Sdc::SCHEME_LOOP;
  for (const float u : kGridPlaces)
    for (const float v : kGridPlaces) {
      if (triangles && u + v > 1) continue;
      s.push_back(u);
      t.push_back(v);
    }
  const int face_count = refined.patches->GetNumPtexFaces();
  for (int face = 0; face < face_count; ++face) {
    Far::LimitStencilTableFactory::LocationArray places;
    places.ptexIdx = face;
    places.numLocations = static_cast<int>(s.size());
    places.s = s.data();
    places.t = t.data();
    locations.push_back(places);
  }
  Far::LimitStencilTableFactory::Options options;
  options.generate1stDerivatives = true;
  options.generate2ndDerivatives = true;
  return std::unique_ptr<const Far::LimitStencilTable>(Far::LimitStencilTableFactory::Create(
      *refined.refiner, locations, nullptr, nullptr, options));
}

}  // namespace

Refined refine(const Cage& cage, const RefineOptions& options) {
  Refined refined;
  refined.refiner = make_refiner(cage);
  if (options.adaptive) {
    Far::TopologyRefiner::AdaptiveOptions adaptive = options.patches.GetRefineAdaptiveOptions();
    adaptive.isolationLevel = options.level;
    adaptive.considerFVarChannels = cage.face_varying_count > 0;
    refined.refiner->RefineAdaptive(adaptive);
  } else {
    Far::TopologyRefiner::UniformOptions uniform(options.level);
    uniform.fullTopologyInLastLevel = true;
    refined.refiner->RefineUniform(uniform);
  }
  Far::PatchTableFactory::Options patch_options = options.patches;
  patch_options.generateVaryingTables = true;
  patch_options.includeFVarBaseLevelIndices = true;
  patch_options.generateFVarTables = cage.face_varying_count > 0;
  patch_options.generateFVarLegacyLinearPatches = !options.adaptive;
  refined.patches.reset(Far::PatchTableFactory::Create(*refined.refiner, patch_options));

  const Far::TopologyRefiner& refiner = *refined.refiner;
  Far::StencilTableFactory::Options stencils;
  stencils.generateIntermediateLevels = options.adaptive;
  stencils.generateOffsets = true;
  refined.vertices = with_local_points(refiner, Far::StencilTableFactory::Create(refiner, stencils),
                                       refined.patches->GetLocalPointStencilTable(), -1);
  stencils.interpolationMode = Far::StencilTableFactory::INTERPOLATE_VARYING;
  refined.varying = with_local_points(refiner, Far::StencilTableFactory::Create(refiner, stencils),
                                      refined.patches->GetLocalPointVaryingStencilTable(), -1);
  if (cage.face_varying_count > 0) {
    stencils.interpolationMode = Far::StencilTableFactory::INTERPOLATE_FACE_VARYING;
    refined.face_varying =
        with_local_points(refiner, Far::StencilTableFactory::Create(refiner, stencils),
                          refined.patches->GetLocalPointFaceVaryingStencilTable(), 0);
  }
  refined.limits = limit_table(refined);
  return refined;
}

bool Patch::is_triangle() const {
  using Far::PatchDescriptor;
  return type == PatchDescriptor::TRIANGLES || type == PatchDescriptor::LOOP ||
         type == PatchDescriptor::GREGORY_TRIANGLE;
}

Osd::PatchCoord Patch::coord(float u, float v) const {
  if (is_triangle())
    param.UnnormalizeTriangle(u, v);
  else
    param.Unnormalize(u, v);
  return {handle, u, v};
}

std::vector<Patch> patches_of(const Far::PatchTable& table) {
  std::vector<Patch> patches;
  for (int array = 0; array < table.GetNumPatchArrays(); ++array) {
    const Far::PatchDescriptor descriptor = table.GetPatchArrayDescriptor(array);
    for (int local = 0; local < table.GetNumPatches(array); ++local) {
      Patch& patch = patches.emplace_back();
      patch.handle.arrayIndex = array;
      patch.handle.patchIndex = static_cast<int>(patches.size()) - 1;
      patch.handle.vertIndex = local * descriptor.GetNumControlVertices();
      patch.param = table.GetPatchParam(patch.handle);
      patch.type = descriptor.GetType();
    }
  }
  return patches;
}

}  // namespace planish::testing
