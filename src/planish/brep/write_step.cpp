#include "planish/brep/write_step.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/brep/brep.h"
#include "planish/brep/moved_faces.h"
#include "planish/brep/spline_surface.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/files/writers.h"

namespace planish {
namespace {

// Numbers of a STEP file's entities, which are known before any text is. Points, and lines of
// curves in parameters, stand once: a face's points on its border are those of its edges where
// both have the same knots.
class StepNumbers {
 public:
  // `brep` must outlive it. `first`: of the entities behind the head.
  StepNumbers(const Brep& brep, std::int64_t first);

  // First and last entity of each; those of an edge and a face are what others refer to.
  [[nodiscard]] std::int64_t first_of_vertex(std::int64_t v) const { return vertices_ + 2 * v; }
  [[nodiscard]] std::int64_t vertex(std::int64_t v) const { return first_of_vertex(v) + 1; }
  [[nodiscard]] std::int64_t first_of_edge(std::int64_t e) const { return edges_[e]; }
  [[nodiscard]] std::int64_t edge(std::int64_t e) const { return first_of_edge(e + 1) - 1; }
  [[nodiscard]] std::int64_t first_of_face(std::int64_t f) const { return faces_[f]; }
  [[nodiscard]] std::int64_t face(std::int64_t f) const { return first_of_face(f + 1) - 1; }
  // The surface of a face, which stands before its loop.
  [[nodiscard]] std::int64_t surface(std::int64_t f) const;
  [[nodiscard]] std::int64_t end() const { return faces_.back(); }

  // Of a face, in their order: the points' numbers, those of its own counted from first_of_face()
  // on. Returns how many these are.
  std::int64_t points(std::int64_t f, std::vector<std::int64_t>& numbers) const;

  // Distinct lines of curves in parameters, three entities each, before all vertices.
  struct PlaneLine {
    double x = 0, y = 0;
    int direction = 0;
    friend auto operator<=>(const PlaneLine&, const PlaneLine&) = default;
  };
  [[nodiscard]] const std::vector<PlaneLine>& lines() const { return lines_; }
  // What a curve in parameters refers to.
  [[nodiscard]] std::int64_t line(const Brep::Line& line) const;
  [[nodiscard]] static PlaneLine plane_line(const Brep::Line& line);
  // Whether a side of an edge has a curve in parameters: those of planes need none.
  [[nodiscard]] bool has_curve(const Brep::Line& line) const {
    return line.face >= 0 && !brep_.faces[line.face].plane && !brep_.faces[line.face].surface;
  }

 private:
  [[nodiscard]] std::int64_t of_edge(const Brep::Edge& edge) const;

  const Brep& brep_;
  std::vector<PlaneLine> lines_;
  std::int64_t first_, vertices_ = 0;
  std::vector<std::int64_t> edges_, faces_;
};

constexpr std::int64_t kPlaneEntities = 4, kAnalyticEntities = 5, kUnknown = 0;

// Oriented edges, a loop and a bound for each loop.
std::int64_t loop_entities(const Brep::Face& face) {
  std::int64_t count = std::ssize(face.loop) + 2;
  for (const auto& hole : face.holes) count += std::ssize(hole) + 2;
  return count;
}

// The control point of these arguments, ascending; kNone where none has them.
constexpr std::size_t kNone = static_cast<std::size_t>(-1);
std::size_t point_of_arguments(std::size_t degree, std::span<const double> knots,
                               std::span<const double> wanted) {
  const auto found = std::ranges::lower_bound(knots, wanted.back());
  if (found == knots.end() || *found != wanted.back()) return kNone;
  // Behind the last knot's first one, each has it once more.
  auto i = static_cast<std::size_t>(found - knots.begin());
  if (i + 1 == knots.size())
    i += static_cast<std::size_t>(std::ranges::count(wanted, wanted.back())) - 1;
  const BlossomArguments own = knot_arguments(degree, knots, i);
  return std::equal(wanted.begin(), wanted.end(), own.begin()) ? i : kNone;
}

StepNumbers::StepNumbers(const Brep& brep, std::int64_t first) : brep_(brep), first_(first) {
  for (const Brep::Edge& edge : brep.edges)
    for (const Brep::Line& line : edge.lines)
      if (has_curve(line)) lines_.push_back(plane_line(line));
  std::ranges::sort(lines_);
  lines_.erase(std::unique(lines_.begin(), lines_.end()), lines_.end());
  vertices_ = first + 3 * std::ssize(lines_);

  std::int64_t id = vertices_ + 2 * std::ssize(brep.vertices);
  for (const Brep::Edge& edge : brep.edges) {
    edges_.push_back(id);
    id += of_edge(edge);
  }
  edges_.push_back(id);
  std::vector<std::int64_t> own(brep.faces.size());
  parallel_for(own.size(), 64, [&](std::size_t begin, std::size_t end) {
    std::vector<std::int64_t> numbers;
    for (std::size_t f = begin; f < end; ++f) {
      own[f] = brep.faces[f].surface ? kAnalyticEntities
               : brep.faces[f].plane ? kPlaneEntities
                                     : points(static_cast<std::int64_t>(f), numbers) + 1;
    }
  });
  for (std::size_t f = 0; f < own.size(); ++f) {
    faces_.push_back(id);
    id += own[f] + loop_entities(brep.faces[f]) + 1;
  }
  faces_.push_back(id);
}

std::int64_t StepNumbers::surface(std::int64_t f) const {
  return first_of_face(f + 1) - 2 - loop_entities(brep_.faces[f]);
}

// A line with direction and vector, a circle with its placement of four, a spline with its inner
// points.
std::int64_t curve_entities(const BorderCurve& curve) {
  if (curve.kind == CurveKind::Line) return 3;
  return curve.kind == CurveKind::Spline ? std::ssize(curve.points) - 2 + 1 : 5;
}

// Splines on surfaces that are not flat say where in their parameters they are: OpenCASCADE loses
// its way on cones else.
bool wants_parameters(const Brep& brep, const Brep::Edge& edge, const Brep::Line& line) {
  if (line.face < 0 || (edge.curve && edge.curve->kind != CurveKind::Spline)) return false;
  const auto& surface = brep.faces[line.face].surface;
  return surface && surface->kind != AnalyticKind::Plane;
}

// Inner points, the curve, where it is on B-splines its curves in their parameters and what names
// them all, and the edge.
std::int64_t StepNumbers::of_edge(const Brep::Edge& edge) const {
  // Its own and what is beside it: by lines, or by splines with their points.
  std::int64_t count = edge.curve ? curve_entities(*edge.curve) + 1 : std::ssize(edge.points);
  const std::int64_t points = std::ssize(edge.curve ? edge.curve->points : edge.points);
  bool has_curves = false;
  for (const Brep::Line& line : edge.lines) {
    const bool is_spline = wants_parameters(brep_, edge, line);
    if (is_spline) {
      count += points + 3;
    } else if (has_curve(line)) {
      count += 1;
    }
    has_curves = has_curves || is_spline || has_curve(line);
  }
  return count + (has_curves ? 1 : 0);
}

StepNumbers::PlaneLine StepNumbers::plane_line(const Brep::Line& line) {
  return {line.from.x, line.from.y, line.direction};
}

std::int64_t StepNumbers::line(const Brep::Line& line) const {
  const auto found = std::ranges::lower_bound(lines_, plane_line(line));
  return first_ + 3 * (found - lines_.begin()) + 2;
}

std::int64_t StepNumbers::points(std::int64_t f, std::vector<std::int64_t>& numbers) const {
  const Brep::Face& face = brep_.faces[f];
  const std::size_t rows = point_count(brep_.degree, face.knots_u),
                    columns = point_count(brep_.degree, face.knots_v);
  numbers.assign(face.points.size(), kUnknown);
  for (const Brep::Use& use : face.loop) {
    const Brep::Edge& edge = brep_.edges[use.edge];
    const Brep::Line& line = edge.lines[use.is_reversed ? 1 : 0];
    const bool along_u = line.direction % 2 == 0;
    const double sign = line.direction < 2 ? 1 : -1;
    const double from = along_u ? line.from.x : line.from.y;
    const double across = along_u ? line.from.y : line.from.x;
    const std::size_t place = across == 0 ? 0 : (along_u ? columns : rows) - 1;
    const std::size_t last = edge.points.size() - 1;
    for (std::size_t j = 0; j <= last; ++j) {
      BlossomArguments own = knot_arguments(brep_.degree, edge.knots, j);
      const std::span<double> there(own.data(), brep_.degree);
      for (double& t : there) t = from + sign * t;
      std::ranges::sort(there);
      const std::size_t i =
          point_of_arguments(brep_.degree, along_u ? face.knots_u : face.knots_v, there);
      if (i == kNone) continue;
      numbers[along_u ? i + rows * place : place + rows * i] =
          j == 0      ? first_of_vertex(edge.from)
          : j == last ? first_of_vertex(edge.to)
                      : first_of_edge(use.edge) + static_cast<std::int64_t>(j) - 1;
    }
  }
  // Not known yet while it is counted.
  const bool is_counted = static_cast<std::size_t>(f) < faces_.size();
  std::int64_t own = is_counted ? first_of_face(f) : 1;
  const std::int64_t begin = own;
  for (std::int64_t& number : numbers)
    if (number == kUnknown) number = own++;
  return own - begin;
}

// As std::to_chars() with a number of digits has it. Its tables are 33 kB of packed WebAssembly,
// where printf() writes the same: no locale there has another point.
char* rounded_text(char* first, char* last, double value, std::chars_format format, int digits) {
#ifdef __EMSCRIPTEN__
  const char* const form = format == std::chars_format::fixed ? "%.*f" : "%.*g";
  return first + std::snprintf(first, static_cast<std::size_t>(last - first), form, digits, value);
#else
  return std::to_chars(first, last, value, format, digits).ptr;
#endif
}

// Text of Part 21's entities: #12=NAME(...);
class StepText {
 public:
  // `decimals` of points in space, see step_decimals().
  explicit StepText(std::int64_t first_id, int decimals = 15)
      : id_(first_id), decimals_(decimals) {}

  // Begins an entity and returns its number.
  std::int64_t begin(std::string_view keyword) {
    text_ += '#';
    integer(id_);
    text_ += '=';
    text_ += keyword;
    return id_++;
  }
  void end() { text_ += ";\n"; }
  // A whole entity; its text may name others by put-in numbers.
  template <class... Parts>
  std::int64_t entity(const Parts&... parts) {
    const std::int64_t id = begin("");
    (put(parts), ...);
    end();
    return id;
  }
  std::int64_t point(const glm::dvec3& p) {
    return entity("CARTESIAN_POINT('',(", Coordinate{p.x}, ",", Coordinate{p.y}, ",",
                  Coordinate{p.z}, "))");
  }
  std::int64_t point(const glm::dvec2& p) {
    return entity("CARTESIAN_POINT('',(", p.x, ",", p.y, "))");
  }

  struct Reference {
    std::int64_t id;
  };
  void put(std::string_view text) { text_ += text; }
  void put(char letter) { text_ += letter; }
  void put(Reference reference) {
    text_ += '#';
    integer(reference.id);
  }
  // 15 digits, with the point that Part 21 asks for.
  void put(double value) {
    char buffer[40];
    const char* const stop =
        rounded_text(buffer, buffer + sizeof buffer, value, std::chars_format::general, 15);
    put_real({buffer, static_cast<std::size_t>(stop - buffer)});
  }
  struct Coordinate {
    double value;
  };
  // So many digits behind the point, or as many as the double has where these are fewer.
  void put(Coordinate coordinate) {
    char exact[40], rounded[400];
    const char* const end = std::to_chars(exact, exact + sizeof exact, coordinate.value).ptr;
    char* stop = rounded_text(rounded, rounded + sizeof rounded, coordinate.value,
                              std::chars_format::fixed, decimals_);
    while (decimals_ > 0 && stop[-1] == '0') --stop;
    const bool is_exact = end - exact <= stop - rounded;
    const std::string_view text(is_exact ? exact : rounded,
                                static_cast<std::size_t>(is_exact ? end - exact : stop - rounded));
    put_real(text == "-0." ? "0." : text);
  }
  void integer(std::int64_t value) {
    char buffer[24];
    text_.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
  }
  // In brackets, `count` of them from `first` on.
  void references(std::int64_t first, std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      text_ += i == 0 ? '(' : ',';
      put(Reference{first + i});
    }
    text_ += ')';
  }

  [[nodiscard]] std::int64_t next_id() const { return id_; }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void put_real(std::string_view text) {
    const std::size_t exponent = text.find('e');
    const std::string_view mantissa = text.substr(0, exponent);
    text_ += mantissa;
    if (mantissa.find('.') == std::string_view::npos) text_ += '.';
    if (exponent == std::string_view::npos) return;
    text_ += 'E';
    text_ += text.substr(exponent + 1);
  }

  std::int64_t id_;
  int decimals_;
  std::string text_;
};

// A string as Part 21 has it, in its quotes: ASCII as it is, all else in four bytes a character.
std::string step_string(std::string_view utf8);

// What entities in the middle of a STEP file refer to.
struct StepContext {
  std::int64_t application = 0, space = 0, plane = 0, placement = 0;
  std::array<std::int64_t, 4> vectors{};
};

using Ref = StepText::Reference;

std::int64_t put_unit(StepText& text, StepUnit unit) {
  switch (unit) {
    case StepUnit::Millimetre:
    case StepUnit::OfInput:
      return text.entity("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
    case StepUnit::Centimetre:
      return text.entity("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.CENTI.,.METRE.))");
    case StepUnit::Metre:
      return text.entity("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.))");
    case StepUnit::Inch:
      break;
  }
  const std::int64_t exponents = text.entity("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)");
  const std::int64_t mm = text.entity("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
  const std::int64_t measure =
      text.entity("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),", Ref{mm}, ')');
  return text.entity("(CONVERSION_BASED_UNIT('INCH',", Ref{measure}, ")LENGTH_UNIT()NAMED_UNIT(",
                     Ref{exponents}, "))");
}

// Of one group of faces: what styled items refer to; 0 where it has no colour.
std::int64_t put_style(StepText& text, const StepGroup& group) {
  if (!group.color) return 0;
  const glm::dvec3& c = *group.color;
  const std::int64_t color =
      text.entity("COLOUR_RGB(", step_string(group.name), ',', c.x, ',', c.y, ',', c.z, ')');
  const std::int64_t fill = text.entity("FILL_AREA_STYLE_COLOUR('',", Ref{color}, ')');
  const std::int64_t area = text.entity("FILL_AREA_STYLE('',(", Ref{fill}, "))");
  const std::int64_t surface = text.entity("SURFACE_STYLE_FILL_AREA(", Ref{area}, ')');
  const std::int64_t side = text.entity("SURFACE_SIDE_STYLE('',(", Ref{surface}, "))");
  const std::int64_t usage = text.entity("SURFACE_STYLE_USAGE(.BOTH.,", Ref{side}, ')');
  return text.entity("PRESENTATION_STYLE_ASSIGNMENT((", Ref{usage}, "))");
}

void put_list(StepText& text, std::span<const std::int64_t> ids) {
  for (std::size_t i = 0; i < ids.size(); ++i) {
    text.put(i == 0 ? '(' : ',');
    text.put(Ref{ids[i]});
  }
  text.put(')');
}

// The group of all faces of a shell; -1 where they differ.
std::int32_t group_of(const Brep& brep, const Brep::Shell& shell) {
  const auto group = [&](std::int32_t f) { return brep.faces[f].group; };
  const std::int32_t first = group(shell.faces.front());
  return std::ranges::all_of(shell.faces, [&](std::int32_t f) { return group(f) == first; }) ? first
                                                                                             : -1;
}

// A shell with what it became.
struct ShellItem {
  std::int64_t id = 0;
  std::size_t shell = 0;
};

struct ShapeItems {
  std::vector<ShellItem> solids, shells;
};

ShapeItems put_shapes(StepText& text, const Brep& brep, const StepNumbers& numbers,
                      const StepOptions& options) {
  ShapeItems items;
  std::vector<std::int64_t> ids;
  for (const Brep::Shell& shell : brep.shells) {
    std::vector<std::int64_t> faces;
    for (const std::int32_t f : shell.faces) faces.push_back(numbers.face(f));
    ids.push_back(text.begin(shell.is_closed ? "CLOSED_SHELL(''," : "OPEN_SHELL('',"));
    put_list(text, faces);
    text.put(')');
    text.end();
  }
  std::vector<std::vector<std::int64_t>> voids(brep.shells.size());
  for (std::size_t s = 0; s < brep.shells.size(); ++s) {
    if (brep.shells[s].outer < 0) continue;
    voids[brep.shells[s].outer].push_back(
        text.entity("ORIENTED_CLOSED_SHELL('',*,", Ref{ids[s]}, ",.T.)"));
  }
  for (std::size_t s = 0; s < brep.shells.size(); ++s) {
    const Brep::Shell& shell = brep.shells[s];
    if (shell.outer >= 0) continue;
    const std::string name = step_string(name_of_group(options, group_of(brep, shell)));
    if (!shell.is_closed) {
      items.shells.push_back(
          {text.entity("SHELL_BASED_SURFACE_MODEL(", name, ",(", Ref{ids[s]}, "))"), s});
    } else if (voids[s].empty()) {
      items.solids.push_back({text.entity("MANIFOLD_SOLID_BREP(", name, ',', Ref{ids[s]}, ')'), s});
    } else {
      const std::int64_t id = text.begin("BREP_WITH_VOIDS(");
      text.put(name);
      text.put(',');
      text.put(Ref{ids[s]});
      text.put(',');
      put_list(text, voids[s]);
      text.put(')');
      text.end();
      items.solids.push_back({id, s});
    }
  }
  return items;
}

// Of whole solids and shells where they have one group, else of faces.
void put_colors(StepText& text, const Brep& brep, const StepNumbers& numbers,
                const StepContext& context, const StepOptions& options, const ShapeItems& items) {
  std::vector<std::int64_t> styles, styled;
  for (const StepGroup& group : options.groups) styles.push_back(put_style(text, group));
  const auto style = [&](std::int32_t group, std::int64_t item) {
    if (group < 0 || static_cast<std::size_t>(group) >= styles.size()) return;
    const std::int64_t id = styles[group];
    if (id != 0) styled.push_back(text.entity("STYLED_ITEM('',(", Ref{id}, "),", Ref{item}, ')'));
  };
  const auto style_faces = [&](const Brep::Shell& shell) {
    for (const std::int32_t f : shell.faces) style(brep.faces[f].group, numbers.face(f));
  };
  for (const auto* of_kind : {&items.solids, &items.shells}) {
    for (const ShellItem& item : *of_kind) {
      const std::int32_t group = group_of(brep, brep.shells[item.shell]);
      if (group >= 0) {
        style(group, item.id);
      } else {
        style_faces(brep.shells[item.shell]);
      }
    }
  }
  for (const Brep::Shell& shell : brep.shells)
    if (shell.outer >= 0) style_faces(shell);
  if (styled.empty()) return;
  text.begin("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',");
  put_list(text, styled);
  text.put(',');
  text.put(Ref{context.space});
  text.put(')');
  text.end();
}

// Digits behind the point that coordinates need: rounding moves none by more than 1.6e-13 of the
// diagonal, which turns no normal by 1e-5 degrees on the smallest squares.
int step_decimals(double diagonal) {
  constexpr double kDigits = 12.5;  // of the diagonal
  constexpr int kMost = 300;
  if (!(diagonal > 0)) return 15;
  return std::clamp(static_cast<int>(std::ceil(kDigits - portable::log10(diagonal))), 0, kMost);
}

std::string step_string(std::string_view utf8) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string result = "'";
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto byte = static_cast<unsigned char>(utf8[i]);
    if (byte < 0x80) {
      if (byte == '\'' || byte == '\\') result += utf8[i];
      result += byte < 0x20 || byte == 0x7f ? ' ' : utf8[i];
      continue;
    }
    std::size_t length = byte >= 0xf0 ? 3 : byte >= 0xe0 ? 2 : 1;
    std::uint32_t code = byte & (0x3fu >> length);
    for (; length > 0 && i + 1 < utf8.size(); --length)
      code = code << 6 | (static_cast<unsigned char>(utf8[++i]) & 0x3fu);
    result += "\\X4\\";
    for (int shift = 28; shift >= 0; shift -= 4) result += kDigits[code >> shift & 15u];
    result += "\\X0\\";
  }
  return result + "'";
}

// The header, units and what else stands before any shape.
StepContext put_head(StepText& text, const StepOptions& options) {
  StepContext context;
  text.put("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((");
  text.put(step_string(options.description));
  text.put("),'2;1');\nFILE_NAME(");
  text.put(step_string(options.name));
  // No hour: equal surfaces are equal files.
  text.put(",'1970-01-01T00:00:00',(''),(''),'planish " PLANISH_VERSION
           "','','');\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 "
           "}'));\nENDSEC;\nDATA;\n");
  context.application =
      text.entity("APPLICATION_CONTEXT('core data for automotive mechanical design processes')");
  text.entity("APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,",
              Ref{context.application}, ')');
  const std::int64_t length = put_unit(text, options.unit);
  const std::int64_t angle = text.entity("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
  const std::int64_t solid = text.entity("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
  const std::int64_t near = text.entity(
      "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(",
      std::max(Brep::kSamePlace * options.diagonal, 1e-6 / millimetres_of(options.unit)), "),",
      Ref{length}, ",'distance_accuracy_value','confusion accuracy')");
  context.space =
      text.entity("(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((",
                  Ref{near}, "))GLOBAL_UNIT_ASSIGNED_CONTEXT((", Ref{length}, ',', Ref{angle}, ',',
                  Ref{solid}, "))REPRESENTATION_CONTEXT('','3D'))");
  context.plane = text.entity(
      "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()"
      "REPRESENTATION_CONTEXT('2D SPACE',''))");
  for (int d = 0; d < 4; ++d) {
    const glm::dvec2 unit = unit_direction(d);
    const std::int64_t direction = text.entity("DIRECTION('',(", unit.x, ',', unit.y, "))");
    context.vectors[d] = text.entity("VECTOR('',", Ref{direction}, ",1.)");
  }
  const std::int64_t origin = text.point(glm::dvec3(0.0));
  const std::int64_t z = text.entity("DIRECTION('',(0.,0.,1.))");
  const std::int64_t x = text.entity("DIRECTION('',(1.,0.,0.))");
  context.placement =
      text.entity("AXIS2_PLACEMENT_3D('',", Ref{origin}, ',', Ref{z}, ',', Ref{x}, ')');
  return context;
}

// Solids and open shells of one product, each kind in a representation of its own, and colours.
void put_tail(StepText& text, const Brep& brep, const StepNumbers& numbers,
              const StepContext& context, const StepOptions& options) {
  const ShapeItems items = put_shapes(text, brep, numbers, options);
  const std::string name = step_string(options.name);
  const std::int64_t product_context =
      text.entity("PRODUCT_CONTEXT('',", Ref{context.application}, ",'mechanical')");
  const std::int64_t product =
      text.entity("PRODUCT(", name, ',', name, ",'',(", Ref{product_context}, "))");
  text.entity("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(", Ref{product}, "))");
  const std::int64_t formation =
      text.entity("PRODUCT_DEFINITION_FORMATION('','',", Ref{product}, ')');
  const std::int64_t stage = text.entity("PRODUCT_DEFINITION_CONTEXT('part definition',",
                                         Ref{context.application}, ",'design')");
  const std::int64_t definition =
      text.entity("PRODUCT_DEFINITION('design','',", Ref{formation}, ',', Ref{stage}, ')');
  const auto represent = [&](std::string_view kind, const std::vector<ShellItem>& all) {
    if (all.empty()) return;
    const std::int64_t shape = text.entity("PRODUCT_DEFINITION_SHAPE('','',", Ref{definition}, ')');
    const std::int64_t representation = text.begin(kind);
    text.put("('',(");
    text.put(Ref{context.placement});
    for (const ShellItem& item : all) {
      text.put(',');
      text.put(Ref{item.id});
    }
    text.put("),");
    text.put(Ref{context.space});
    text.put(')');
    text.end();
    text.entity("SHAPE_DEFINITION_REPRESENTATION(", Ref{shape}, ',', Ref{representation}, ')');
  };
  represent("ADVANCED_BREP_SHAPE_REPRESENTATION", items.solids);
  represent("MANIFOLD_SURFACE_SHAPE_REPRESENTATION", items.shells);
  put_colors(text, brep, numbers, context, options, items);
  text.put("ENDSEC;\nEND-ISO-10303-21;\n");
}

// One line of knots for a curve, two for a surface: multiplicities of all, then values of all.
void put_knots(StepText& text, std::size_t degree,
               std::initializer_list<std::span<const double>> lines) {
  for (const bool are_values : {false, true}) {
    for (const std::span<const double> knots : lines) {
      text.put(',');
      for (std::size_t i = 0; i < knots.size(); ++i) {
        text.put(i == 0 ? '(' : ',');
        if (are_values) {
          text.put(knots[i]);
        } else {
          text.integer(i == 0 || i + 1 == knots.size() ? static_cast<std::int64_t>(degree) + 1 : 1);
        }
      }
      text.put(')');
    }
  }
  text.put(",.UNSPECIFIED.)");
  text.end();
}

void put_line(StepText& text, const StepContext& context, const StepNumbers::PlaneLine& line) {
  const std::int64_t from = text.point(glm::dvec2(line.x, line.y));
  const std::int64_t vector = context.vectors[line.direction];
  const std::int64_t straight = text.entity("LINE('',", Ref{from}, ',', Ref{vector}, ')');
  text.entity("DEFINITIONAL_REPRESENTATION('',(", Ref{straight}, "),", Ref{context.plane}, ')');
}

// A cone is placed at the narrow end of its face: OpenCASCADE makes no triangles of what lies
// before the place. 0 for others.
double placed_height(const Brep& brep, const Brep::Face& face) {
  const AnalyticSurface& s = *face.surface;
  if (s.kind != AnalyticKind::Cone) return 0;
  double height = std::numeric_limits<double>::max();
  for (const Brep::Use& use : face.loop)
    height =
        std::min(height, glm::dot(brep.vertices[brep.edges[use.edge].from] - s.origin, s.axis));
  return std::max(0.0, height);
}

std::int64_t put_direction(StepText& text, const glm::dvec3& d) {
  return text.entity("DIRECTION('',(", d.x, ',', d.y, ',', d.z, "))");
}
// A place with an axis and a direction at right angles to it.
std::int64_t put_placement(StepText& text, const glm::dvec3& origin, const glm::dvec3& axis,
                           const glm::dvec3& along) {
  const std::int64_t point = text.point(origin), z = put_direction(text, axis),
                     x = put_direction(text, along);
  return text.entity("AXIS2_PLACEMENT_3D('',", Ref{point}, ',', Ref{z}, ',', Ref{x}, ')');
}

void put_spline_points(StepText& text, const StepNumbers& numbers, const Brep::Edge& edge,
                       std::span<const glm::dvec3> points, std::size_t degree, std::int64_t first) {
  text.integer(static_cast<std::int64_t>(degree));
  text.put(",(");
  text.put(Ref{numbers.first_of_vertex(edge.from)});
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    text.put(',');
    text.put(Ref{first + static_cast<std::int64_t>(i) - 1});
  }
  text.put(',');
  text.put(Ref{numbers.first_of_vertex(edge.to)});
  text.put("),.UNSPECIFIED.,.F.,.F.");
}

std::int64_t put_curve(StepText& text, const Brep& brep, const StepNumbers& numbers,
                       const Brep::Edge& edge) {
  const BorderCurve& curve = *edge.curve;
  if (curve.kind == CurveKind::Line) {
    const glm::dvec3 along = brep.vertices[edge.to] - brep.vertices[edge.from];
    const std::int64_t direction = put_direction(text, unit_or_zero(along));
    const std::int64_t vector = text.entity("VECTOR('',", Ref{direction}, ",1.)");
    return text.entity("LINE('',", Ref{numbers.first_of_vertex(edge.from)}, ',', Ref{vector}, ')');
  }
  if (curve.kind != CurveKind::Spline) {
    const std::int64_t place = put_placement(text, curve.centre, curve.axis, curve.along);
    return curve.kind == CurveKind::Circle
               ? text.entity("CIRCLE('',", Ref{place}, ',', curve.radius, ')')
               : text.entity("ELLIPSE('',", Ref{place}, ',', curve.radius, ',', curve.minor, ')');
  }
  const std::int64_t first = text.next_id();
  for (std::size_t i = 1; i + 1 < curve.points.size(); ++i) text.point(curve.points[i]);
  const std::int64_t id = text.begin("B_SPLINE_CURVE_WITH_KNOTS('',");
  put_spline_points(text, numbers, edge, curve.points, kBorderDegree, first);
  put_knots(text, kBorderDegree, {curve.knots});
  return id;
}

// Where a spline lies in the parameters of an analytic face.
std::int64_t put_parameters(StepText& text, const Brep& brep, const StepNumbers& numbers,
                            const StepContext& context, const Brep::Edge& edge,
                            std::int32_t index) {
  const Brep::Face& face = brep.faces[index];
  const double height = placed_height(brep, face);
  const std::int64_t first = text.next_id();
  std::vector<glm::dvec2> points;
  if (edge.curve) {
    points = parameter_curve(*face.surface, face.along, height, *edge.curve).points;
  } else {
    ParameterWalk walk(*face.surface, face.along, height, edge.points.front());
    const auto at = [&](double t) { return glm::dvec3(walk.next(point_of(brep, edge, t)), 0.0); };
    for (const glm::dvec3& p : quadratic_points(edge.knots, at)) points.emplace_back(p.x, p.y);
  }
  for (const glm::dvec2& p : points) text.point(p);
  const std::size_t degree = edge.curve ? kBorderDegree : brep.degree;
  const std::int64_t flat = text.begin("B_SPLINE_CURVE_WITH_KNOTS('',");
  text.integer(static_cast<std::int64_t>(degree));
  text.put(',');
  text.references(first, std::ssize(points));
  text.put(",.UNSPECIFIED.,.F.,.F.");
  put_knots(text, degree, {edge.curve ? edge.curve->knots : edge.knots});
  const std::int64_t defined =
      text.entity("DEFINITIONAL_REPRESENTATION('',(", Ref{flat}, "),", Ref{context.plane}, ')');
  return text.entity("PCURVE('',", Ref{numbers.surface(index)}, ',', Ref{defined}, ')');
}

void put_edge(StepText& text, const Brep& brep, const StepNumbers& numbers,
              const StepContext& context, std::int64_t e) {
  const Brep::Edge& edge = brep.edges[e];
  std::int64_t curve = 0;
  if (edge.curve) {
    curve = put_curve(text, brep, numbers, edge);
  } else {
    const std::int64_t first = text.next_id();
    for (std::size_t i = 1; i + 1 < edge.points.size(); ++i) text.point(edge.points[i]);
    curve = text.begin("B_SPLINE_CURVE_WITH_KNOTS('',");
    put_spline_points(text, numbers, edge, edge.points, brep.degree, first);
    put_knots(text, brep.degree, {edge.knots});
  }
  // Planes stand for themselves.
  std::vector<std::int64_t> beside;
  bool has_curves = false;
  for (const Brep::Line& line : edge.lines) {
    if (line.face < 0) continue;
    const std::int64_t surface = numbers.surface(line.face);
    if (wants_parameters(brep, edge, line)) {
      beside.push_back(put_parameters(text, brep, numbers, context, edge, line.face));
    } else if (numbers.has_curve(line)) {
      beside.push_back(text.entity("PCURVE('',", Ref{surface}, ',', Ref{numbers.line(line)}, ')'));
    } else {
      if (!edge.curve) beside.push_back(surface);
      continue;
    }
    has_curves = true;
  }
  if (has_curves) {
    const std::int64_t on_surfaces = text.begin("SURFACE_CURVE('',");
    text.put(Ref{curve});
    text.put(',');
    put_list(text, beside);
    text.put(",.CURVE_3D.)");
    text.end();
    curve = on_surfaces;
  }
  text.entity("EDGE_CURVE('',", Ref{numbers.vertex(edge.from)}, ',', Ref{numbers.vertex(edge.to)},
              ',', Ref{curve}, ",.T.)");
}

std::int64_t put_plane(StepText& text, const Brep& brep, const StepNumbers& numbers,
                       const Brep::Face& face) {
  const auto& first = face.loop.front();
  const Brep::Edge& edge = brep.edges[first.edge];
  const std::int64_t corner = first.is_reversed ? edge.to : edge.from;
  const std::int64_t normal = put_direction(text, face.plane->normal),
                     along = put_direction(text, face.plane->along);
  const std::int64_t place =
      text.entity("AXIS2_PLACEMENT_3D('',", Ref{numbers.first_of_vertex(corner)}, ',', Ref{normal},
                  ',', Ref{along}, ')');
  return text.entity("PLANE('',", Ref{place}, ')');
}

std::int64_t put_analytic(StepText& text, const Brep& brep, const Brep::Face& face) {
  const AnalyticSurface& s = *face.surface;
  const double height = placed_height(brep, face);
  const glm::dvec3 origin = s.origin + height * s.axis;
  const std::int64_t place = put_placement(text, origin, s.axis, face.along);
  switch (s.kind) {
    case AnalyticKind::Plane:
      return text.entity("PLANE('',", Ref{place}, ')');
    case AnalyticKind::Cylinder:
      return text.entity("CYLINDRICAL_SURFACE('',", Ref{place}, ',', s.radius, ')');
    case AnalyticKind::Cone:
      return text.entity("CONICAL_SURFACE('',", Ref{place}, ',', height * s.slope, ',',
                         portable::atan(s.slope), ')');
    case AnalyticKind::Sphere:
      return text.entity("SPHERICAL_SURFACE('',", Ref{place}, ',', s.radius, ')');
    default:
      return text.entity("TOROIDAL_SURFACE('',", Ref{place}, ',', s.radius, ',', s.minor, ')');
  }
}

std::int64_t put_surface(StepText& text, const Brep& brep, const StepNumbers& numbers,
                         std::int64_t f) {
  const Brep::Face& face = brep.faces[f];
  std::vector<std::int64_t> points;
  numbers.points(f, points);
  std::int64_t own = text.next_id();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i] == own) own = text.point(face.points[i]) + 1;
  const std::size_t rows = point_count(brep.degree, face.knots_u),
                    columns = point_count(brep.degree, face.knots_v);
  const std::int64_t surface = text.begin("B_SPLINE_SURFACE_WITH_KNOTS('',");
  for (int k = 0; k < 2; ++k) {
    text.integer(static_cast<std::int64_t>(brep.degree));
    text.put(',');
  }
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < columns; ++j) {
      text.put(j > 0 ? "," : i == 0 ? "((" : "),(");
      text.put(Ref{points[i + rows * j]});
    }
  }
  text.put(")),.UNSPECIFIED.,.F.,.F.,.F.");
  put_knots(text, brep.degree, {face.knots_u, face.knots_v});
  return surface;
}

void put_face(StepText& text, const Brep& brep, const StepNumbers& numbers,
              const StepOptions& options, std::int64_t f) {
  const Brep::Face& face = brep.faces[f];
  const std::int64_t surface = face.surface ? put_analytic(text, brep, face)
                               : face.plane ? put_plane(text, brep, numbers, face)
                                            : put_surface(text, brep, numbers, f);
  std::vector<std::int64_t> bounds;
  const auto put_loop = [&](const std::vector<Brep::Use>& of, std::string_view kind) {
    const std::int64_t uses = text.next_id();
    for (const Brep::Use& use : of) {
      text.entity("ORIENTED_EDGE('',*,*,", Ref{numbers.edge(use.edge)},
                  use.is_reversed ? ",.F.)" : ",.T.)");
    }
    const std::int64_t loop = text.begin("EDGE_LOOP('',");
    text.references(uses, static_cast<std::int64_t>(of.size()));
    text.put(')');
    text.end();
    bounds.push_back(text.entity(kind, "('',", Ref{loop}, ",.T.)"));
  };
  put_loop(face.loop, "FACE_OUTER_BOUND");
  for (const auto& hole : face.holes) put_loop(hole, "FACE_BOUND");
  text.begin("ADVANCED_FACE(");
  text.put(step_string(name_of_group(options, face.group)));
  text.put(',');
  put_list(text, bounds);
  text.put(',');
  text.put(Ref{surface});
  text.put(face.is_inward ? ",.F.)" : ",.T.)");
  text.end();
}

// All numbers that go out, before there is a file.
void require_finite_brep(const Brep& brep, const StepOptions& options, const std::string& name) {
  const auto require = [&]<class Value>(const std::vector<Value>& values, std::string_view whose,
                                        std::size_t number, std::string_view what) {
    const std::span<const Value> all(values);
    if (!all_finite(all)) require_finite(all, 0, formatted("{} {}: {}", whose, number, what), name);
  };
  require_finite(std::span<const glm::dvec3>(brep.vertices), 0, "vertex", name);
  for (std::size_t e = 0; e < brep.edges.size(); ++e) {
    require(brep.edges[e].points, "edge", e, "control point");
    require(brep.edges[e].knots, "edge", e, "knot");
  }
  for (std::size_t f = 0; f < brep.faces.size(); ++f) {
    const Brep::Face& face = brep.faces[f];
    require(face.points, "face", f, "control point");
    require(face.knots_u, "face", f, "knot");
    require(face.knots_v, "face", f, "knot");
    if (!face.plane) continue;
    for (const glm::dvec3& direction : {face.plane->normal, face.plane->along})
      if (!is_finite(direction))
        refuse_not_finite(name, "a direction of the plane of face", static_cast<std::int64_t>(f),
                          direction);
  }
  for (std::size_t g = 0; g < options.groups.size(); ++g)
    if (options.groups[g].color && !is_finite(*options.groups[g].color))
      refuse_not_finite(name, "the colour of group", static_cast<std::int64_t>(g),
                        *options.groups[g].color);
  if (!is_finite(options.diagonal))
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: the diagonal is not finite: {}; give the model's", name,
                          number_words(options.diagonal)));
}

}  // namespace

double millimetres_of(StepUnit unit) {
  constexpr std::array<double, 5> kMillimetres{1, 10, 1000, 25.4, 1};
  return kMillimetres[static_cast<std::size_t>(unit)];
}

std::uint64_t write_step(const std::filesystem::path& path, const Brep& brep,
                         const StepOptions& options) {
  if (brep.faces.empty())
    throw Error(ErrorCode::InvalidArgument,
                visible(path.filename()) + ": the surface has no face; STEP needs one");
  require_finite_brep(brep, options, visible(path.filename()));
  const HostScope host(options.callbacks);
  constexpr std::int64_t kPiece = 64;
  StepText head(1);
  const StepContext context = put_head(head, options);
  const StepNumbers numbers(brep, head.next_id());
  for (const StepNumbers::PlaneLine& line : numbers.lines()) put_line(head, context, line);
  const auto count = [](const auto& items) { return static_cast<std::int64_t>(items.size()); };

  // Pieces of [vertices, edges, faces], none of which holds two kinds.
  const std::array<std::int64_t, 3> counts{count(brep.vertices), count(brep.edges),
                                           count(brep.faces)};
  std::vector<RowRange> ranges;
  std::int64_t before = 0;
  for (const std::int64_t of_kind : counts) {
    for (std::int64_t i = 0; i < of_kind; i += kPiece)
      ranges.push_back({before + i, std::min(kPiece, of_kind - i)});
    before += of_kind;
  }

  const int decimals = step_decimals(options.diagonal);
  OutputFile file(path);
  LoopProgress progress(options.callbacks, "write", 0, 1, std::ssize(ranges));
  std::uint64_t bytes = 0;
  const auto take = [&](std::span<const std::byte> piece) {
    file.write(piece);
    if (options.observe) options.observe(piece);
    bytes += piece.size();
  };
  const auto take_text = [&](const StepText& text) { take(std::as_bytes(std::span(text.text()))); };
  take_text(head);
  const auto make = [&](RowRange range, RawVector<std::byte>& piece) {
    std::int64_t first = range.first;
    std::size_t kind = 0;
    while (first >= counts[kind]) first -= counts[kind++];
    StepText text(kind == 0   ? numbers.first_of_vertex(first)
                  : kind == 1 ? numbers.first_of_edge(first)
                              : numbers.first_of_face(first),
                  decimals);
    for (std::int64_t i = first; i < first + range.count; ++i) {
      if (kind == 0) {
        const std::int64_t p = text.point(brep.vertices[i]);
        text.entity("VERTEX_POINT('',", Ref{p}, ')');
      } else if (kind == 1) {
        put_edge(text, brep, numbers, context, i);
      } else {
        put_face(text, brep, numbers, options, i);
      }
    }
    piece.resize(text.text().size());
    std::memcpy(piece.data(), text.text().data(), piece.size());
    progress.add();
  };
  const std::array<ByteSink, 1> sinks{ByteSink(take)};
  stream(ranges, make, sinks);
  StepText tail(numbers.end());
  put_tail(tail, brep, numbers, context, options);
  take_text(tail);
  file.commit();
  options.callbacks.report("write", 1);
  return bytes;
}

}  // namespace planish
