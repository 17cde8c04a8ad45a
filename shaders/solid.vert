#include "frame.glsl"

uniform mat4 world_from_local;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float finish_in;

out vec3 p;
out vec3 n;
out vec3 local;
flat out float finish;

void main() {
  p = (world_from_local * vec4(position, 1.0)).xyz;
  n = mat3(world_from_local) * normal;
  local = position;
  finish = finish_in;
  gl_Position = clip_from_world * vec4(p, 1.0);
}
