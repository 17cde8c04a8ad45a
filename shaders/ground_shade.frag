// What a body takes from the ground below it: written with the larger value winning.
uniform vec2 taken;    // share of key light, share of room where it touches
uniform float reach;   // over which the latter falls off, in the height's units

in float height;
out vec4 colour;

void main() { colour = vec4(taken.x, taken.y * exp(-height / reach), 0.0, 0.0); }
