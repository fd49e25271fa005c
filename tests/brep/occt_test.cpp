// STEP as OpenCASCADE reads it, which shares no code with the writer.
#include <gtest/gtest.h>

#ifndef PLANISH_HAS_OCCT

TEST(OpenCascade, ReadsWhatIsWritten) {
  GTEST_SKIP() << "OpenCASCADE is not installed: libocct-data-exchange-dev "
                  "libocct-modeling-algorithms-dev";
}

#else

#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBndLib.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <STEPControl_Reader.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <algorithm>
#include <filesystem>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>

#include "analytic/analytic_case.h"
#include "analytic/mixed_shapes.h"
#include "analytic/profile.h"
#include "limit/limit_case.h"
#include "planish/brep/analytic_faces.h"
#include "planish/brep/brep.h"
#include "planish/brep/subdivision_splines.h"
#include "planish/brep/write_step.h"
#include "planish/pipeline/write_fitted_step.h"

namespace planish::test {
namespace {

TopoDS_Shape shape_of(const Brep& brep, double diagonal) {
  // Tests run beside one another.
  const char* const test = testing::UnitTest::GetInstance()->current_test_info()->name();
  const auto path =
      (std::filesystem::path(testing::TempDir()) / (std::string(test) + ".step")).string();
  write_step(path, brep, {.diagonal = diagonal});
  STEPControl_Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) return {};
  reader.TransferRoots();
  return reader.OneShape();
}

TopoDS_Shape shape_of(const LimitCase& c) {
  return shape_of(make_brep(c.limit), c.surface->placement().diagonal);
}
TopoDS_Shape catmull_clark_shape(const PolygonMesh& mesh) {
  const CatmullClarkSplines splines(mesh, {});
  return shape_of(make_brep(splines), splines.placement().diagonal);
}

std::vector<TopoDS_Shape> parts(const TopoDS_Shape& shape, TopAbs_ShapeEnum kind) {
  TopTools_IndexedMapOfShape map;
  TopExp::MapShapes(shape, kind, map);
  std::vector<TopoDS_Shape> all;
  for (int i = 1; i <= map.Extent(); ++i) all.push_back(map(i));
  return all;
}

double volume(const TopoDS_Shape& shape) {
  GProp_GProps properties;
  BRepGProp::VolumeProperties(shape, properties, 1e-7);
  return properties.Mass();
}

// Of fine triangles, to second order in their size, by the surface of a level.
template <class OfLevel>
double volume_by(const OfLevel& surface) {
  const auto of_level = [&](int level) {
    const SurfaceMesh fine = surface(level);
    double sum = 0;
    for (std::int64_t f = 0; f < fine.face_count(); ++f) {
      const std::int32_t* const v = fine.face_vertices.data() + 4 * f;
      for (const int k : {1, 2})
        sum += glm::dot(fine.positions[v[0]],
                        glm::cross(fine.positions[v[k]], fine.positions[v[k + 1]])) /
               6;
    }
    return sum;
  };
  return (4 * of_level(5) - of_level(4)) / 3;
}
double volume(const LimitCase& c) {
  return volume_by([&](int level) { return c.tessellated(level); });
}

void expect_valid(const TopoDS_Shape& shape) {
  EXPECT_TRUE(BRepCheck_Analyzer(shape, Standard_True).IsValid());
  for (const TopoDS_Shape& edge : parts(shape, TopAbs_EDGE))
    ASSERT_LE(BRep_Tool::Tolerance(TopoDS::Edge(edge)), 1e-6);
  for (const TopoDS_Shape& vertex : parts(shape, TopAbs_VERTEX))
    ASSERT_LE(BRep_Tool::Tolerance(TopoDS::Vertex(vertex)), 1e-6);
}

std::vector<NamedMesh> solids() {
  PolygonMesh creased = cube();
  creased.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  return {{"cube", cube()},    {"creased cube", creased},   {"torus", torus(9, 7, 3, 1)},
          {"prism", prism(5)}, {"icosphere", icosphere(1)}, {"hub", bipyramid(9)}};
}

void expect_solid(const TopoDS_Shape& shape, double wanted) {
  ASSERT_EQ(parts(shape, TopAbs_SOLID).size(), 1u);
  for (const TopoDS_Shape& shell : parts(shape, TopAbs_SHELL))
    EXPECT_TRUE(BRep_Tool::IsClosed(shell));
  expect_valid(shape);
  EXPECT_NEAR(volume(shape), wanted, 1e-5 * std::abs(wanted));
}

TEST(OpenCascade, ReadsSolidsOfTheSurfacesVolume) {
  for (const auto& [name, mesh] : solids()) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    expect_solid(shape_of(c), volume(c));
  }
}

TEST(OpenCascade, ReadsSolidsOfCatmullClarkSurfaces) {
  for (const auto& [name, mesh] : solids()) {
    SCOPED_TRACE(name);
    expect_solid(catmull_clark_shape(mesh), volume_by([&mesh = mesh](int level) {
                   return evaluate(mesh, *make_cpu_backend(),
                                   {.level = level, .scheme = Scheme::CatmullClark});
                 }));
  }
}

// Of a shaft with a cone and a fillet, a ball and a ring: faces of the kinds that they are, whose
// volume is the formula's and not that of their triangles.
TEST(OpenCascade, ReadsAnalyticFaces) {
  constexpr double kPi = std::numbers::pi;
  struct Case {
    PolygonMesh mesh;
    std::vector<GeomAbs_SurfaceType> kinds;
    double volume;
  };
  for (const auto& [mesh, kinds, wanted] :
       {Case{Profile({0, 0}).line({2, 0}).line({2, 3}).line({1, 4}).line({0, 4}).turned(32),
             {GeomAbs_Plane, GeomAbs_Plane, GeomAbs_Cylinder, GeomAbs_Cone},
             kPi * (4 * 3 + (4 + 2 + 1) / 3.0)},
        Case{Profile({0, -1}).arc({0, 0}, 1, -kPi / 2, kPi / 2, 16).turned(32),
             {GeomAbs_Sphere},
             4 * kPi / 3},
        Case{Profile({0, 0})
                 .line({2, 0})
                 .line({2, 1})
                 .arc({1, 1}, 1, 0, kPi / 2, 8)
                 .line({0, 2})
                 .turned(32),
             {GeomAbs_Plane, GeomAbs_Plane, GeomAbs_Cylinder, GeomAbs_Torus},
             // By Pappus, of a quarter disc and what is inside.
             kPi * (4 + 1) + 2 * kPi * (1 + 4 / (3 * kPi)) * kPi / 4}}) {
    AnalyticFaces made = analytic_faces_of(mesh);
    find_shells(MeshTopology(mesh), mesh.positions, made.face_of, made.brep);
    const TopoDS_Shape shape = shape_of(made.brep, placement_of(mesh).diagonal);
    expect_solid(shape, wanted);
    std::vector<GeomAbs_SurfaceType> found;
    for (const TopoDS_Shape& face : parts(shape, TopAbs_FACE))
      found.push_back(BRepAdaptor_Surface(TopoDS::Face(face)).GetType());
    std::ranges::sort(found);
    EXPECT_EQ(found, kinds);
  }
}

// By a box through it that reaches this far.
void expect_cuts(const TopoDS_Shape& shape, double reach) {
  const TopoDS_Shape box =
      BRepPrimAPI_MakeBox(gp_Pnt(0.1234, -reach, -reach), gp_Pnt(reach, reach, reach)).Shape();
  BRepAlgoAPI_Cut outside(shape, box);
  BRepAlgoAPI_Common inside(shape, box);
  ASSERT_TRUE(outside.IsDone() && inside.IsDone());
  EXPECT_TRUE(BRepCheck_Analyzer(outside.Shape()).IsValid());
  EXPECT_GT(volume(outside.Shape()), 0.1);
  EXPECT_GT(volume(inside.Shape()), 0.1);
  EXPECT_NEAR(volume(outside.Shape()) + volume(inside.Shape()), volume(shape),
              1e-5 * volume(shape));
}

// Beside freeform faces: the volume is that of a fine mesh of the surface, nearly.
TEST(OpenCascade, ReadsFreeformFacesBesideAnalyticOnes) {
  for (const MixedShape& shape : mixed_shapes()) {
    SCOPED_TRACE(shape.name);
    const FittedMesh fitted = fit_mesh(shape.mesh, "part", *make_cpu_backend());
    const auto path = (std::filesystem::path(testing::TempDir()) / "mixed_occt.step").string();
    const StepFigures figures = write_fitted_step(path, fitted, {});
    ASSERT_EQ(figures.mixed_parts, 1);
    STEPControl_Reader reader;
    ASSERT_EQ(reader.ReadFile(path.c_str()), IFSelect_RetDone);
    reader.TransferRoots();
    const TopoDS_Shape solid = reader.OneShape();
    EXPECT_TRUE(BRepCheck_Analyzer(solid).IsValid());
    EXPECT_EQ(parts(solid, TopAbs_SOLID).size(), 1u);
    EXPECT_EQ(std::ssize(parts(solid, TopAbs_FACE)), figures.faces);
    const double wanted = volume_by([&](int level) {
      return evaluate(fitted.mesh, fitted.fit, *make_cpu_backend(), fitted.evaluate_options(level));
    });
    EXPECT_NEAR(volume(solid), wanted, 5e-3 * wanted);
    if (shape.name != "cylinder") continue;  // cuts take long
    expect_cuts(solid, 100);
  }
}

TEST(OpenCascade, CutsThemByABox) {
  for (const TopoDS_Shape& shape :
       {shape_of(LimitCase(cube())), shape_of(LimitCase(torus(9, 7, 3, 1))),
        catmull_clark_shape(cube()), catmull_clark_shape(prism(5))}) {
    expect_cuts(shape, 10);
  }
}

TEST(OpenCascade, ReadsOpenShells) {
  const TopoDS_Shape shape = shape_of(LimitCase(
      grid(6, 5, [](double x, double y) { return glm::dvec3(x, y, 0.3 * x * y - 0.1 * x * x); })));
  EXPECT_TRUE(parts(shape, TopAbs_SOLID).empty());
  ASSERT_EQ(parts(shape, TopAbs_SHELL).size(), 1u);
  EXPECT_FALSE(BRep_Tool::IsClosed(parts(shape, TopAbs_SHELL).front()));
  expect_valid(shape);
}

}  // namespace
}  // namespace planish::test

#endif
