// By its bits: compilers may take it that a float is no infinity and no NaN.
#ifndef PLANISH_FINITE
#define PLANISH_FINITE
bool is_finite(float x) { return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u; }
#endif
