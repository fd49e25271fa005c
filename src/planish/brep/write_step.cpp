#include "planish/brep/write_step.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <span>
#include <vector>

#include "planish/brep/square_piece.h"
#include "planish/brep/step_sections.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/output_file.h"
#include "planish/core/visible_text.h"
#include "planish/files/shared/finite_numbers.h"
#include "planish/files/shared/ordered_stream.h"

namespace planish {
namespace {

using Ref = StepText::Reference;

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

void put_edge(StepText& text, const Brep& brep, const StepNumbers& numbers, std::int64_t e) {
  const Brep::Edge& edge = brep.edges[e];
  const std::int64_t first = text.next_id();
  for (std::size_t i = 1; i + 1 < edge.points.size(); ++i) text.point(edge.points[i]);
  std::int64_t curve = text.begin("B_SPLINE_CURVE_WITH_KNOTS('',");
  text.integer(static_cast<std::int64_t>(brep.degree));
  text.put(",(");
  text.put(Ref{numbers.first_of_vertex(edge.from)});
  for (std::size_t i = 1; i + 1 < edge.points.size(); ++i) {
    text.put(',');
    text.put(Ref{first + static_cast<std::int64_t>(i) - 1});
  }
  text.put(',');
  text.put(Ref{numbers.first_of_vertex(edge.to)});
  text.put("),.UNSPECIFIED.,.F.,.F.");
  put_knots(text, brep.degree, {edge.knots});
  // Planes stand for themselves.
  std::array<std::int64_t, 2> beside{};
  bool has_curves = false;
  for (std::size_t s = 0; s < 2 && edge.lines[s].face >= 0; ++s) {
    const std::int64_t surface = numbers.surface(edge.lines[s].face);
    const bool has_curve = numbers.has_curve(edge.lines[s]);
    has_curves = has_curves || has_curve;
    beside[s] = has_curve ? text.entity("PCURVE('',", Ref{surface}, ',',
                                        Ref{numbers.line(edge.lines[s])}, ')')
                          : surface;
  }
  if (has_curves) {
    const std::int64_t on_surfaces = text.begin("SURFACE_CURVE('',");
    text.put(Ref{curve});
    text.put(",(");
    text.put(Ref{beside[0]});
    if (beside[1] != 0) {
      text.put(',');
      text.put(Ref{beside[1]});
    }
    text.put("),.CURVE_3D.)");
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
  const auto put_direction = [&](const glm::dvec3& d) {
    return text.entity("DIRECTION('',(", d.x, ',', d.y, ',', d.z, "))");
  };
  const std::int64_t normal = put_direction(face.plane->normal),
                     along = put_direction(face.plane->along);
  const std::int64_t place =
      text.entity("AXIS2_PLACEMENT_3D('',", Ref{numbers.first_of_vertex(corner)}, ',', Ref{normal},
                  ',', Ref{along}, ')');
  return text.entity("PLANE('',", Ref{place}, ')');
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
  const std::int64_t surface =
      face.plane ? put_plane(text, brep, numbers, face) : put_surface(text, brep, numbers, f);
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
  text.entity("ADVANCED_FACE(", step_string(name_of_group(options, face.group)), ",(", Ref{bound},
              "),", Ref{surface}, ",.T.)");
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
        put_edge(text, brep, numbers, i);
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
