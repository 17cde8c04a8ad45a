#include "frame.glsl"

uniform float opacity;

layout(location = 0) in vec3 position;
layout(location = 1) in vec4 look;  // rgb: linear; w: diameter in screen units

out vec4 tinted;
out float size;

void main() {
  tinted = vec4(look.rgb, opacity);
  size = max(look.w * picture.z, 1.5) + 1.0;  // one pixel for the soft edge
  gl_PointSize = size;
  gl_Position = clip_from_world * vec4(position, 1.0);
}
