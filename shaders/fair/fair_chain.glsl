// Of how far balanced weights are to be used: from here on they are all there is; chain_share() of
// fair/perpendicular_polygon.h.
const float kFullChain = 0.05;
float chain_share(float usable) { return min(1.0, usable / kFullChain); }

// What a polygon that is bad again is scaled by, so many times.
float quarters(uint word) { return ldexp(1.0, -2 * int(word >> kQuartersShift)); }
