/**
 * The four passes, each on what the one before left.
 *
 * Faces: number and light of the face at each pixel, and the scan's colour. Relief: how far a pixel lies behind
 * its surroundings. Paint: from face to atom to part, segment and colour. Picture: outlines and highlights.
 * Only the last one runs while a part blinks, so it looks up as little as it can.
 */

export const FACES_VERTEX = `
precision highp float;
precision highp int;
uniform mat4 projectionView;
uniform vec3 right, up, forward;
in vec3 position;
in vec4 normal;
in uint face;
in vec4 color;
flat out uint faceNumber;
#ifdef IS_CLOUD
in float reach;
uniform vec3 eye;
uniform vec2 window;
uniform float tangent;
uniform bool showsBacks;
flat out vec3 center, disc, eyeNormal, scanColor; // from the eye and in its axes
flat out float radius;
#else
out vec3 eyePosition, eyeNormal, scanColor;
#endif
#ifdef HAS_SECTION
uniform mat3 boxAxes;
out vec3 boxPosition;
#endif
void main() {
#ifdef HAS_SECTION
  boxPosition = boxAxes * position;
#endif
  faceNumber = face + 1u;
  mat3 view = mat3(right.x, up.x, -forward.x, right.y, up.y, -forward.y, right.z, up.z, -forward.z);
  eyeNormal = view * normal.xyz;
  scanColor = color.rgb;
  gl_Position = projectionView * vec4(position, 1.0);
#ifdef IS_CLOUD
  center = view * (position - eye);
  vec3 toEye = -normalize(center);
  float length2 = dot(eyeNormal, eyeNormal);
  eyeNormal = length2 > 0.0 ? eyeNormal * inversesqrt(length2) : toEye;
  float facing = dot(eyeNormal, toEye);
  if (facing < 0.0) eyeNormal = -eyeNormal;
  float pixel = 2.0 * max(-center.z, 1e-6) * tangent / window.y;
  radius = max(reach, 0.75 * pixel);
  // seen at a grazing angle, or hardly larger than a pixel, a disc turns to the eye: it would leave holes
  disc = normalize(eyeNormal + toEye * max(0.0, 0.4 - abs(facing)) + toEye * max(0.0, 3.0 - reach / pixel));
  gl_PointSize = 2.2 * radius / pixel + 1.0;
  if (facing < 0.0 && normal.w > 0.5 && !showsBacks) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
#else
  eyePosition = view * position;
#endif
}`;

export const FACES_FRAGMENT = `
precision highp float;
precision highp int;
flat in uint faceNumber;
#ifdef IS_CLOUD
flat in vec3 center, disc, eyeNormal, scanColor;
flat in float radius;
uniform vec2 window, depths;
uniform float tangent;
#else
in vec3 eyePosition, eyeNormal, scanColor;
#endif
layout(location = 0) out vec4 numberAndLight;
#ifdef HAS_HIDDEN
precision highp usampler2D;
uniform usampler2D faceAtom, atoms;
ivec2 cell(uint i, int width) { return ivec2(int(i) % width, int(i) / width); }
#endif
#if defined(HAS_COLORS) || defined(HAS_NORMALS)
layout(location = 1) out vec4 scan;
#endif
#ifdef HAS_NORMALS
uniform vec3 right, up, forward;
#endif
#ifdef HAS_SECTION
in vec3 boxPosition;
uniform vec3 boxLow, boxHigh;
#endif
const vec3 KEY = normalize(vec3(-0.4, 0.45, 0.8));
const vec3 FILL = normalize(vec3(0.75, -0.15, 0.65));
void main() {
#ifdef HAS_SECTION
  if (any(lessThan(boxPosition, boxLow)) || any(greaterThan(boxPosition, boxHigh))) discard;
#endif
#ifdef HAS_HIDDEN // a variant of its own: whoever may discard loses the early test of depth
  uint number = texelFetch(faceAtom, cell(faceNumber - 1u, textureSize(faceAtom, 0).x), 0).r;
  if ((texelFetch(atoms, cell(number, textureSize(atoms, 0).x), 0).a & 2u) != 0u) discard;
#endif
#ifdef IS_CLOUD
  vec2 place = (2.0 * gl_FragCoord.xy / window - 1.0) * vec2(tangent * window.x / window.y, tangent);
  vec3 way = vec3(place, -1.0);
  vec3 met = way * (dot(center, disc) / dot(way, disc));
  vec3 apart = met - center;
  if (dot(apart, apart) > radius * radius) discard;
  // where discs overlap, the one whose middle is nearest is seen: each point has the place around it
  float ahead = max(-met.z + 0.4 * dot(apart, apart) / radius, depths.x);
  gl_FragDepth = (depths.y / (depths.y - depths.x)) * (1.0 - depths.x / ahead);
  vec3 normal = eyeNormal;
#else
  // the flat normal where the smooth one would round off a crease
  vec3 plane = normalize(cross(dFdx(eyePosition), dFdy(eyePosition)));
  vec3 smoothed = normalize(gl_FrontFacing ? eyeNormal : -eyeNormal);
  float agreement = dot(plane, smoothed);
  vec3 normal = agreement > 0.0 ? normalize(mix(plane, smoothed, smoothstep(0.6, 0.85, agreement))) : plane;
#endif
  float light = 0.7 * (0.42 + 0.58 * dot(normal, KEY)) + 0.3 * (0.3 + 0.7 * dot(normal, FILL));
  uvec3 bytes = uvec3(faceNumber, faceNumber >> 8, faceNumber >> 16) & 255u;
  numberAndLight = vec4(vec3(bytes) / 255.0, clamp(light, 0.0, 1.0));
#if defined(HAS_NORMALS)
#ifdef IS_CLOUD
  vec3 facing = normal;
#else
  vec3 facing = gl_FrontFacing ? plane : -plane;
#endif
  scan = vec4(0.5 + 0.5 * (right * facing.x + up * facing.y - forward * facing.z), 1.0);
#elif defined(HAS_COLORS)
  scan = vec4(scanColor, 1.0);
#endif
}`;

export const SCREEN_VERTEX = `
precision highp float;
in vec3 position;
void main() {
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;

// Eye-dome lighting: Boucheny (2009), thesis, Université Joseph Fourier, Grenoble.
export const RELIEF_FRAGMENT = `
precision highp float;
precision highp int;
uniform highp sampler2D depth;
uniform float near, far, size, reach;
out vec4 relief;
#ifdef IS_DRAFT // half as many samples while the camera moves: most of a frame's time without a graphics card
const int N_EDGES = 4;
const int N_HOLLOWS = 7;
#else
const int N_EDGES = 8;
const int N_HOLLOWS = 14;
#endif
float distanceAt(ivec2 place) {
  float d = texelFetch(depth, clamp(place, ivec2(0), textureSize(depth, 0) - 1), 0).r;
  return near * far / (far - d * (far - near));
}
void main() {
  ivec2 place = ivec2(gl_FragCoord.xy);
  float here = distanceAt(place);
  float edge = 0.0;
  float hollow = 0.0;
  if (here < far * 0.9999) {
    for (int i = 0; i < N_EDGES; i++) {
      float angle = 6.283185 / float(N_EDGES) * float(i) + 0.3;
      vec2 way = vec2(cos(angle), sin(angle)) * reach;
      edge += clamp((here - distanceAt(place + ivec2(round(way)))) / (0.03 * size), 0.0, 1.0);
    }
    for (int i = 0; i < N_HOLLOWS; i++) { // a spiral: no two samples at the same distance, so no bands
      float angle = 2.4 * float(i);
      vec2 way = vec2(cos(angle), sin(angle)) * reach * (3.0 + 22.4 / float(N_HOLLOWS) * float(i));
      float behind = (here - distanceAt(place + ivec2(round(way)))) / (0.025 * size);
      hollow += clamp(behind, 0.0, 1.0) * clamp(3.0 - 0.5 * behind, 0.0, 1.0);
    }
  }
  relief = vec4(1.0 - 0.45 * edge / float(N_EDGES) - 0.5 * hollow / float(N_HOLLOWS), 0.0, 0.0, 1.0);
}`;

export const PAINT_FRAGMENT = `
precision highp float;
precision highp int;
precision highp usampler2D;
uniform sampler2D numbers, scan, relief, colormap;
uniform usampler2D faceAtom, atoms, faceValue;
uniform int colorBy; // 0 by the table, 1 scan, 2 plain, 3 values, 4 normals, which come in the place of the scan
uniform bool hasScan, hasPartition;
uniform float mixing;
uniform vec3 plain, unlabeled;
layout(location = 0) out vec4 painted;
layout(location = 1) out uvec2 keys; // segment and part

const uint NONE = 0xffffffffu;
const uint BACKGROUND = 0xfffffffeu;

ivec2 cell(uint i, int width) { return ivec2(int(i) % width, int(i) / width); }

void main() {
  ivec2 place = ivec2(gl_FragCoord.xy);
  vec4 here = texelFetch(numbers, place, 0);
  uvec3 bytes = uvec3(here.rgb * 255.0 + 0.5);
  uint face = bytes.r | bytes.g << 8 | bytes.b << 16;
  if (face == 0u) {
    painted = vec4(0.0);
    keys = uvec2(BACKGROUND);
    return;
  }
  uvec4 atom = uvec4(NONE, NONE, 0u, 0u);
  if (hasPartition) {
    uint number = texelFetch(faceAtom, cell(face - 1u, textureSize(faceAtom, 0).x), 0).r;
    atom = texelFetch(atoms, cell(number, textureSize(atoms, 0).x), 0);
  }
  vec3 ground = hasScan ? texelFetch(scan, place, 0).rgb : plain;
  vec3 color = ground;
  if (colorBy == 0) {
    color = unlabeled;
    if ((atom.a & 1u) != 0u) color = vec3(atom.b & 255u, atom.b >> 8 & 255u, atom.b >> 16 & 255u) / 255.0;
    color = mix(ground, color, mixing);
  } else if (colorBy == 2) {
    color = plain;
  } else if (colorBy == 3) {
    uint value = texelFetch(faceValue, cell(face - 1u, textureSize(faceValue, 0).x), 0).r;
    color = value == 0u ? unlabeled : texelFetch(colormap, ivec2(int((value - 1u) >> 8), 0), 0).rgb;
    color = mix(ground, color, mixing);
  } else if (colorBy == 4) {
    color = mix(plain, texelFetch(scan, place, 0).rgb, mixing);
  }
  float light = here.a * texelFetch(relief, place, 0).r;
  vec3 shadow = vec3(0.34, 0.35, 0.42);
  float strength = colorBy == 1 || colorBy == 4 ? 0.5 : 1.0; // both bring shadows of their own
  painted = vec4(color * mix(vec3(1.0), mix(shadow, vec3(1.08, 1.07, 1.05), light), strength), 1.0);
  keys = atom.rg;
}`;

export const PICTURE_FRAGMENT = `
precision highp float;
precision highp int;
precision highp usampler2D;
uniform sampler2D painted;
uniform usampler2D keys;
uniform bool hasOutlines, outlinesParts;
uniform float scale, pulse;
uniform vec3 accent;
uniform int width;
uniform ivec2 last;
uniform uint hovered, picked, target; // part, part, segment
out vec4 picture;

const uint NONE = 0xffffffffu;
const uint BACKGROUND = 0xfffffffeu;

vec4 shade(ivec2 place) {
  vec4 color = texelFetch(painted, place, 0);
  bool isPlain = hovered == NONE && picked == NONE && target == NONE;
  if (color.a == 0.0 || (isPlain && !hasOutlines)) return color;
  uvec2 here = texelFetch(keys, place, 0).rg;
  uvec2 right = texelFetch(keys, ivec2(min(place.x + width, last.x), place.y), 0).rg;
  uvec2 above = texelFetch(keys, ivec2(place.x, min(place.y + width, last.y)), 0).rg;
  bool isRight = right.g != BACKGROUND;
  bool isAbove = above.g != BACKGROUND;
  if (hasOutlines) {
    bvec2 differ = outlinesParts ? notEqual(uvec2(right.g, above.g), here.gg) : notEqual(uvec2(right.r, above.r), here.rr);
    if ((isRight && differ.x) || (isAbove && differ.y)) color.rgb *= 0.5;
  }
  if (!isPlain) {
    bool isIn = here.g == hovered;
    bool isBorder = (isRight && (right.g == hovered) != isIn) || (isAbove && (above.g == hovered) != isIn);
    vec3 glow = dot(color.rgb, vec3(0.3, 0.6, 0.1)) > 0.6 ? vec3(0.12, 0.16, 0.3) : vec3(1.0);
    float amount = 0.0;
    if (hovered != NONE && isIn) amount = 0.1 + 0.3 * pulse;
    if (hovered != NONE && isBorder) amount = 0.65;
    color.rgb = mix(color.rgb, glow, amount);
    bool isPicked = picked != NONE && here.g == picked;
    bool isTarget = target != NONE && here.r == target && !isPicked;
    bool isEdge = picked != NONE && ((isRight && (right.g == picked) != isPicked) || (isAbove && (above.g == picked) != isPicked));
    isEdge = isEdge || (target != NONE && ((isRight && (right.r == target) != (here.r == target)) || (isAbove && (above.r == target) != (here.r == target))));
    bool isStripe = (place.x + place.y) % (10 * width) < 4 * width; // seen on every colour, by everybody
    if (isPicked) color.rgb = mix(color.rgb, isStripe ? vec3(1.0) : accent, 0.42);
    if (isTarget) color.rgb = mix(color.rgb, accent, 0.12 + 0.26 * pulse);
    if (isEdge) color.rgb = mix(color.rgb, accent, 0.9);
  }
  return color;
}

void main() {
#ifdef IS_SMOOTH // a variant of its own: software renderers run both sides of an if
  ivec2 place = 2 * ivec2(gl_FragCoord.xy);
  picture = 0.25 * (shade(place) + shade(place + ivec2(1, 0)) + shade(place + ivec2(0, 1)) + shade(place + 1));
#else
  picture = shade(ivec2(gl_FragCoord.xy * scale));
#endif
}`;
