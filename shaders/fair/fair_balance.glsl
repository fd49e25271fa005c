// Positive weights with which the points of the including kernel, balance_point(i), have their sum at
// 0; balance() of fair/vertex_polygon.h.
#include "fair_walk.glsl"
#define INFINITE uintBitsToFloat(0x7f800000u)
const int kNewtonSteps = 6;
const float kLongestStep = 1.5;
const float kDamping = 1e-9;
const float kTolerance = 1e-3;
const float kLargestWeight = 15.0;

float weight(uint i, vec2 y) { return exp(-dot(y, balance_point(i))); }
// 1 up to the limit, falling to 0 at twice the limit.
float ramp(float value, float limit) { return clamp(2.0 - value / limit, 0.0, 1.0); }

// Returns how far the weights, weight(i, y), are to be used.
float balance(uint count, out vec2 y) {
  y = vec2(0.0);
  float square = 0.0;
  FOR_RING(i, 0u, count) square += dot(balance_point(i), balance_point(i));
  square = ring_sum(square);
  if (!(square > 0.0)) return 0.0;
  float unit = float(count) / square;  // 1 / rms^2
  float sum = 0.0, largest = 0.0;
  vec2 moment = vec2(0.0);
  for (int step = 0;; ++step) {
    moment = vec2(0.0);
    sum = 0.0;
    largest = 0.0;
    float xx = leads() ? kDamping / unit : 0.0, xy = 0.0, yy = xx;
    FOR_RING(i, 0u, count) {
      vec2 point = balance_point(i);
      float s = exp(-dot(y, point));
      sum += s;
      largest = max(largest, s);
      moment += s * point;
      xx += s * point.x * point.x;
      xy += s * point.x * point.y;
      yy += s * point.y * point.y;
    }
    moment = ring_sum(moment);
    sum = ring_sum(sum);
    largest = ring_max(largest);
    if (step == kNewtonSteps) break;
    xx = ring_sum(xx);
    xy = ring_sum(xy);
    yy = ring_sum(yy);
    precise float determinant = xx * yy - xy * xy;
    if (!(determinant > 0.0)) return 0.0;
    precise vec2 move =
        vec2(yy * moment.x - xy * moment.y, xx * moment.y - xy * moment.x) / determinant;
    float size = sqrt(dot(move, move) / unit);
    if (size > kLongestStep) move *= kLongestStep / size;
    y += move;
  }
  float left = sqrt(dot(moment, moment) * unit) / sum;
  if (!(left < INFINITE && largest < INFINITE)) return 0.0;
  return min(ramp(left, kTolerance), ramp(largest, kLargestWeight));
}
