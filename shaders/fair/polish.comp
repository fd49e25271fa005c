// The polish: heights along the vertices' directions that bend the net least, by conjugate gradients.
// fair/bending.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

#ifdef KERNEL_fair_directions
// The vector by which a height of 1 moves the control points around every vertex: its normal, but 0
// where they must stay or lie in a plane, and less near curves. polish_directions() of fair/bending.h.
READ(0, FairVertex, vertices)
READ(1, vec4, normals)
READ(2, float, shares)
WRITE(3, vec4, directions);

void main() {
  FOR_ELEMENTS(v) {
    FairVertex vertex = vertices_at(v);
    float part = has_polygon(vertex) && vertex.plane == 0u ? 1.0 : 0.0;
    if (vertex.near_curve != 0u) part *= 1.0 - shares_at(v);
    directions[v] = vec4(part * normals_at(v).xyz, 0.0);
  }
}
#endif

#ifdef KERNEL_fair_rows
// The bending of the two lines through every control point, linear in heights along the directions.
// fair/bending.h.
READ(0, FairLinks, links)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, directions)
READ(4, vec4, result)
WRITE(5, vec4, rows1);  // coefficients of next, own, after; value
WRITE(6, vec4, rows2);  // of previous, own, before; value

// A part of a line below this of the whole measures noise.
const float kShortestPart = 0.001;
// A line whose numbers leave single precision is no line.
const float kLargestCoefficient = 1e15;

vec4 row(vec3 to_far, vec3 to_near, vec3 normal, vec3 own_direction, vec3 far_direction) {
  float far_length = safe_length(to_far), near_length = safe_length(to_near);
  float whole = far_length + near_length;
  float part = min(far_length, near_length) / whole;
  if (!(part > kShortestPart)) return vec4(0.0);
  // A ramp to full weight, so that no line appears at once in a deforming mesh.
  float scale = 2.0 * min((part - kShortestPart) / kShortestPart, 1.0) / whole;
  float far = scale / far_length, near = scale / near_length;
  if (!(max(far, near) * length(normal) < kLargestCoefficient)) return vec4(0.0);
  float move = dot(normal, own_direction);
  return vec4(far * dot(normal, far_direction), -(far + near) * move, near * move,
              dot(normal, far * to_far + near * to_near));
}

void main() {
  FOR_ELEMENTS(c) {
    FairLinks corner = links_at(c);
    uint vertex = owners_at(c);
    vec3 own = result_at(c).xyz, origin = given_at(vertex).xyz;
    uint next = owners_at(corner.next), previous = owners_at(corner.previous);
    vec3 to_next = (given_at(next).xyz - origin) + (result_at(corner.next).xyz - own);
    vec3 to_previous = (given_at(previous).xyz - origin) + (result_at(corner.previous).xyz - own);
    // Control points around the same vertex differ by their offsets alone.
    vec3 to_after = result_at(corner.after).xyz - own;
    vec3 to_before = result_at(corner.before).xyz - own;
    // Of the quad of the four neighbours, scaled to the square root of half its area.
    vec3 normal = cross(to_next - to_after, to_previous - to_before);
    float size = safe_length(normal);
    rows1[c] = vec4(0.0);
    rows2[c] = vec4(0.0);
    if (!(size > 0.0)) continue;
    normal *= 0.5 / sqrt(size);
    vec3 move = directions_at(vertex).xyz;
    rows1[c] = row(to_next, to_after, normal, move, directions_at(next).xyz);
    rows2[c] = row(to_previous, to_before, normal, move, directions_at(previous).xyz);
  }
}
#endif

#ifdef KERNEL_fair_diagonals
// The mean diagonal of the bending's Hessian over every vertex's polygon, and the largest of them.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, FairLinks, links)
READ(3, vec4, rows1)
READ(4, vec4, rows2)
WRITE(5, float, diagonals);
UPDATE(6, FairScalars, scalars);

#include "fair_walk.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    float sum = 0.0;
    if (has_polygon(vertex)) {
      FOR_RING(p, vertex.first, vertex.count) {
        uint c = places_at(p).corner;
        vec3 row1 = rows1_at(c).xyz, row2 = rows2_at(c).xyz;
        float next = rows2_at(links_at(c).next).x, previous = rows1_at(links_at(c).previous).x;
        // The lines beside it around the vertex are counted where they stand: over the polygon it
        // comes to the same mean.
        sum += row1.y * row1.y + row1.z * row1.z + row2.y * row2.y + row2.z * row2.z +
               next * next + previous * previous;
      }
    }
    float mean = ring_sum(sum) / float(vertex.count);
    if (!leads()) continue;
    diagonals[v] = mean;
    if (mean > 0.0) atomicMax(scalars[0].largest_bits, floatBitsToUint(mean));
  }
}
#endif

#ifdef KERNEL_fair_precondition
// One over the mean diagonal of every vertex, floored; 0 where control points must stay.
UPDATE(0, float, diagonals);
READ_STORED(1, FairScalars, scalars);

// Of the largest: control points without lines stay where they are.
const float kLeastDiagonal = 1e-14;

void main() {
  float least = kLeastDiagonal * uintBitsToFloat(scalars[0].largest_bits);
  FOR_ELEMENTS(v) diagonals[v] = diagonals[v] > 0.0 ? 1.0 / max(diagonals[v], least) : 0.0;
}
#endif

#ifdef KERNEL_fair_lines
READ(0, FairLinks, links)
READ(1, vec4, rows1)
READ(2, vec4, rows2)
READ(3, vec4, motions)
UPDATE(4, FairScalars, scalars);
WRITE(5, vec2, lines);
UPDATE_TOGETHER(6, float, partials);
#endif
#ifdef KERNEL_fair_descend
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, float, gradient)
READ(3, float, precondition)
READ(4, vec4, motions)
UPDATE(5, FairScalars, scalars);
WRITE(6, vec4, next);
UPDATE_TOGETHER(7, float, partials);
#endif

#if defined(KERNEL_fair_lines) || defined(KERNEL_fair_descend)
// What the polish knows of a control point, its motion: x is the residual, preconditioned and without
// its mean over the polygon, y the last direction, z the height. Curve points have none: 0.

// The direction after the last one.
float turned(vec4 motion, float momentum) { return motion.x + momentum * motion.y; }

#include "group_fold.glsl"

// Adds up a float over all work groups of a round.
shared bool has_all;

// True in one lane of the group that is the last to have its part: `value` is then the sum of all, in fixed
// order, and scalars are that lane's to write, as all others have read them.
bool is_total(inout float value) {
  bool is_first = gl_LocalInvocationIndex == 0u;
  float part = group_sum(value);
  if (is_first) {
    partials[parameters.first_partial + gl_WorkGroupID.x] = part;
    memoryBarrierBuffer();
    has_all = atomicAdd(scalars[0].parts, 1u) + 1u == parameters.partial_count;
  }
  barrier();
  if (!has_all) return false;
  memoryBarrierBuffer();
  value = 0.0;
  for (uint i = gl_LocalInvocationIndex; i < parameters.partial_count; i += kGroupLanes)
    value += partials[i];
  value = group_sum(value);
  if (is_first) scalars[0].parts = 0u;
  return is_first;
}
#endif

#ifdef KERNEL_fair_lines
// What the direction of descent, turned by what the last step found, does to the two lines through
// every control point, and from the square sum of it the length of the step.

// The residual's square by the curvature along the direction.
void write_step_length(float curvature) {
  if (parameters.start != 0u) {
    scalars[0].step = 1.0;
    return;
  }
  float square = scalars[0].square;
  // No step once it has converged, or where numbers have left single precision.
  float step = square > scalars[0].enough && curvature > 0.0 ? square / curvature : 0.0;
  scalars[0].step = is_finite(step) ? step : 0.0;
}

void main() {
  float sum = 0.0;
  float momentum = scalars[0].momentum;
  FOR_ELEMENTS(c) {
    vec4 row1 = rows1_at(c), row2 = rows2_at(c);
    vec2 line = vec2(row1.w, row2.w);  // at height 0
    if (parameters.start == 0u) {
      FairLinks corner = links_at(c);
      float own = turned(motions_at(c), momentum);
      line = vec2(row1.x * turned(motions_at(corner.next), momentum) + row1.y * own +
                      row1.z * turned(motions_at(corner.after), momentum),
                  row2.x * turned(motions_at(corner.previous), momentum) + row2.y * own +
                      row2.z * turned(motions_at(corner.before), momentum));
    }
    lines[c] = line;
    sum += dot(line, line);
  }
  if (is_total(sum)) write_step_length(sum);
}
#endif

#ifdef KERNEL_fair_gradient
// Half the gradient of the bending along the lines' change, for every control point.
READ(0, FairLinks, links)
READ(1, vec4, rows1)
READ(2, vec4, rows2)
READ(3, vec2, lines)
WRITE(4, float, gradient);

void main() {
  FOR_ELEMENTS(c) {
    FairLinks corner = links_at(c);
    float sum = rows1_at(c).y * lines_at(c).x + rows2_at(c).y * lines_at(c).y +
                rows1_at(corner.previous).x * lines_at(corner.previous).x +
                rows2_at(corner.next).x * lines_at(corner.next).y;
    // Beyond the corners stand curve points, which have no lines.
    if (corner.before < parameters.count)
      sum += rows1_at(corner.before).z * lines_at(corner.before).x;
    if (corner.after < parameters.count) sum += rows2_at(corner.after).z * lines_at(corner.after).y;
    gradient[c] = sum;
  }
}
#endif

#ifdef KERNEL_fair_descend
// The step along the direction of every control point: its height, its residual after it, and the
// residuals' preconditioned square sum, by whose change the last direction is part of the next one.
#include "fair_walk.glsl"

// Of the first residual's square: single precision reaches no lower.
const float kConverged = 1e-12;

// Returns the square sum of what the lane walks around.
float descend(FairVertex vertex, float scale, float step, float momentum) {
  float mean = 0.0;
  FOR_RING(i, vertex.first, vertex.count) mean += gradient_at(places_at(i).corner);
  mean = ring_sum(mean) / float(vertex.count);
  float square = 0.0;
  FOR_RING(i, vertex.first, vertex.count) {
    uint c = places_at(i).corner;
    vec4 motion = motions_at(c);
    float along = turned(motion, momentum);
    float residual = motion.x - scale * step * (gradient_at(c) - mean);
    next[c].xyz = vec3(residual, along, motion.z + step * along);
    square += residual * residual;
  }
  return square / scale;
}

void write_momentum(float square) {
  if (parameters.start != 0u) {
    scalars[0].step = 0.0;
    scalars[0].momentum = 0.0;
    scalars[0].enough = kConverged * square;
  } else {
    float momentum = scalars[0].square > 0.0 ? square / scalars[0].square : 0.0;
    scalars[0].momentum = is_finite(momentum) ? momentum : 0.0;
  }
  scalars[0].square = square;
}

void main() {
  float total = 0.0;
  float step = scalars[0].step, momentum = scalars[0].momentum;
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    float scale = precondition_at(v);
    // Control points that must stay, or without lines, have no motion.
    if (!(scale > 0.0)) continue;
    FairVertex vertex = vertices_at(v);
    if (is_walked(vertex.count)) total += descend(vertex, scale, step, momentum);
  }
  if (is_total(total)) write_momentum(total);
}
#endif

#ifdef KERNEL_fair_apply_heights
// Moves the control points of every polygon by their heights, the third of a motion, as far as those can be trusted.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, directions)
READ(3, vec4, motions)
UPDATE(4, vec4, result);

#include "fair_walk.glsl"

// Of a control point's distance to the vertex.
const float kFarthestMove = 0.3;

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    vec3 direction = directions_at(v).xyz;
    float size = length(direction);
    if (!(size > 0.0)) continue;
    float mean = 0.0;
    FOR_RING(p, vertex.first, vertex.count) mean += motions_at(places_at(p).corner).z;
    mean = ring_sum(mean) / float(vertex.count);
    float scale = 1.0;
    FOR_RING(p, vertex.first, vertex.count) {
      uint c = places_at(p).corner;
      float move = abs(motions_at(c).z - mean) * size;
      float farthest = kFarthestMove * safe_length(result[c].xyz);
      if (move > farthest) scale = min(scale, farthest / move);
      if (!is_finite(move)) scale = 0.0;
    }
    scale = ring_min(scale);
    if (scale == 0.0) continue;
    FOR_RING(p, vertex.first, vertex.count) {
      uint c = places_at(p).corner;
      result[c].xyz += (motions_at(c).z - mean) * scale * direction;
    }
  }
}
#endif
