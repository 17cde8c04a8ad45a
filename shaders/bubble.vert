#include "frame.glsl"

uniform mat4 world_from_local;
uniform vec4 tint;  // linear; w: opacity at the rim

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;

out vec3 p;
out vec3 n;
out vec4 tinted;

void main() {
  p = (world_from_local * vec4(position, 1.0)).xyz;
  n = mat3(world_from_local) * normal;
  tinted = tint;
  gl_Position = clip_from_world * vec4(p, 1.0);
}
