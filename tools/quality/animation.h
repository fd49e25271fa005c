#pragma once

namespace planish::quality {

/// 8 s at 30 frames a second.
inline constexpr int kFrames = 240;

/// Fits every frame of the simplified scan of the rocker arm while it bends and twists and prints,
/// for each method, how far the normals at the vertices turn from frame to frame beside what the
/// shape itself turns. A surface that pops turns far more than its shape.
void print_animation(int frame_count);

}  // namespace planish::quality
