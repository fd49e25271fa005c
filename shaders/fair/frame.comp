// What the fair construction begins with, points in unit coordinates, normals and offsets, and what it
// ends with, errors and the state.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

#ifdef KERNEL_fair_place
// The given points in unit coordinates.
READ(0, vec4, model_points)
WRITE(1, vec4, given);

void main() {
  vec3 origin = vec3(parameters.x, parameters.y, parameters.z);
  FOR_ELEMENTS(v) given[v] = vec4((model_points_at(v).xyz - origin) / parameters.scale, 0.0);
}
#endif

#ifdef KERNEL_fair_face_normals
// The unit Newell normal of every face, +Z where it has no area; and how many corners it has.
READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
WRITE(3, vec4, face_normals);

#include "fair_walk.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    vec3 origin = given_at(owners_at(face.first)).xyz;
    vec3 area = vec3(0.0);
    uint begin = 1u + walk_begin(face.count - 2u);
    vec3 last = given_at(owners_at(face.first + begin)).xyz - origin;
    FOR_RING(c, 2u, face.count - 2u) {
      vec3 next = given_at(owners_at(face.first + c)).xyz - origin;
      area += cross(last, next);
      last = next;
    }
    area = ring_sum(area);
    if (leads()) face_normals[f] = vec4(normalised(area), float(face.count));
  }
}
#endif

#ifdef KERNEL_fair_vertex_normals
// The unit normal at every vertex: its corners' normals weighted by their angles, or that of the plane
// there.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, face_normals)
WRITE(4, vec4, normals);

#include "fair_angles.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    vec3 normal = vertex.plane != 0u
                      ? face_normals_at(vertex.plane - 1u).xyz
                      : angle_weighted_normal(given_at(v).xyz, vertex.first, vertex.count);
    if (leads()) normals[v] = vec4(normal, 0.0);
  }
}
#endif

#ifdef KERNEL_fair_sector_normals
// The unit normal of every sector at a crease or boundary vertex: its corners' weighted by angles, or
// that of the plane there.
READ_STORED(0, FairSector, sectors);
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, face_normals)
WRITE(4, vec4, normals);

#include "fair_angles.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint s = kShared ? sectors[i].large : i;
    FairSector sector = sectors[s];
    if (!is_walked(sector.count)) continue;
    vec3 origin = given_at(sector.vertex).xyz;
    vec3 normal = sector.plane != 0u
                      ? face_normals_at(sector.plane - 1u).xyz
                      : angle_weighted_normal(origin, sector.first, sector.count);
    if (leads()) normals[s] = vec4(normal, 0.0);
  }
}
#endif

#ifdef KERNEL_fair_offsets
// One Doo-Sabin step of points: every corner's control point relative to its vertex's given point.
// Based on: Doo & Sabin 1978; fair/fair_topology.h.
READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, points)
READ(4, vec2, circle)
WRITE(5, vec4, offsets);

#include "fair_walk.glsl"

// Of the net, whose points are offsets of corners: what all are relative to.
vec3 origin = vec3(0.0);
vec3 given_of(uint corner) { return given_at(owners_at(corner)).xyz - origin; }
vec3 point(uint corner) {
  return parameters.of_net != 0u ? given_of(corner) + points_at(corner).xyz
                                 : points_at(owners_at(corner)).xyz;
}
void write_offset(uint corner, vec3 from, vec3 step) {
  offsets[corner] = vec4((from - given_of(corner)) + step, 0.0);
}

void step_triangle(uint first) {
  for (uint i = 0u; i < 3u; ++i) {
    vec3 own = point(first + i);
    write_offset(first + i, own,
                 (point(first + (i + 1u) % 3u) - own) / 6.0 +
                     (point(first + (i + 2u) % 3u) - own) / 6.0);
  }
}

void step_quad(uint first) {
  for (uint i = 0u; i < 4u; ++i) {
    vec3 own = point(first + i);
    write_offset(first + i, own,
                 (3.0 * (point(first + (i + 1u) % 4u) - own) +
                  3.0 * (point(first + (i + 3u) % 4u) - own) +
                  (point(first + (i + 2u) % 4u) - own)) /
                     16.0);
  }
}

void step_polygon(FairFace face) {
  vec3 middle = point(face.first);
  vec3 mean = vec3(0.0), cosine_sum = vec3(0.0), sine_sum = vec3(0.0);
  FOR_RING(i, 0u, face.count) {
    vec3 p = point(face.first + i) - middle;
    mean += p;
    cosine_sum += circle_at(face.circle + i).x * p;
    sine_sum += circle_at(face.circle + i).y * p;
  }
  mean = ring_sum(mean) / float(face.count);
  cosine_sum = ring_sum(cosine_sum);
  sine_sum = ring_sum(sine_sum);
  FOR_RING(i, 0u, face.count) {
    vec2 at = circle_at(face.circle + i);
    write_offset(face.first + i, middle,
                 0.25 * (point(face.first + i) - middle) + 0.75 * mean +
                     (at.x * cosine_sum + at.y * sine_sum) / (2.0 * float(face.count)));
  }
}

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    if (parameters.of_net != 0u) origin = given_at(owners_at(face.first)).xyz;
    if (face.count == 3u)
      step_triangle(face.first);
    else if (face.count == 4u)
      step_quad(face.first);
    else
      step_polygon(face);
  }
}
#endif

#ifdef KERNEL_fair_measure
// Measures how far the limit point of every vertex is from its given point.
READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, result)
UPDATE(4, uint, status);  // words of SolveStatus

#include "fair_walk.glsl"

const uint kStateWord = 1u, kResidualWord = 2u;

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    vec3 given_point = given_at(v).xyz, error = vec3(0.0);
    if (has_polygon(vertex)) {
      FOR_RING(p, vertex.first, vertex.count) error += result_at(places_at(p).corner).xyz;
      error = ring_sum(error) / float(vertex.count);
    } else if (vertex.kind == kCrease) {
      error += (result_at(vertex.curve0).xyz + result_at(vertex.curve1).xyz) / 2.0;
    }
    if (!leads()) continue;
    float size = parameters.scale * safe_length(error);
    // What stands around a given point that is no number may be replaced by numbers.
    bool finite = is_finite(error.x + error.y + error.z) &&
                  is_finite(given_point.x + given_point.y + given_point.z);
    if (!finite) atomicMax(status[kStateWord], kStateNotFinite);
    atomicMax(status[kResidualWord], finite ? floatBitsToUint(size) : 0x7f800000u);
  }
}
#endif

#ifdef KERNEL_fair_state
// The control points of level 1: given points with what the construction put around them.
READ(0, uint, owners)
READ(1, vec4, model_points)
READ(2, vec4, result)
WRITE(3, vec4, state);
WRITE(4, vec4, offsets);  // the same, as corner patches take them

void main() {
  FOR_ELEMENTS(i) {
    uint vertex = owners_at(i);
    vec3 offset = parameters.scale * result_at(i).xyz;
    state[i] = vec4(model_points_at(vertex).xyz + offset, 0.0);
    offsets[i] = vec4(offset, uintBitsToFloat(vertex | kVertexTag));
  }
}
#endif
