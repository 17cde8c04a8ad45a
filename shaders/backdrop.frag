#include "encode.glsl"
#include "studio.glsl"

out vec4 colour;

void main() { colour = encode(backdrop(gl_FragCoord.xy), 1.0); }
