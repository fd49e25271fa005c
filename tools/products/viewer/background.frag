#version 450
// A light room: brighter above, a little darker towards the corners.
layout(location = 0) in vec2 place;
layout(location = 0) out vec4 colour;

void main() {
  vec3 wall = mix(vec3(0.93, 0.94, 0.955), vec3(0.72, 0.75, 0.79), smoothstep(-1.0, 1.0, place.y));
  colour = vec4(wall * (1.0 - 0.05 * dot(place, place)), 1.0);
}
