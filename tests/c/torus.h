/* A torus that C programs of these tests fit. */
#include <math.h>

#include "cube.h"

enum { kAlong = 96, kAround = 72, kCount = kAlong * kAround };

static planish_mesh* torus(void) {
  static double positions[3 * kCount];
  static int32_t corners[4 * kCount];
  int i, k;
  for (i = 0; i < kAlong; ++i) {
    for (k = 0; k < kAround; ++k) {
      const double a = 6.283185307179586 * i / kAlong, b = 6.283185307179586 * k / kAround;
      double* p = positions + 3 * (i * kAround + k);
      int32_t* f = corners + 4 * (i * kAround + k);
      p[0] = (1 + 0.4 * cos(b)) * cos(a);
      p[1] = (1 + 0.4 * cos(b)) * sin(a);
      p[2] = 0.4 * sin(b);
      f[0] = i * kAround + k;
      f[1] = (i + 1) % kAlong * kAround + k;
      f[2] = (i + 1) % kAlong * kAround + (k + 1) % kAround;
      f[3] = i * kAround + (k + 1) % kAround;
    }
  }
  return made(arrays_of(positions, kCount, corners, kCount, 4));
}
