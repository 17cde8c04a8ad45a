#include "frame.glsl"

// A disc as a fan of 64 triangles; it fades into the backdrop before its rim.
const float disc_radius = 3.2;

out vec2 away;  // from the organ, in its radii

void main() {
  int triangle = gl_VertexID / 3, corner = gl_VertexID % 3;
  float angle = 6.28318530718 * float(triangle + (corner == 2 ? 1 : 0)) / 64.0;
  away = corner == 0 ? vec2(0.0) : disc_radius * vec2(cos(angle), sin(angle));
  gl_Position = clip_from_world * vec4(ground.xyz + vec3(away * ground.w, 0.0), 1.0);
}
