#include "planish/brep/write_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>
#include <vector>

#include "planish/brep/step_text.h"
#include "planish/core/host_scope.h"
#include "planish/core/output_file.h"
#include "planish/core/version.h"
#include "planish/files/shared/ordered_stream.h"

namespace planish {
namespace {

using Ref = StepText::Reference;

// Numbers of entities, which are known before any text is.
class StepNumbers {
 public:
  StepNumbers(const Brep& brep, std::int64_t first) : vertices_(first) {
    std::int64_t id = first + 2 * static_cast<std::int64_t>(brep.vertices.size());
    for (const Brep::Edge& edge : brep.edges) {
      edges_.push_back(id);
      id += of_edge(edge);
    }
    edges_.push_back(id);
    for (const Brep::Face& face : brep.faces) {
      faces_.push_back(id);
      id += of_face(face);
    }
    faces_.push_back(id);
  }

  [[nodiscard]] std::int64_t first_of_vertex(std::int64_t v) const { return vertices_ + 2 * v; }
  [[nodiscard]] std::int64_t vertex(std::int64_t v) const { return first_of_vertex(v) + 1; }
  [[nodiscard]] std::int64_t first_of_edge(std::int64_t e) const {
    return edges_[static_cast<std::size_t>(e)];
  }
  [[nodiscard]] std::int64_t edge(std::int64_t e) const { return first_of_edge(e + 1) - 1; }
  [[nodiscard]] std::int64_t first_of_face(std::int64_t f) const {
    return faces_[static_cast<std::size_t>(f)];
  }
  [[nodiscard]] std::int64_t face(std::int64_t f) const { return first_of_face(f + 1) - 1; }
  [[nodiscard]] std::int64_t surface(const Brep& brep, std::int64_t f) const {
    const auto points = brep.faces[static_cast<std::size_t>(f)].points.size();
    return first_of_face(f) + static_cast<std::int64_t>(points);
  }
  [[nodiscard]] std::int64_t end() const { return faces_.back(); }

 private:
  static std::int64_t of_edge(const Brep::Edge& edge) {
    const std::int64_t sides = edge.lines[1].face < 0 ? 1 : 2;
    return static_cast<std::int64_t>(edge.points.size()) + 3 + 4 * sides;
  }
  static std::int64_t of_face(const Brep::Face& face) {
    return static_cast<std::int64_t>(face.points.size() + face.loop.size()) + 4;
  }

  std::int64_t vertices_;
  std::vector<std::int64_t> edges_, faces_;
};

// What the others refer to.
struct StepContext {
  std::int64_t application = 0, space = 0, plane = 0, placement = 0;
  std::array<std::int64_t, 4> vectors{};
};

void put_knots(StepText& text, std::span<const double> knots, bool are_values) {
  for (std::size_t i = 0; i < knots.size(); ++i) {
    text.put(i == 0 ? '(' : ',');
    if (are_values) {
      text.put(knots[i]);
    } else {
      text.put(i == 0 || i + 1 == knots.size() ? '3' : '1');
    }
  }
  text.put(')');
}

void put_edge(StepText& text, const Brep& brep, const StepNumbers& numbers,
              const StepContext& context, std::int64_t e) {
  const Brep::Edge& edge = brep.edges[static_cast<std::size_t>(e)];
  const std::int64_t first = text.next_id();
  for (const glm::dvec3& p : edge.points) text.point(p);
  const std::int64_t curve = text.begin("B_SPLINE_CURVE_WITH_KNOTS('',2,");
  text.references(first, static_cast<std::int64_t>(edge.points.size()));
  text.put(",.UNSPECIFIED.,.F.,.F.,");
  put_knots(text, edge.knots, false);
  text.put(',');
  put_knots(text, edge.knots, true);
  text.put(",.UNSPECIFIED.)");
  text.end();
  std::array<std::int64_t, 2> pcurves{};
  for (std::size_t s = 0; s < 2 && edge.lines[s].face >= 0; ++s) {
    const Brep::Line& line = edge.lines[s];
    const std::int64_t from = text.point(line.from);
    const std::int64_t vector = context.vectors[static_cast<std::size_t>(line.direction)];
    const std::int64_t straight = text.entity("LINE('',", Ref{from}, ',', Ref{vector}, ')');
    const std::int64_t definition = text.entity("DEFINITIONAL_REPRESENTATION('',(", Ref{straight},
                                                "),", Ref{context.plane}, ')');
    pcurves[s] =
        text.entity("PCURVE('',", Ref{numbers.surface(brep, line.face)}, ',', Ref{definition}, ')');
  }
  const std::int64_t on_surfaces = text.begin("SURFACE_CURVE('',");
  text.put(Ref{curve});
  text.put(",(");
  text.put(Ref{pcurves[0]});
  if (pcurves[1] != 0) {
    text.put(',');
    text.put(Ref{pcurves[1]});
  }
  text.put("),.CURVE_3D.)");
  text.end();
  text.entity("EDGE_CURVE('',", Ref{numbers.vertex(edge.from)}, ',', Ref{numbers.vertex(edge.to)},
              ',', Ref{on_surfaces}, ",.T.)");
}

void put_face(StepText& text, const Brep& brep, const StepNumbers& numbers, std::int64_t f) {
  const Brep::Face& face = brep.faces[static_cast<std::size_t>(f)];
  const std::int64_t first = text.next_id();
  for (const glm::dvec3& p : face.points) text.point(p);
  const std::size_t rows = face.knots_u.size() + 1, columns = face.knots_v.size() + 1;
  const std::int64_t surface = text.begin("B_SPLINE_SURFACE_WITH_KNOTS('',2,2,");
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < columns; ++j) {
      text.put(j > 0 ? "," : i == 0 ? "((" : "),(");
      text.put(Ref{first + static_cast<std::int64_t>(i + rows * j)});
    }
  }
  text.put(")),.UNSPECIFIED.,.F.,.F.,.F.,");
  put_knots(text, face.knots_u, false);
  text.put(',');
  put_knots(text, face.knots_v, false);
  text.put(',');
  put_knots(text, face.knots_u, true);
  text.put(',');
  put_knots(text, face.knots_v, true);
  text.put(",.UNSPECIFIED.)");
  text.end();
  const std::int64_t uses = text.next_id();
  for (const Brep::Use& use : face.loop) {
    text.entity("ORIENTED_EDGE('',*,*,", Ref{numbers.edge(use.edge)},
                use.is_reversed ? ",.F.)" : ",.T.)");
  }
  const std::int64_t loop = text.begin("EDGE_LOOP('',");
  text.references(uses, static_cast<std::int64_t>(face.loop.size()));
  text.put(')');
  text.end();
  const std::int64_t bound = text.entity("FACE_OUTER_BOUND('',", Ref{loop}, ",.T.)");
  text.entity("ADVANCED_FACE('',(", Ref{bound}, "),", Ref{surface}, ",.T.)");
}

std::int64_t put_unit(StepText& text, StepUnit unit) {
  switch (unit) {
    case StepUnit::Millimetre:
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
  const std::int64_t near =
      text.entity("UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(",
                  std::max(1e-7 * options.diagonal, 1e-6 / millimetres_of(options.unit)), "),",
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
    context.vectors[static_cast<std::size_t>(d)] =
        text.entity("VECTOR('',", Ref{direction}, ",1.)");
  }
  const std::int64_t origin = text.point(glm::dvec3(0.0));
  const std::int64_t z = text.entity("DIRECTION('',(0.,0.,1.))");
  const std::int64_t x = text.entity("DIRECTION('',(1.,0.,0.))");
  context.placement =
      text.entity("AXIS2_PLACEMENT_3D('',", Ref{origin}, ',', Ref{z}, ',', Ref{x}, ')');
  return context;
}

// Solids and open shells of one product, each kind in a representation of its own.
void put_tail(StepText& text, const Brep& brep, const StepNumbers& numbers,
              const StepContext& context, const StepOptions& options) {
  std::vector<std::int64_t> solids, shells;
  for (const Brep::Shell& shell : brep.shells) {
    const std::int64_t id = text.begin(shell.is_closed ? "CLOSED_SHELL(''," : "OPEN_SHELL('',");
    for (std::size_t i = 0; i < shell.faces.size(); ++i) {
      text.put(i == 0 ? '(' : ',');
      text.put(Ref{numbers.face(shell.faces[i])});
    }
    text.put("))");
    text.end();
    if (shell.is_closed) {
      solids.push_back(text.entity("MANIFOLD_SOLID_BREP('',", Ref{id}, ')'));
    } else {
      shells.push_back(text.entity("SHELL_BASED_SURFACE_MODEL('',(", Ref{id}, "))"));
    }
  }
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
  const auto represent = [&](std::string_view kind, std::span<const std::int64_t> items) {
    if (items.empty()) return;
    const std::int64_t shape = text.entity("PRODUCT_DEFINITION_SHAPE('','',", Ref{definition}, ')');
    const std::int64_t representation = text.begin(kind);
    text.put("('',(");
    text.put(Ref{context.placement});
    for (const std::int64_t item : items) {
      text.put(',');
      text.put(Ref{item});
    }
    text.put("),");
    text.put(Ref{context.space});
    text.put(')');
    text.end();
    text.entity("SHAPE_DEFINITION_REPRESENTATION(", Ref{shape}, ',', Ref{representation}, ')');
  };
  represent("ADVANCED_BREP_SHAPE_REPRESENTATION", solids);
  represent("MANIFOLD_SURFACE_SHAPE_REPRESENTATION", shells);
  text.put("ENDSEC;\nEND-ISO-10303-21;\n");
}

}  // namespace

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

double millimetres_of(StepUnit unit) {
  constexpr std::array<double, 4> kMillimetres{1, 10, 1000, 25.4};
  return kMillimetres[static_cast<std::size_t>(unit)];
}

std::uint64_t write_step(const std::filesystem::path& path, const Brep& brep,
                         const StepOptions& options) {
  const HostScope host(options.callbacks);
  constexpr std::int64_t kPiece = 64;
  StepText head(1);
  const StepContext context = put_head(head, options);
  const StepNumbers numbers(brep, head.next_id());
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
                              : numbers.first_of_face(first));
    for (std::int64_t i = first; i < first + range.count; ++i) {
      if (kind == 0) {
        const std::int64_t p = text.point(brep.vertices[static_cast<std::size_t>(i)]);
        text.entity("VERTEX_POINT('',", Ref{p}, ')');
      } else if (kind == 1) {
        put_edge(text, brep, numbers, context, i);
      } else {
        put_face(text, brep, numbers, i);
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
