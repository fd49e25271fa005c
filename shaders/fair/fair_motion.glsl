// What the polish knows of a control point, its motion: x is the residual, preconditioned and without
// its mean over the polygon, y the last direction, z the height. Curve points have none: 0.

// The direction after the last one.
float turned(vec4 motion, float momentum) { return motion.x + momentum * motion.y; }
