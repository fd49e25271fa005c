#include "planish/reconstruct/point_warnings.h"

#include <string>
#include <string_view>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"

namespace planish {
namespace {

// A tolerance of more spacings than 10^12 points of one surface have.
constexpr double kMostSpacings = 300;

}  // namespace

void tell_outliers(const Callbacks& callbacks, std::int64_t outliers, std::int64_t strays) {
  const auto tell = [&](std::int64_t count, std::string_view one, std::string_view many) {
    if (count == 0) return;
    callbacks.warn(
        {.code = "outliers-removed",
         .message = counted(count, "point") +
                    (count == 1 ? std::string(one) + " and was" : std::string(many) + " and were") +
                    " removed; --outliers off keeps them all",
         .count = count});
  };
  tell(outliers, " lies far from all others", " lie far from all others");
  tell(strays, " sticks out of the surface around it", " stick out of the surface around them");
}

// Such parts vanish without being points that are left out.
void warn_of_scale(const Reconstruction& result, const Callbacks& callbacks) {
  const double spacing = result.spacing / result.diagonal;
  if (!(result.tolerance > kMostSpacings * spacing)) return;
  callbacks.warn(
      {.code = "coarse-tolerance",
       .message = formatted(
           "points lie {} of the diagonal apart, and the mesh may be off by {} of it: smaller "
           "parts lose their shape, as those of a cloud do whose parts lie far from each other; "
           "--tolerance-mesh {} keeps them, or each in a file of its own",
           short_number(spacing), short_number(result.tolerance), short_number(spacing / 2))});
}

void warn_of_mesh(const Reconstruction& result, const ReconstructOptions& options) {
  const Callbacks& callbacks = options.callbacks;
  const MeshStatistics& facts = result.statistics;
  if (facts.boundary_loop_count > 0)
    callbacks.warn(
        {.code = "open-mesh",
         .message = formatted(
             "the mesh is open: {}{} left, genus {}; --fill-holes N closes loops of up to N edges",
             counted(facts.boundary_loop_count, "boundary loop"),
             facts.boundary_loop_count == 1 ? " is" : " are", facts.genus),
         .count = facts.boundary_loop_count});
  if (facts.component_count > 1)
    callbacks.warn(
        {.code = "several-components",
         .message = formatted("the mesh has {} components; --components largest keeps one",
                              facts.component_count),
         .count = facts.component_count});
  if (result.dropped_component_count > 0)
    callbacks.warn({.code = "components-dropped",
                    .message = counted(result.dropped_component_count, "smaller component") +
                               (result.dropped_component_count == 1 ? " was" : " were") +
                               " dropped; --components all keeps all",
                    .count = result.dropped_component_count});
  if (result.strayed_count > 0)
    callbacks.warn({.code = "points-left-out",
                    .message = formatted(
                        "{} of {}{} farther than the tolerance from the mesh", result.strayed_count,
                        counted(std::ssize(result.used_points), "point"),
                        result.strayed_count == 1 ? " fits into no triangle and lies"
                                                  : " fit into no triangle and lie"),
                    .count = result.strayed_count});
  if (options.target_vertices > 0 && facts.vertex_count > options.target_vertices)
    callbacks.warn(
        {.code = "target-not-reached",
         .message = formatted("{} are left of {} aimed at; a larger --tolerance-mesh allows fewer",
                              counted(facts.vertex_count, "vertex"), options.target_vertices),
         .count = facts.vertex_count});
}

}  // namespace planish
