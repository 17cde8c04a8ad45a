#include "frame.glsl"

layout(location = 0) in vec3 position;  // of arrowMesh()
layout(location = 1) in vec3 normal;
layout(location = 3) in vec3 origin;    // per arrow: where it starts, m
layout(location = 4) in vec4 along;     // per arrow: xyz from start to tip, m; w: shaft radius, m
layout(location = 5) in vec3 tint;      // per arrow: linear

out vec3 p;
out vec3 n;
out vec4 tinted;

void main() {
  float full = max(length(along.xyz), 1e-9);
  vec3 z = along.xyz / full;
  vec3 x = normalize(cross(z, abs(z.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
  mat3 turn = mat3(x, cross(z, x), z);
  float head = min(6.5 * along.w, 0.6 * full);
  float height = position.z < 1.5 ? position.z * (full - head) : full - head + (position.z - 2.0) * head;
  p = origin + turn * vec3(position.xy * along.w, height);
  n = turn * normal;
  tinted = vec4(tint, 1.0);
  gl_Position = clip_from_world * vec4(p, 1.0);
}
