#include "encode.glsl"
#include "studio.glsl"

out vec4 colour;

void main() { colour = encodeDim(backdrop(gl_FragCoord.xy)); }
