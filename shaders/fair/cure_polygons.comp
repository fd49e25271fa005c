// The cure's perpendicular polygons at smooth and dart vertices: heights of faces, planes, points.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

#ifdef KERNEL_fair_face_heights
// The height of every face over its longest side, 0 where it has no area; polygons count half, as they
// narrow towards it. least_height() of fair/perpendicular_polygon.cpp.
READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
WRITE(3, float, heights);

#include "fair_walk.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    vec3 origin = given_at(owners_at(face.first)).xyz;
    vec3 area = vec3(0.0), last = vec3(0.0);  // twice the area
    if (kShared) last = given_at(owners_at(face.first + walk_begin(face.count) % face.count)).xyz - origin;
    float longest = 0.0;
    FOR_RING(c, 1u, face.count) {
      uint corner = c == face.count ? face.first : face.first + c;
      vec3 next = given_at(owners_at(corner)).xyz - origin;
      area += cross(last, next);
      longest = max(longest, safe_length(next - last));
      last = next;
    }
    area = ring_sum(area);
    longest = ring_max(longest);
    if (!leads()) continue;
    heights[f] = longest > 0.0 ? safe_length(area) / longest / (face.count > 3u ? 2.0 : 1.0) : 0.0;
  }
}
#endif

#ifdef KERNEL_fair_cure_planes
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, face_normals)
READ(4, float, heights)
READ(5, vec2, circle)
READ_STORED(6, uint, flags);
UPDATE(7, vec4, planes);  // the lean, and the size

#include "fair_angles.glsl"
#include "fair_view.glsl"
#endif
#ifdef KERNEL_fair_cure_polygons
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, normals)
READ(4, vec4, planes)  // and behind them, where they were decided, the ellipses
READ(5, vec2, circle)
READ_STORED(6, uint, flags);
UPDATE(7, vec4, result);
#endif

#ifndef KERNEL_fair_face_heights
#include "fair_plane.glsl"
#include "fair_walk.glsl"

// How planes of cured polygons lean; fair/fair_topology.h.

#define NO_LEAN uintBitsToFloat(kNoLeanBits)

// Where the edges around a smooth or dart vertex point to, turning with the ring.
vec2 ring_direction(FairVertex vertex, vec3 origin, Frame frame) {
  vec2 sum = vec2(0.0);
  FOR_RING(i, 0u, vertex.count) {
    vec2 edge = project(frame, given_at(places_at(vertex.first + i).next).xyz - origin);
    float size = safe_length(vec3(edge, 0.0));
    vec2 back = circle_at(vertex.circle + i);
    if (size > 0.0) sum += vec2(dot(edge / size, back), turn(back, edge / size));
  }
  sum = ring_sum(sum);
  float size = length(sum);
  return size > 0.0 ? sum / size : vec2(1.0, 0.0);
}

// Along that direction and left of it, in space.
struct RingAxes {
  vec3 along, left;
};
RingAxes ring_axes(FairVertex vertex, vec3 origin, vec3 normal) {
  Frame frame = frame_of(normal);
  vec2 direction = ring_direction(vertex, origin, frame);
  return RingAxes(lift(frame, direction), lift(frame, vec2(-direction.y, direction.x)));
}

vec2 lean_towards(FairVertex vertex, vec3 origin, vec3 normal, vec3 target) {
  if (target == normal) return vec2(0.0);
  RingAxes axes = ring_axes(vertex, origin, normal);
  vec2 flat_target = vec2(dot(target, axes.along), dot(target, axes.left));
  float sine = length(flat_target);
  return sine > 0.0 ? atan(sine, dot(target, normal)) / sine * flat_target : vec2(0.0);
}

vec3 leaning_normal(FairVertex vertex, vec3 origin, vec3 normal, vec2 lean) {
  float angle = length(lean);
  if (!(angle > 0.0)) return normal;
  RingAxes axes = ring_axes(vertex, origin, normal);
  return normalize(cos(angle) * normal +
                   sin(angle) / angle * (lean.x * axes.along + lean.y * axes.left));
}
#endif

#ifdef KERNEL_fair_cure_planes
// How the plane of every new perpendicular polygon leans, where that is not chosen yet, and how far its
// points may lie from the vertex; at curves that alone. tilted_normal() of fair/perpendicular_polygon.h,
// lean_towards(), perpendicular_size().

// Of the least height of the faces around.
const float kSize = 0.5;
#define INFINITE uintBitsToFloat(0x7f800000u)

float perpendicular_size(FairVertex vertex) {
  float least = INFINITE;
  FOR_RING(i, vertex.first, vertex.count) {
    float height = heights_at(places_at(i).face);
    if (height > 0.0) least = min(least, height);
  }
  least = ring_min(least);
  return least < INFINITE ? kSize * least : 0.0;
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    if ((flags[v] & kRebuild) == 0u) continue;
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    if (has_polygon(vertex) && planes[v].x >= NO_LEAN) {
      vec3 origin = given_at(v).xyz;
      vec3 normal = angle_weighted_normal(origin, vertex.first, vertex.count);
      vec2 lean = lean_towards(vertex, origin, normal, tilted_normal(vertex, normal));
      if (leads()) planes[v].xy = lean;
    }
    float size = perpendicular_size(vertex);
    if (leads()) planes[v].z = size;
  }
}
#endif

#ifdef KERNEL_fair_cure_polygons
// The perpendicular polygon of every smooth or dart vertex that is to have one, and quarters of those that
// have. build_perpendicular_polygon() of fair/perpendicular_polygon.h, build_hub_ellipse() of
// fair/fold_cure.h.

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
#endif
