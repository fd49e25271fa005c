// The perpendicular polygon of every smooth or dart vertex that is to have one, and quarters of those that
// have. build_perpendicular_polygon() of fair/perpendicular_polygon.h, build_hub_ellipse() of
// fair/hub_ellipse.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, normals)
READ(4, vec4, planes)  // and behind them, where they were decided, the ellipses
READ(5, vec2, circle)
READ_STORED(6, uint, flags);
UPDATE(7, vec4, result);

#include "fair_lean.glsl"

// Of the vertex that is done. Directions of edges are made where they are needed: no valence needs
// more memory than another.
FairVertex vertex;
Frame frame;
vec3 origin;
vec2 balance_point(uint i) {
  vec2 edge = project(frame, given_at(places_at(vertex.first + i).next).xyz - origin);
  float size = safe_length(vec3(edge, 0.0));
  return size > 0.0 ? edge / size : vec2(0.0);
}
#include "fair_balance.glsl"
#include "fair_chain.glsl"

vec2 rotated(vec2 p, vec2 by) {
  precise vec2 result = vec2(p.x * by.x - p.y * by.y, p.x * by.y + p.y * by.x);
  return result;
}

// From one point of the chain to the next.
vec2 side(uint i, vec2 y) {
  vec2 edge = balance_point(i);
  return weight(i, y) * vec2(-edge.y, edge.x);
}

// Where on the circle the first of evenly spread points lies, half a step beyond where the edges point
// to: near to the bisectors of their faces.
vec2 circle_start() {
  float half_step = 3.14159265 / float(vertex.count);
  return rotated(ring_direction(vertex, origin, frame), vec2(cos(half_step), sin(half_step)));
}

// Where the chain stands when the lane's piece begins.
vec2 chain_start(vec2 y) {
  vec2 piece = vec2(0.0);
  if (kShared) {
    FOR_RING(i, 0u, vertex.count) piece += side(i, y);
  }
  return ring_before(piece);
}

void centre_ring(vec3 sum) {
  vec3 mean = ring_sum(sum) / float(vertex.count);
  FOR_RING(i, vertex.first, vertex.count) result[places_at(i).corner].xyz -= mean;
}

void build(vec3 normal, vec4 plane) {
  frame = frame_of(leaning_normal(vertex, origin, normal, plane.xy));
  vec2 y;
  float usable = balance(vertex.count, y);
  vec2 mean = vec2(0.0), at = vec2(0.0), start_at = vec2(0.0);
  float farthest = 0.0;
  if (usable > 0.0) {
    start_at = chain_start(y);
    at = start_at;
    FOR_RING(i, 0u, vertex.count) {
      at += side(i, y);
      mean += at;
    }
    mean = ring_sum(mean) / float(vertex.count);
    at = start_at;
    FOR_RING(i, 0u, vertex.count) {
      at += side(i, y);
      farthest = max(farthest, length(at - mean));
    }
    farthest = ring_max(farthest);
  }
  float chain = farthest > 0.0 ? chain_share(usable) : 0.0;
  // As far as the edges do not surround the vertex, the points of a circle.
  vec2 start = chain < 1.0 ? circle_start() : vec2(0.0);
  vec3 centre = vec3(0.0);
  at = start_at;
  FOR_RING(i, 0u, vertex.count) {
    vec2 point = (1.0 - chain) * plane.z * rotated(start, circle_at(vertex.circle + i));
    if (chain > 0.0) {
      at += side(i, y);
      point += chain * plane.z / farthest * (at - mean);
    }
    vec3 lifted = lift(frame, point);
    centre += lifted;
    result[places_at(vertex.first + i).corner] = vec4(lifted, 0.0);
  }
  centre_ring(centre);  // what rounding left of the mean
}

void build_ellipse(vec3 normal, vec4 plane, vec4 ellipse) {
  frame = frame_of(leaning_normal(vertex, origin, normal, plane.xy));
  vec2 along = ring_direction(vertex, origin, frame);
  vec3 centre = vec3(0.0);
  FOR_RING(i, 0u, vertex.count) {
    vec2 at = circle_at(vertex.circle + i);
    vec2 point = plane.z * rotated(vec2(dot(ellipse.xy, at), dot(ellipse.zw, at)), along);
    vec3 lifted = lift(frame, point);
    centre += lifted;
    result[places_at(vertex.first + i).corner] = vec4(lifted, 0.0);
  }
  centre_ring(centre);
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i), word = flags[v];
    if ((word & kChanged) == 0u) continue;
    vertex = vertices_at(v);
    if (!is_walked(vertex.count) || !has_polygon(vertex)) continue;
    origin = given_at(v).xyz;
    vec4 ellipse = parameters.decided != 0u ? planes_at(parameters.vertex_count + v) : vec4(0.0);
    if ((word & kRebuild) != 0u && ellipse != vec4(0.0))
      build_ellipse(normals_at(v).xyz, planes_at(v), ellipse);
    else if ((word & kRebuild) != 0u)
      build(normals_at(v).xyz, planes_at(v));
    float factor = quarters(word);
    if (factor == 1.0) continue;
    FOR_RING(p, vertex.first, vertex.count) result[places_at(p).corner] *= factor;
  }
}
