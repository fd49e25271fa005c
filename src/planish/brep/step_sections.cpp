#include "planish/brep/step_sections.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/version.h"

namespace planish {
namespace {

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

}  // namespace

int step_decimals(double diagonal) {
  constexpr double kDigits = 12.5;  // of the diagonal
  constexpr int kMost = 300;
  if (!(diagonal > 0)) return 15;
  return std::clamp(static_cast<int>(std::ceil(kDigits - std::log10(diagonal))), 0, kMost);
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

}  // namespace planish
