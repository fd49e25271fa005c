#pragma once

#include <planish/mesh/polygon_mesh.h>

#include <functional>

#include "application.h"

/// Writes three floats for each vertex of the mesh.
using MovePoints = std::function<void(int frame, std::span<std::byte> points)>;
/// Gets position and normal, six floats, of each vertex, those of the frame before, and the indices
/// of triangles.
using Draw = std::function<void(int frame, std::span<const std::byte> vertices,
                                std::span<const std::byte> last_vertices,
                                std::span<const std::byte> indices)>;

/// Draws an animated mesh for so many frames.
void draw_frames(Application& app, const planish::PolygonMesh& mesh, int frame_count,
                 const MovePoints& move_points, const Draw& draw);
