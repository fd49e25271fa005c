#pragma once

#include <filesystem>

#include "planish/job/output_plan.h"
#include "planish/job/staged_files.h"

namespace planish {

/// Stages the buffers behind the first of a .gltf that stands in `written`. With --force, those
/// that the document in its place names beyond them, and that are named as its buffers are, go with
/// it: nobody else's. Throws Error{UnwritableOutput} where one exists and may not be replaced.
void stage_further_buffers(const PlannedOutput& planned, const std::filesystem::path& written,
                           StagedFiles& staged);

}  // namespace planish
