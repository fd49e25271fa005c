#version 450
// One triangle that covers the picture, at its back.
layout(location = 0) out vec2 place;  // -1 to 1, y down

void main() {
  place = vec2(gl_VertexIndex == 1 ? 3.0 : -1.0, gl_VertexIndex == 2 ? 3.0 : -1.0);
  gl_Position = vec4(place, 1.0, 1.0);
}
