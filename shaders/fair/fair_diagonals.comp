// The mean diagonal of the bending's Hessian over every vertex's polygon, and the largest of them.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

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
