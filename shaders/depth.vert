// Positions only, for the shadow map and the ground's shade.
uniform mat4 clip_from_local;

layout(location = 0) in vec3 position;

out float height;  // clip z, 0..1

void main() {
  gl_Position = clip_from_local * vec4(position, 1.0);
  height = gl_Position.z * 0.5 + 0.5;
}
