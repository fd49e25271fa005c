#include "options.h"

#include <cmath>
#include <string>

#include "arrays.h"
#include "errors.h"
#include "planish/core/number_text.h"
#include "planish/mesh/detect_creases.h"
#include "planish/mesh/weld_vertices.h"
#include "planish/pipeline/option_words.h"

namespace py = pybind11;

namespace planish::python {

const char* const kFitKeywords = R"(
    method: "auto" takes the better of both by measurement; "progressive" moves the control points
        of the mesh; "fair" builds those of the next level, without folds on uneven meshes.
    tolerance: of the largest error of a vertex, as a fraction of the bounding box's diagonal.
    scheme: "doo-sabin", "catmull-clark" or "loop" (triangles only).
    weights: of Doo-Sabin: "doo-sabin" (1978) or "averaged" (the paper's).
    solver: "chebyshev", "plain" (the paper's) or "cg" (closed smooth meshes only).
    boundary: "edge" or "edge-and-corner".
    creases: "use" keeps tagged edges sharp, "ignore" does not, "auto:40" also those whose faces
        turn by more than 40 degrees ("auto": by an angle that suits most meshes), "normals" those
        where a file splits its normals (fit_file() alone; see read()).
    crease_edges: integers (m, 2), edges that stay sharp; corner_vertices: integers (n,).
    repair: "safe" mends what can be mended, "none" refuses it.
    weld: vertices within this fraction of the diagonal become one, first.
    max_iterations, polish: steps of the progressive and of the fair method.
    precision: of the solve: "auto", "float" or "double".
    threads: 0 takes all cores. Results are the same bits for any number.
    progress: progress(step, fraction) is called while work goes on.
    cancelled: cancelled() -> bool is asked every 20 ms; planish.Cancelled follows. Ctrl-C stops
        work as soon.)";

namespace {

// Keywords, taken one by one.
class Keywords {
 public:
  Keywords(py::kwargs keywords, const char* function)
      : keywords_(std::move(keywords)), function_(function) {}

  py::object take(const char* name) {
    if (!keywords_.contains(name)) return py::none();
    py::object value = keywords_[name];
    keywords_.attr("pop")(name);
    return value;
  }

  template <class Value>
  void take(const char* name, Value& target, const char* wanted) {
    const py::object value = take(name);
    if (value.is_none()) return;
    try {
      target = value.cast<Value>();
    } catch (const py::cast_error&) {
      refuse(std::string(name) + ": " + py::repr(value).cast<std::string>() + "; " + wanted);
    }
  }

  template <class Words, class Value>
  void take_word(const char* name, const Words& words, Value& target) {
    std::string text;
    const std::string wanted = "one of " + texts_of(words) + " is wanted";
    take(name, text, wanted.c_str());
    if (text.empty()) return;
    const auto value = value_of(words, text);
    if (!value) refuse(std::string(name) + ": \"" + text + "\"; " + wanted);
    target = *value;
  }

  void require_none_left() const {
    if (keywords_.empty()) return;
    const auto name = py::cast<std::string>((*keywords_.begin()).first);
    throw py::type_error(std::string(function_) + "() got an unexpected keyword argument '" + name +
                         "'");
  }

 private:
  py::kwargs keywords_;
  const char* function_;
};

enum class MethodWord { Auto, Progressive, Fair };
constexpr std::array kChoices{OptionWord<MethodWord>{"auto", MethodWord::Auto},
                              OptionWord<MethodWord>{"progressive", MethodWord::Progressive},
                              OptionWord<MethodWord>{"fair", MethodWord::Fair}};
constexpr std::array kRepairs{OptionWord<bool>{"safe", true}, OptionWord<bool>{"none", false}};

void parse_creases(const std::string& text, FitArguments& arguments) {
  constexpr const char* kWanted = "one of use, ignore, normals, auto, auto:DEGREES is wanted";
  MeshFitOptions& options = arguments.mesh;
  arguments.split_normals = text == "normals";
  options.fit.sharp.use_tags = text != "ignore";
  if (text == "use" || text == "ignore" || text == "normals") return;
  double degrees = CreaseDetectionOptions{}.dihedral_degrees;
  const bool is_angle = text.starts_with("auto:") && parse_number(text.substr(5), degrees);
  if ((text != "auto" && !is_angle) || !(degrees > 0 && degrees <= 180))
    refuse("creases: \"" + text + "\"; " + kWanted);
  options.crease_degrees = degrees;
}

void take_numbers(Keywords& keywords, FitArguments& result) {
  FitOptions& fit = result.mesh.fit;
  keywords.take("tolerance", fit.tolerance, "a number is wanted");
  if (!(fit.tolerance > 0 && fit.tolerance <= 1)) {
    refuse("tolerance: " + shortest(fit.tolerance) +
           " is out of range; a fraction of the diagonal above 0 and up to 1 is wanted");
  }
  double weld = -1;
  keywords.take("weld", weld, "a number is wanted");
  if (weld != -1) {
    if (!can_weld_within(weld))
      refuse("weld: " + shortest(weld) +
             " is out of range; 0, or a fraction of the diagonal from "
             "1e-12 to less than 0.1, is wanted");
    result.mesh.weld = weld;
  }
  const auto take_count = [&](const char* name, std::int32_t& target, std::int32_t most) {
    std::int64_t count = target;
    keywords.take(name, count, "a whole number is wanted");
    if (count < 0 || count > most) {
      refuse(std::string(name) + ": " + std::to_string(count) + " is out of range; 0 to " +
             std::to_string(most) + " is wanted");
    }
    target = static_cast<std::int32_t>(count);
  };
  take_count("max_iterations", fit.max_iterations, 1'000'000);
  take_count("polish", fit.polish_steps, 1'000);
  take_count("threads", result.threads, 4096);
}

}  // namespace

std::unique_ptr<Backend> FitArguments::make_backend() const {
  return make_cpu_backend({.solve_precision = precision, .thread_count = threads});
}

FitArguments fit_arguments(py::kwargs given, const char* function) {
  Keywords keywords(std::move(given), function);
  FitArguments result;
  FitOptions& fit = result.mesh.fit;
  keywords.take_word("scheme", kSchemeWords, fit.scheme);
  MethodWord method = MethodWord::Auto;
  keywords.take_word("method", kChoices, method);
  if (method == MethodWord::Progressive) result.mesh.method = InterpolationMethod::Progressive;
  if (method == MethodWord::Fair) result.mesh.method = InterpolationMethod::Fair;
  keywords.take_word("weights", kWeightsWords, fit.weights);
  keywords.take_word("solver", kSolverWords, fit.solver);
  keywords.take_word("boundary", kBoundaryWords, fit.sharp.boundary);
  keywords.take_word("repair", kRepairs, result.mesh.repairs);
  std::string creases = "use";
  keywords.take("creases", creases, "one of use, ignore, normals, auto, auto:DEGREES is wanted");
  parse_creases(creases, result);
  if (result.split_normals && std::string_view(function) != "fit_file")
    refuse("creases: normals are a file's; take fit_file(), or read() with split_normals");
  take_numbers(keywords, result);
  // Auto is settled when the tolerance is known.
  result.precision = precision_for(fit.tolerance);
  const std::array precisions{OptionWord<Precision>{"auto", result.precision},
                              OptionWord<Precision>{"float", Precision::Float},
                              OptionWord<Precision>{"double", Precision::Double}};
  keywords.take_word("precision", precisions, result.precision);
  result.callbacks.progress = keywords.take("progress");
  result.callbacks.cancelled = keywords.take("cancelled");
  result.crease_edges = keywords.take("crease_edges");
  result.corner_vertices = keywords.take("corner_vertices");
  keywords.require_none_left();
  return result;
}

void add_tags(const FitArguments& arguments, PolygonMesh& mesh) {
  if (!arguments.crease_edges.is_none()) {
    const Integers edges = as_integers(arguments.crease_edges, "crease_edges");
    if (edges.size() > 0 && (edges.ndim() != 2 || edges.shape(1) != 2))
      refuse("crease_edges: integers of shape (m, 2) are wanted");
    for (py::ssize_t i = 0; i + 1 < edges.size(); i += 2)
      mesh.creases.push_back({edges.data()[i], edges.data()[i + 1]});
  }
  if (arguments.corner_vertices.is_none()) return;
  const Integers corners = as_integers(arguments.corner_vertices, "corner_vertices");
  if (corners.ndim() != 1) refuse("corner_vertices: integers of shape (n,) are wanted");
  for (py::ssize_t i = 0; i < corners.size(); ++i) mesh.corners.push_back({corners.data()[i]});
}

}  // namespace planish::python
