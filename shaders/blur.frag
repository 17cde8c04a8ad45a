// One direction of a Gaussian: tight for the key light's shadow, wide for the room's.
uniform sampler2D source;
uniform vec2 direction;  // one texel of the source
uniform vec2 spread;     // in texels, for r and g

out vec4 colour;

void main() {
  vec2 at = gl_FragCoord.xy / vec2(textureSize(source, 0));
  vec2 sum = vec2(0.0);
  float weights = 0.0;
  for (int k = -4; k <= 4; ++k) {
    float weight = exp(-0.125 * float(k * k));
    vec2 tight = at + direction * (float(k) * spread.x), wide = at + direction * (float(k) * spread.y);
    sum += weight * vec2(texture(source, tight).r, texture(source, wide).g);
    weights += weight;
  }
  colour = vec4(sum / weights, 0.0, 0.0);
}
