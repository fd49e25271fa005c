#include <utility>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "planish/core/words.h"
#include "planish/edit/editor.h"

namespace py = pybind11;

namespace planish::python {
namespace {

/// planish.Change: what an EditChange names, which the editor's next call would end.
struct PythonChange {
  std::vector<std::int32_t> vertices, control_points;
  std::vector<RowRange> rows;
  std::int64_t row_count = 0;
  bool is_whole = false;

  explicit PythonChange(const EditChange& change)
      : vertices(change.vertices.begin(), change.vertices.end()),
        control_points(change.control_points.begin(), change.control_points.end()),
        rows(change.rows.begin(), change.rows.end()),
        row_count(change.row_count),
        is_whole(change.is_whole) {}
};

template <class Work>
void reading(PythonEditor& self, const Work& work) {
  const EditorUse use(self, EditorUse::Kind::Reads);
  run_released({}, work, self.first().threads);
}

template <class Work>
std::unique_ptr<PythonChange> changed(PythonEditor& self, const Work& work,
                                      const PythonCallbacks& python = {}) {
  std::unique_ptr<PythonChange> result;
  const EditorUse use(self, EditorUse::Kind::Changes);
  run_released(
      python,
      [&](const Callbacks& callbacks) {
        result = std::make_unique<PythonChange>(work(self.editor(), callbacks));
      },
      self.first().threads);
  return result;
}

EditorHandle edit_fit(const FitHandle& fit, const py::object& level) {
  EditorHandle made;
  const int splits = level.is_none() ? fit->fitted.density.level() : level.cast<int>();
  run_released(
      {}, [&](const Callbacks&) { made = std::make_shared<PythonEditor>(fit, splits); },
      fit->threads);
  return made;
}

Integers as_vertices(const py::object& vertices) {
  Integers result = as_integers(vertices, "vertices");
  if (result.ndim() != 1) refuse("vertices: a list of numbers is wanted");
  return result;
}

std::span<const std::int32_t> span_of(const Integers& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

std::unique_ptr<PythonChange> move(PythonEditor& self, const py::object& vertices,
                                   const py::object& positions) {
  const Integers which = as_vertices(vertices);
  const Doubles to = as_points(positions, "positions");
  return changed(self, [&](Editor& editor, const Callbacks& callbacks) {
    return editor.move(span_of(which), points_of(to), callbacks);
  });
}

std::unique_ptr<PythonChange> transform(PythonEditor& self, const py::object& vertices,
                                        const py::object& matrix, const py::object& weights) {
  const Integers which = as_vertices(vertices);
  const Doubles map = as_rows(matrix, "matrix", 4, 4);
  if (map.ndim() != 2 || (map.shape(0) != 4 && map.shape(0) != 3))
    refuse("matrix: numbers (4, 4) or (3, 4) are wanted");
  if (map.shape(0) == 4 &&
      !(map.data()[12] == 0 && map.data()[13] == 0 && map.data()[14] == 0 && map.data()[15] == 1))
    refuse("matrix: its last row is not 0, 0, 0, 1; an affine map is wanted");
  Selection selection;
  selection.vertices.assign(which.data(), which.data() + which.size());
  if (weights.is_none()) {
    selection.weights.assign(selection.vertices.size(), 1.0);
  } else {
    const Doubles shares = as_numbers(weights, "weights");
    selection.weights.assign(shares.data(), shares.data() + shares.size());
  }
  glm::dmat4 columns(1.0);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) columns[c][r] = map.data()[4 * r + c];
  return changed(self, [&](Editor& editor, const Callbacks& callbacks) {
    return editor.transform(selection, columns, callbacks);
  });
}

py::tuple select(PythonEditor& self, const py::object& vertices, double radius) {
  const Integers which = as_vertices(vertices);
  Selection selection;
  reading(self,
          [&](const Callbacks&) { selection = self.editor().select(span_of(which), radius); });
  const auto count = static_cast<py::ssize_t>(selection.vertices.size());
  return py::make_tuple(take_over(std::move(selection.vertices), {count}),
                        take_over(std::move(selection.weights), {count}));
}

// What makes another editor of one: what was given by it before stays as it is.
template <class Make>
std::unique_ptr<PythonChange> replaced(PythonEditor& self, const Make& make,
                                       const PythonCallbacks& python) {
  std::shared_ptr<PythonEdited> next;
  auto change = changed(
      self,
      [&](Editor& editor, const Callbacks& callbacks) {
        next = std::make_shared<PythonEdited>(self.edited->first, make(editor, callbacks));
        return next->editor.everything();
      },
      python);
  self.edited = std::move(next);
  return change;
}

std::unique_ptr<PythonChange> set_sharp(PythonEditor& self, const py::object& crease_edges,
                                        const py::object& corner_vertices, bool sharp,
                                        const py::object& progress, const py::object& cancelled) {
  const float sharpness = sharp ? kInfiniteSharpness : 0;
  std::vector<CreaseEdge> edges;
  std::vector<CornerVertex> corners;
  if (!crease_edges.is_none()) {
    const Integers ends = as_integers(crease_edges, "crease_edges");
    if (ends.size() > 0 && (ends.ndim() != 2 || ends.shape(1) != 2))
      refuse("crease_edges: integers of shape (m, 2) are wanted");
    for (py::ssize_t i = 0; i + 1 < ends.size(); i += 2)
      edges.push_back({ends.data()[i], ends.data()[i + 1], sharpness});
  }
  if (!corner_vertices.is_none()) {
    const Integers which = as_integers(corner_vertices, "corner_vertices");
    if (which.ndim() != 1) refuse("corner_vertices: a list of numbers is wanted");
    for (const std::int32_t vertex : span_of(which)) corners.push_back({vertex, sharpness});
  }
  return replaced(self,
                  [&](const Editor& editor, const Callbacks& callbacks) {
                    return editor.with_sharp(edges, corners, callbacks);
                  },
                  {progress, cancelled});
}

FitHandle fit_now(PythonEditor& self) {
  auto made = std::make_shared<PythonFit>();
  made->name = self.first().name;
  made->threads = self.first().threads;
  made->precision = self.first().precision;
  made->seconds = self.first().seconds;
  made->inputs = self.first().inputs;
  reading(self,
          [&](const Callbacks&) { made->fitted = edited(self.first().fitted, self.editor()); });
  return made;
}

template <class Value>
py::array rows_of(std::span<const Value> rows, const PythonEditor& self) {
  const py::capsule owner(new std::shared_ptr<PythonEdited>(self.edited), [](void* kept) {
    delete static_cast<std::shared_ptr<PythonEdited>*>(kept);
  });
  return view(rows.empty() ? nullptr : &rows[0].x, {static_cast<py::ssize_t>(rows.size()), 3},
              owner);
}

// The numbers of all changed rows, for indexing.
py::array changed_indices(const PythonChange& change) {
  std::vector<std::int64_t> result;
  result.reserve(static_cast<std::size_t>(change.row_count));
  for (const RowRange& range : change.rows)
    for (std::int64_t r = 0; r < range.count; ++r) result.push_back(range.first + r);
  return take_over(std::move(result), {static_cast<py::ssize_t>(change.row_count)});
}

void add_change_class(py::module_& module) {
  const auto list = [](std::vector<std::int32_t> PythonChange::*member) {
    return [member](const py::object& self) {
      const auto& values = self.cast<PythonChange&>().*member;
      return view(values.data(), {static_cast<py::ssize_t>(values.size())}, self);
    };
  };
  py::class_<PythonChange>(module, "Change", "What a call of an Editor has changed.")
      .def_property_readonly("vertices", list(&PythonChange::vertices),
                             "int32 (n,): vertices that moved, ascending.")
      .def_property_readonly("control_points", list(&PythonChange::control_points),
                             "int32 (n,): vertices whose control points moved along.")
      .def_property_readonly(
          "ranges",
          [](const py::object& self) {
            const auto& rows = self.cast<PythonChange&>().rows;
            return view(rows.empty() ? nullptr : &rows[0].first,
                        {static_cast<py::ssize_t>(rows.size()), 2}, self);
          },
          "int64 (n, 2): first and count of ranges of changed rows, ascending. All other rows are "
          "as they were, to the bit.")
      .def_property_readonly("rows", &changed_indices,
                             "int64 (m,): the changed rows, as positions[change.rows] takes them.")
      .def_readonly("is_whole", &PythonChange::is_whole, "Everything was solved and evaluated.")
      .def("__repr__", [](const PythonChange& self) {
        return "<planish.Change: " + counted(std::ssize(self.vertices), "vertex") + ", " +
               counted(self.row_count, "row") + ">";
      });
}

void add_editor_class(py::module_& module) {
  py::class_<PythonEditor, EditorHandle>(
      module, "Editor",
      "A fitted mesh whose vertices move: Fit.edit() makes it. Only what a move reaches is solved "
      "and evaluated; the arrays are views of the editor's memory, changed in place.")
      .def("move", &move, py::arg("vertices"), py::arg("positions"),
           "Moves vertices of fit.mesh (n,) to positions (n, 3) in its unit; of a vertex that is "
           "named twice the last counts. Raises InvalidArgument, and nothing has moved.")
      .def("transform", &transform, py::arg("vertices"), py::arg("matrix"),
           py::arg("weights") = py::none(),
           "Moves vertices (n,) by an affine map, numbers (4, 4) or (3, 4) by rows, each by its "
           "weight (n,) of the way; None: all the way. Raises as move().")
      .def("select", &select, py::arg("vertices"), py::arg("radius"),
           "The vertices within the radius of some others by the shortest way along edges, and "
           "weights that fall smoothly from 1 there to 0: int32 (n,), float64 (n,). Raises "
           "InvalidArgument.")
      .def("set_sharp", &set_sharp, py::arg("crease_edges") = py::none(),
           py::arg("corner_vertices") = py::none(), py::arg("sharp") = true, py::kw_only(),
           py::arg("progress") = py::none(), py::arg("cancelled") = py::none(),
           "Makes edges (m, 2), pairs of vertices, and vertices (n,) sharp, or smooth again. The "
           "mesh is solved from where it is and has other rows: arrays and LimitSurfaces that were "
           "given before stay as they were. Moves can still be taken back, this by its opposite. "
           "Raises InvalidArgument, also where the new system is not solved, and Cancelled: then "
           "nothing has changed.")
      .def(
          "undo",
          [](PythonEditor& self) {
            return changed(self, [](Editor& e, const Callbacks& c) { return e.undo(c); });
          },
          "Takes back the last move that was not yet taken back; nothing where there is none.")
      .def(
          "redo",
          [](PythonEditor& self) {
            return changed(self, [](Editor& e, const Callbacks& c) { return e.redo(c); });
          },
          "Makes the last move that was taken back again; nothing where there is none.")
      .def(
          "settle",
          [](PythonEditor& self, const py::object& progress, const py::object& cancelled) {
            return changed(self, [](Editor& e, const Callbacks& c) { return e.settle(c); },
                           {progress, cancelled});
          },
          py::kw_only(), py::arg("progress") = py::none(), py::arg("cancelled") = py::none(),
          "Solves the whole mesh from where it is; of the fair method builds the net anew, by what "
          "the fit decided. Raises Cancelled, and nothing has changed.")
      .def(
          "refit",
          [](PythonEditor& self, const py::object& progress, const py::object& cancelled) {
            return replaced(self, [](const Editor& e, const Callbacks& c) { return e.refitted(c); },
                            {progress, cancelled});
          },
          py::kw_only(), py::arg("progress") = py::none(), py::arg("cancelled") = py::none(),
          "Makes what fit() makes of the mesh as it is now by the same method, with all that is "
          "decided anew. Rows keep their numbers and moves can still be taken back; arrays and "
          "LimitSurfaces that were given before stay as they were. Raises InvalidArgument where "
          "the fit misses its tolerance, and Cancelled: then nothing has changed.")
      .def("fit", &fit_now, "The Fit of the mesh as it is now; later moves do not change it.")
      .def("limit_surface", &limit_surface_of,
           "The LimitSurface as it is at the time of each question, for picking while vertices are "
           "dragged. The first call takes time for all of the mesh; moves keep it right at the "
           "cost of what they reach.")
      .def_property_readonly(
          "points", [](const PythonEditor& self) { return rows_of(self.editor().points(), self); },
          "float64 (n, 3): the mesh's vertices where they are now, a read-only view.")
      .def_property_readonly(
          "positions",
          [](const PythonEditor& self) { return rows_of(self.editor().positions(), self); },
          "float64 (n, 3): the rows of fit.evaluate(level), a read-only view.")
      .def_property_readonly(
          "normals",
          [](const PythonEditor& self) { return rows_of(self.editor().normals(), self); },
          "float32 (n, 3) of unit length, a read-only view.")
      .def_property_readonly(
          "can_undo", [](const PythonEditor& self) { return self.editor().can_undo(); },
          "Whether there is a move to take back.")
      .def_property_readonly(
          "can_redo", [](const PythonEditor& self) { return self.editor().can_redo(); },
          "Whether there is a move that was taken back.")
      .def_property_readonly(
          "error_bound", [](const PythonEditor& self) { return self.editor().error_bound(); },
          "The surface is no farther from any vertex, as a fraction of the bounding box's "
          "diagonal.")
      .def("__repr__", [](const PythonEditor& self) {
        return "<planish.Editor: " + counted(std::ssize(self.editor().points()), "vertex") + ", " +
               counted(std::ssize(self.editor().positions()), "row") + ">";
      });
}

}  // namespace

EditorUse::EditorUse(PythonEditor& editor, Kind kind) : editor_(editor) {
  int users = editor.users;
  const bool changes = kind == Kind::Changes;
  do {
    if (users == PythonEditor::kChanging || (changes && users > 0))
      refuse(
          "the editor is at work, in another thread or in the call that calls this; wait for it");
  } while (
      !editor.users.compare_exchange_weak(users, changes ? PythonEditor::kChanging : users + 1));
}

EditorUse::~EditorUse() {
  if (editor_.users == PythonEditor::kChanging) {
    editor_.users = 0;
  } else {
    --editor_.users;
  }
}

void add_editor(py::module_& module) {
  add_change_class(module);
  add_editor_class(module);
  py::object fit = module.attr("Fit");
  fit.attr("edit") = py::cpp_function(
      &edit_fit, py::name("edit"), py::is_method(fit), py::arg("level") = py::none(),
      "An Editor of the mesh, which keeps the rows of a level, 0 to 6; None: as evaluate(). Raises "
      "InvalidArgument for "
      "a fit that has not converged, leaves the vertices (within) or is not of Doo-Sabin.");
}

}  // namespace planish::python
