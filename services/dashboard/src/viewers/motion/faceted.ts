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

/**
 * Shades each face as one plane, from both sides alike, in as few instructions as can be: where the processor draws,
 * every one counts. Face normals come from the picture itself, so that nothing is computed anew for a frame.
 */
export class FacetedMaterial extends ShaderMaterial {
  constructor(paint: Color) {
    super({ vertexShader: VERTEX, fragmentShader: FRAGMENT, side: DoubleSide, uniforms: { paint: { value: paint } } });
  }

  /** Leave out the faces that are turned away: nobody sees them where a mesh is closed. */
  hideBacks(): void {
    this.side = FrontSide;
  }

  /** Whether vertices have colors of their own, in the attribute `color`. */
  set colored(colored: boolean) {
    this.defines = colored ? { COLORED: "" } : {};
    this.needsUpdate = true;
  }
}
