#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "planish/adaptive/adaptive_blocks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/queries/surface_queries.h"

namespace py = pybind11;

namespace planish::python {
namespace {

/// planish.LimitSurface: the queries, with all that they read.
struct PythonLimit {
  FitHandle fit;
  EditorHandle editor;                   ///< whose surface it is, or null
  std::shared_ptr<PythonEdited> edited;  ///< what that was when it was asked for
  std::unique_ptr<LimitSurface> own_surface;
  std::unique_ptr<SurfaceQueries> own_queries;
  const LimitSurface* surface = nullptr;
  const SurfaceQueries* queries = nullptr;

  /// Runs a question without Python's lock, while an editor must not move.
  void ask(const std::function<void()>& question) const {
    std::optional<EditorUse> use;
    if (editor) use.emplace(*editor, EditorUse::Kind::Reads);
    run_released(
        {}, [&](const Callbacks&) { question(); }, fit->threads);
  }
};

std::unique_ptr<PythonLimit> limit_of(const FitHandle& fit) {
  if (fit->fitted.options.scheme != Scheme::DooSabin)
    refuse("LimitSurface: is of Doo-Sabin surfaces; fit with scheme=\"doo-sabin\"");
  auto made = std::make_unique<PythonLimit>();
  made->fit = fit;
  run_released(
      {},
      [&](const Callbacks&) {
        const FittedMesh& fitted = fit->fitted;
        made->own_surface = std::make_unique<LimitSurface>(
            fitted_surface(fitted.mesh, fitted.fit, fitted.evaluate_options()));
        made->own_queries = std::make_unique<SurfaceQueries>(*made->own_surface);
      },
      fit->threads);
  made->surface = made->own_surface.get();
  made->queries = made->own_queries.get();
  return made;
}

// An array of one point of each answer, by `get`.
template <class Answer, class Get>
py::array_t<double> points_by(const std::vector<Answer>& answers, const Get& get) {
  std::vector<double> values;
  values.reserve(3 * answers.size());
  for (const Answer& answer : answers) {
    const glm::dvec3 point = get(answer);
    values.insert(values.end(), {point.x, point.y, point.z});
  }
  return take_over(std::move(values), {static_cast<py::ssize_t>(answers.size()), 3});
}

template <class Value, class Answer, class Get>
py::array_t<Value> numbers_by(const std::vector<Answer>& answers, const Get& get) {
  std::vector<Value> values;
  values.reserve(answers.size());
  for (const Answer& answer : answers) values.push_back(get(answer));
  return take_over(std::move(values), {static_cast<py::ssize_t>(answers.size())});
}

template <class Answer>
void add_places(py::dict& result, const std::vector<Answer>& answers) {
  using A = const Answer&;
  result["position"] = points_by(answers, [](A a) { return a.position; });
  result["normal"] = points_by(answers, [](A a) { return a.normal; });
  result["face"] = numbers_by<std::int32_t>(answers, [](A a) { return a.at.face; });
  result["u"] = numbers_by<double>(answers, [](A a) { return a.at.u; });
  result["v"] = numbers_by<double>(answers, [](A a) { return a.at.v; });
}

std::vector<SurfaceParameter> places_of(const py::object& faces, const py::object& u,
                                        const py::object& v) {
  const Integers face = as_integers(faces, "faces");
  const Doubles us = as_numbers(u, "u"), vs = as_numbers(v, "v");
  if (face.ndim() != 1 || face.size() != us.size() || us.size() != vs.size())
    refuse("faces, u, v: one number of each for every place is wanted");
  std::vector<SurfaceParameter> places(static_cast<std::size_t>(face.size()));
  for (std::size_t i = 0; i < places.size(); ++i)
    places[i] = {face.data()[i], us.data()[i], vs.data()[i]};
  return places;
}

py::dict attributes_at(const PythonLimit& limit, const py::object& faces, const py::object& u,
                       const py::object& v) {
  const std::vector<SurfaceParameter> places = places_of(faces, u, v);
  const std::vector<VertexAttribute>& given = limit.surface->surface().mesh().attributes;
  std::vector<std::vector<float>> values(given.size());
  limit.ask([&] {
    for (std::size_t k = 0; k < given.size(); ++k)
      values[k] = attribute_at(*limit.surface, k, places);
  });
  py::dict result;
  for (std::size_t k = 0; k < given.size(); ++k) {
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(places.size())};
    if (given[k].width > 1) shape.push_back(given[k].width);
    result[py::str(given[k].name)] = take_over(std::move(values[k]), shape);
  }
  return result;
}

py::dict evaluate_limit(const PythonLimit& limit, const py::object& faces, const py::object& u,
                        const py::object& v) {
  const std::vector<SurfaceParameter> places = places_of(faces, u, v);
  std::vector<SurfacePoint> points(places.size());
  limit.ask([&] { limit.surface->evaluate(places, points); });
  using P = const SurfacePoint&;
  py::dict result;
  result["position"] = points_by(points, [](P p) { return p.position; });
  result["normal"] = points_by(points, [](P p) { return p.normal; });
  result["du"] = points_by(points, [](P p) { return p.du; });
  result["dv"] = points_by(points, [](P p) { return p.dv; });
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  result["mean_curvature"] = numbers_by<double>(points, [](P p) {
    const PointCurvature curvature = p.curvature();
    return curvature.is_known ? curvature.mean : kNone;
  });
  result["gaussian_curvature"] = numbers_by<double>(points, [](P p) {
    const PointCurvature curvature = p.curvature();
    return curvature.is_known ? curvature.gaussian : kNone;
  });
  return result;
}

py::dict closest_points(const PythonLimit& limit, const py::object& points) {
  const Doubles values = as_points(points, "points");
  const auto given = points_of(values);
  std::vector<ClosestPoint> found(given.size());
  limit.ask([&] { limit.queries->closest(given, found); });
  py::dict result;
  add_places(result, found);
  result["distance"] = numbers_by<double>(found, [](const ClosestPoint& a) { return a.distance; });
  return result;
}

py::dict first_hits(const PythonLimit& limit, const py::object& origins,
                    const py::object& directions) {
  const Doubles origin_values = as_points(origins, "origins"),
                direction_values = as_points(directions, "directions");
  const auto from = points_of(origin_values), along = points_of(direction_values);
  if (from.size() != along.size())
    refuse(formatted("directions: {} for {} origins", along.size(), from.size()));
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<SurfaceHit> hits(from.size());
  limit.ask([&] {
    constexpr std::size_t kGrain = 64;
    parallel_each(hits.size(), kGrain, [&](std::size_t i) {
      const glm::dvec3 none(kNone);
      hits[i] = limit.queries->first_hit({from[i], along[i]})
                    .value_or(SurfaceHit{{-1, kNone, kNone}, none, none, kNone, false});
    });
  });
  py::dict result;
  add_places(result, hits);
  result["t"] = numbers_by<double>(hits, [](const SurfaceHit& hit) { return hit.t; });
  return result;
}

}  // namespace

py::object limit_surface_of(const EditorHandle& editor) {
  auto made = std::make_unique<PythonLimit>();
  made->edited = editor->edited;
  made->fit = made->edited->first;
  made->editor = editor;
  const EditorUse use(*editor, EditorUse::Kind::Changes);
  run_released(
      {}, [&](const Callbacks&) { made->queries = &made->edited->editor.queries(); },
      made->fit->threads);
  made->surface = &made->queries->surface();
  return py::cast(std::move(made));
}

void add_limit(py::module_& module) {
  py::class_<PythonLimit>(module, "LimitSurface",
                          "The limit surface of a Fit as a function, exact to rounding. Places are "
                          "(face, u, v): a face of fit.mesh, and parameters as OpenSubdiv's "
                          "Bfr::Parameterization has them.")
      .def(py::init(&limit_of), py::arg("fit").none(false))
      .def("evaluate", &evaluate_limit, py::arg("faces"), py::arg("u"), py::arg("v"),
           "Arrays by name for n places: position, normal, du, dv (n, 3); mean_curvature, "
           "gaussian_curvature (n,), NaN where there is none. Raises InvalidArgument for places "
           "outside.")
      .def("attributes", &attributes_at, py::arg("faces"), py::arg("u"), py::arg("v"),
           "The attributes of fit.mesh at n places: {name: float32 (n,) or (n, k)}. Raises "
           "InvalidArgument for places outside.")
      .def("closest_point", &closest_points, py::arg("points"),
           "Arrays by name for points (n, 3): position, normal (n, 3); face, u, v, distance (n,).")
      .def("rays", &first_hits, py::arg("origins"), py::arg("directions"),
           "What rays (n, 3) meet first: position, normal (n, 3); face, u, v and t (n,), at origin "
           "+ t direction. face is -1 and the rest NaN where a ray meets nothing.");
}

}  // namespace planish::python
