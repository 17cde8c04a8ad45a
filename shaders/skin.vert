#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 reference;
layout(location = 3) in vec4 traits;  // value, contact, cavity, fixed

layout(location = 4) in vec3 albedo;

out vec3 p;
out vec3 n;
out vec3 X;
out vec4 trait;
out vec3 own;

void main() {
  p = position;
  n = normal;
  X = reference;
  trait = traits;
  own = albedo;
  gl_Position = clip_from_world * vec4(position, 1.0);
}
