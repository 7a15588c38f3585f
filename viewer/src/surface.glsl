// What every surface of the tissue shares: noise that rides on the tissue, the printed grid, the layers of a cut.
varying vec3 vRest;
varying vec2 vGrid;
varying float vDepth;
varying float vRow;
varying float vQuantity;
uniform int uLook; // 0 painted, 1 grid, 2 a quantity in color
uniform sampler2D uRamp;
uniform sampler2D uLayers;
uniform float uReach; // depth in mm at the right edge of uLayers

float hash(vec3 p) {
  p = fract(p * vec3(0.1031, 0.1030, 0.0973));
  p += dot(p, p.yxz + 33.33);
  return fract((p.x + p.y) * p.z);
}

float noise(vec3 p) {
  vec3 i = floor(p);
  vec3 f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  return mix(mix(mix(hash(i), hash(i + vec3(1, 0, 0)), f.x), mix(hash(i + vec3(0, 1, 0)), hash(i + vec3(1, 1, 0)), f.x), f.y),
             mix(mix(hash(i + vec3(0, 0, 1)), hash(i + vec3(1, 0, 1)), f.x), mix(hash(i + vec3(0, 1, 1)), hash(i + vec3(1, 1, 1)), f.x), f.y), f.z);
}

float layered(vec3 p) { return 0.55 * noise(p) + 0.3 * noise(2.1 * p + 7.0) + 0.15 * noise(4.3 * p + 19.0); }

// Ink of lines of a width at every multiple of a pitch, both in mm; lines finer than a pixel grow pale instead of jagged.
float lines(float x, float pitch, float width) {
  float pixel = fwidth(x);
  float away = abs(fract(x / pitch + 0.5) - 0.5) * pitch;
  float drawn = max(width, 1.2 * pixel);
  float edge = max(0.5 * pixel, 0.12 * width);
  float pale = clamp(width / drawn, 0.35, 1.0) * clamp((0.5 * pitch - pixel) / (0.25 * pitch), 0.0, 1.0);
  return pale * (1.0 - smoothstep(0.5 * drawn - edge, 0.5 * drawn + edge, away));
}

float ink() {
  float wide = max(lines(vGrid.x, 5.0, 0.24), lines(vGrid.y, 5.0, 0.24));
  float fine = max(lines(vGrid.x, 1.0, 0.09), lines(vGrid.y, 1.0, 0.09));
  return max(0.62 * wide, 0.12 * fine);
}

vec3 painted() {
  float broad = layered(0.11 * vRest);
  float close = layered(0.55 * vRest + 31.0);
  float pores = noise(2.6 * vRest);
  vec3 tone = mix(vec3(0.745, 0.46, 0.34), vec3(0.785, 0.51, 0.39), smoothstep(0.25, 0.75, broad));
  tone = mix(tone, vec3(0.75, 0.42, 0.34), 0.22 * smoothstep(0.45, 0.85, close));
  return tone * (0.975 + 0.05 * pores);
}

vec3 skin() {
  if (uLook == 2) {
    vec3 mapped = texture2D(uRamp, vec2(clamp(vQuantity, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
    return mix(mapped, 0.35 * mapped, 0.55 * ink());
  }
  vec3 tone = painted();
  return uLook == 1 ? mix(tone, vec3(0.235, 0.11, 0.085), ink()) : tone;
}

vec3 layer(float uneven) {
  float depth = max(0.0, vDepth + 2.0 * uneven * (layered(0.5 * vRest) - 0.5));
  vec3 color = texture2D(uLayers, vec2(depth / uReach, vRow)).rgb;
  return color * (1.0 - 0.3 * layered(0.8 * vRest + 3.0));
}
