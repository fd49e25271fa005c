layout(push_constant) uniform View {
  mat4 clip_from_object;
  float level;
  bool by_screen;
  int first_patch;
};
