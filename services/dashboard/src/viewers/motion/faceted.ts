import { Color, DoubleSide, FrontSide, ShaderMaterial } from "three";

const VERTEX = /* glsl */ `
#ifdef COLORED
  attribute vec3 color;
  varying vec3 tint;
#endif
varying vec3 place;
void main() {
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  place = seen.xyz;
#ifdef COLORED
  tint = color;
#endif
  gl_Position = projectionMatrix * seen;
}`;

// The lights of the stage, on a surface without gloss; the square root stands for the curve of the screen's colors.
const FRAGMENT = /* glsl */ `
uniform vec3 paint;
#ifdef COLORED
  varying vec3 tint;
#endif
varying vec3 place;
const vec3 LIGHT = vec3(0.3115, 0.5452, 0.7788);
void main() {
  vec3 n = normalize(cross(dFdx(place), dFdy(place)));
  float lamp = 0.08 + 0.637 * max(dot(n, LIGHT), 0.0);
  vec3 light = lamp + mix(vec3(0.014, 0.024, 0.028), vec3(0.26, 0.298, 0.298), 0.5 * n.y + 0.5);
#ifdef COLORED
  gl_FragColor = vec4(sqrt(tint * light), 1.0);
#else
  gl_FragColor = vec4(sqrt(paint * light), 1.0);
#endif
}`;

/** How a mesh is shaded. */
export interface Shading {
  /** The color of what has no colors of its own. */
  paint: string;
  /** Whether vertices have colors of their own, in the attribute `color`. */
  colored: boolean;
  /** Whether faces that are turned away are left out: nobody sees them where a mesh is closed. */
  solid: boolean;
}

const made = new Map<string, ShaderMaterial>();

/**
 * Shades each face as one plane, from both sides alike, in as few instructions as can be: where the processor draws,
 * every one counts. Face normals come from the picture itself, so that nothing is computed anew for a frame. One
 * material serves all that are shaded alike, and stays: with its last user its program would go.
 */
export function faceted({ paint, colored, solid }: Shading): ShaderMaterial {
  const key = `${paint} ${colored} ${solid}`;
  const known = made.get(key);
  if (known) return known;
  const material = new ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    side: solid ? FrontSide : DoubleSide,
    defines: colored ? { COLORED: "" } : {},
    uniforms: { paint: { value: new Color(paint) } },
  });
  made.set(key, material);
  return material;
}
