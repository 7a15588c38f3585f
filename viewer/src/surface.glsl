// What every surface of the tissue shares: noise that rides on the tissue, the printed grid, the layers of a cut.
varying vec3 vRest;
varying vec2 vGrid;
varying float vDepth;
varying float vRow;
varying float vQuantity;
uniform int uLook; // 0 painted, 1 grid, 2 a quantity in color
uniform sampler2D uRamp;
uniform sampler2D uLayers;
uniform highp sampler3D uNoise;
uniform float uReach; // depth in mm at the right edge of uLayers

// Uneven numbers around a half, of several sizes at once; repeats every 16 units of p.
#ifdef QUICK
float layered(vec3 p) { return 0.5; }
#else
float layered(vec3 p) { return texture(uNoise, p / 16.0).r; }
#endif

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
  float pores = layered(2.6 * vRest + 11.0);
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

// The normal of a surface that a height in mm makes uneven (Mikkelsen 2010, "Bump mapping unparametrized surfaces").
vec3 uneven(vec3 normal, vec3 place, float height) {
  vec3 across = dFdx(place);
  vec3 over = dFdy(place);
  vec3 a = cross(over, normal);
  vec3 b = cross(normal, across);
  float area = dot(across, a);
  float pixel = max(length(across), length(over));
  float seen = 1.0 / (1.0 + 18.0 * pixel * pixel); // what is smaller than a pixel would glitter
  vec3 slope = seen * sign(area) * (dFdx(height) * a + dFdy(height) * b);
  return normalize(abs(area) * normal - slope);
}

// Heights in mm of moist, fibrous tissue, and of skin.
float moist() { return 0.45 * layered(0.7 * vRest) + 0.14 * layered(2.3 * vRest + 5.0); }
float fine() { return 0.05 * layered(1.3 * vRest); }

vec3 bed() {
  float fibers = layered(vec3(0.5, 1.7, 1.1) * vRest + 13.0);
  vec3 tone = mix(vec3(0.47, 0.115, 0.10), vec3(0.60, 0.20, 0.15), smoothstep(0.3, 0.7, layered(0.5 * vRest)));
  return mix(tone, vec3(0.66, 0.30, 0.22), 0.4 * smoothstep(0.55, 0.8, fibers));
}

vec3 layer(float uneven) {
  float depth = max(0.0, vDepth + 2.0 * uneven * (layered(0.5 * vRest) - 0.5));
  vec3 color = texture2D(uLayers, vec2(depth / uReach, vRow)).rgb;
  return color * (1.0 - 0.3 * layered(0.8 * vRest + 3.0));
}
