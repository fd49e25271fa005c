#pragma once

/// The way from a polygon mesh to its smooth surface on the CPU: read, fit, evaluate, write.
/// The Vulkan backend stands in planish/vulkan/vulkan_backend.h.
#include "planish/backend/cpu_backend.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/version.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_points.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/files/write_surface.h"
#include "planish/limit/surface_queries.h"
#include "planish/mesh/check.h"
#include "planish/mesh/convex_faces.h"
#include "planish/mesh/detect_creases.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/repair.h"
#include "planish/mesh/weld_vertices.h"
#include "planish/pipeline/fit.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/surface_quality.h"
#include "planish/surface/vertex_fields.h"
