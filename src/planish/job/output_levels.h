#pragma once

#include <vector>

#include "planish/job/job_outputs.h"
#include "planish/job/job_surface.h"
#include "planish/job/surface_output.h"
#include "planish/surface/vertex_fields.h"

namespace planish {

/// What all files of a job's surface have in common.
[[nodiscard]] SurfaceOutputOptions surface_options(const FittedJob& work);

/// Every fineness that a file of a surface has, but of tiles and of levels of detail in one, once.
[[nodiscard]] std::vector<Fineness> finenesses_of(const std::vector<PlannedOutput>& outputs);

/// A level, measured for the report.
[[nodiscard]] JobLevel measured_level(const FittedJob& work, JobSurface& surface, int level,
                                      const SurfaceOutputOptions& options);

/// What the fields of a surface's files are held by.
struct LevelFields {
  VertexFields figures;                     ///< that the job wants as data
  std::vector<VertexAttribute> attributes;  ///< that the mesh has
};

/// The surface of that fineness, measured where it is a level. The options get what its files say
/// of it, and the fields, which `fields` holds.
[[nodiscard]] JobLevel surface_of(const FittedJob& work, JobSurface& all, const Fineness& fineness,
                                  LevelFields& fields, SurfaceOutputOptions& options);

/// Figures that a job's report wants and that cannot be seen on its cage or at level 0.
void measure_rest(const FittedJob& work, JobSurface& all, const SurfaceOutputOptions& common);

/// A tolerance finer than float32 holds in the solve but not in a glTF file.
void warn_of_rounding(JobReport& report, const JobContext& context, const WrittenOutput& output);

/// Files of a level that nobody named that are large, and many times as large as the input.
void warn_of_size(JobReport& report, std::uint64_t input_bytes, const JobContext& context);

}  // namespace planish
