#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <optional>

#include "planish/job/job_outputs.h"
#include "planish/job/job_surface.h"

namespace planish {

/// Where distances of points are measured on a tessellation: from this level on it is as good as
/// the surface.
inline constexpr int kPointDistanceLevel = 2;

/// Notes in the report how good a level of the surface is, unless a level before it has: against
/// the source where there is one, else the input; the distances of a cloud's points from
/// kPointDistanceLevel on with schemes that measure_points() does not know. Nothing of it can be
/// seen at level 0. Warns "folded-area". `stored_about`: the origin of rows where a file is made of
/// them next; in the same pass they are kept for it.
void measure_surface(const FittedJob& work, JobLevel& surface,
                     const std::optional<glm::dvec3>& stored_about);

/// The distances of a cloud's points to the surface itself, by closest points.
void measure_points(const FittedJob& work, JobSurface& surface);

/// The distances of the source's vertices to the surface itself; the report must have figures of
/// the surface.
void measure_source(const FittedJob& work, JobSurface& surface);

/// What the choice of the method measured at level 1, as the figures of the surface where no other
/// level has any; false where there is none, or the source is what counts.
[[nodiscard]] bool note_chosen_surface(const FittedJob& work);

/// Notes the bending of kBendingLevel in place of that of the measured level; the report must have
/// figures of the surface.
void note_bending(const FittedJob& work, JobSurface& surface);

/// Notes how far the texture slides, and warns "sliding-texture" where that is farther than anybody
/// would have it; the report must have figures of the surface.
void note_texture_slide(const FittedJob& work, JobSurface& surface);

/// Notes how far sheets that repair separated are from each other on the surface that the report
/// has figures of; nothing where there is none: with other schemes.
void note_sheet_gap(const FittedMesh& fitted, const std::shared_ptr<const DooSabinSurface>& surface,
                    JobReport& report);

}  // namespace planish
