/** Where a uniform of a program that may not be linked yet is. */
class Place {
  location: WebGLUniformLocation | null = null;

  constructor(
    readonly program: WebGLProgram,
    readonly name: string,
  ) {}
}

/** What becomes of a program when it is linked. */
interface Late {
  places: Place[];
  /** Uniforms to be set, by where they are; the last value counts. */
  values: Map<Place, () => void>;
}

const DRAWS = [
  "drawArrays",
  "drawElements",
  "drawArraysInstanced",
  "drawElementsInstanced",
  "drawRangeElements",
] as const;

/**
 * Let a context compile and link each program when something is drawn with it for the first time.
 *
 * A browser stands still from when a page asks whether a program is linked, or where its uniforms are, until it is.
 * niivue makes 48 programs before it draws anything, and asks that of each; slices are drawn with six.
 * What is said of the uniforms of a program in between is kept until it is linked. One that cannot be linked throws when
 * it is drawn with.
 */
export function linkLate(gl: WebGL2RenderingContext): void {
  const late = new Map<WebGLProgram, Late>();
  let current: WebGLProgram | null = null;
  const compileShader = gl.compileShader.bind(gl);
  const deleteProgram = gl.deleteProgram.bind(gl);
  const getProgramParameter = gl.getProgramParameter.bind(gl);
  const getUniformLocation = gl.getUniformLocation.bind(gl);
  const linkProgram = gl.linkProgram.bind(gl);
  const draws = gl.useProgram.bind(gl); // not called as React's hooks are

  const link = (program: WebGLProgram, { places, values }: Late) => {
    late.delete(program);
    const shaders = gl.getAttachedShaders(program) ?? [];
    for (const shader of shaders) compileShader(shader);
    linkProgram(program);
    if (!getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const told = [gl.getProgramInfoLog(program), ...shaders.map((shader) => gl.getShaderInfoLog(shader))];
      throw new Error(`A shader cannot be used here: ${told.filter(Boolean).join(" ")}`);
    }
    draws(program);
    for (const place of places) place.location = getUniformLocation(program, place.name);
    for (const set of values.values()) set();
  };

  const changed: Partial<WebGL2RenderingContext> = {
    compileShader: () => undefined, // when its program is linked
    linkProgram: (program) => {
      late.set(program, { places: [], values: new Map() });
    },
    getProgramParameter: (program: WebGLProgram, name: GLenum): unknown =>
      name === gl.LINK_STATUS && late.has(program) ? true : getProgramParameter(program, name),
    getUniformLocation: (program, name) => {
      const place = new Place(program, name);
      const waiting = late.get(program);
      if (waiting) waiting.places.push(place);
      else place.location = getUniformLocation(program, name);
      return place;
    },
    useProgram: (program) => {
      current = program;
      if (!program || !late.has(program)) draws(program);
    },
    deleteProgram: (program) => {
      if (program) late.delete(program);
      deleteProgram(program);
    },
  };
  Object.assign(gl, changed);

  const members = gl as unknown as Record<string, (...given: unknown[]) => void>;
  for (const name in gl) {
    if (!/^uniform(\d|Matrix)/.test(name)) continue;
    const set = members[name]?.bind(gl);
    members[name] = (place, ...given) => {
      if (!(place instanceof Place)) return set?.(place, ...given);
      const waiting = late.get(place.program);
      if (!waiting) return set?.(place.location, ...given);
      const values = given.map((value) => (typeof value === "object" ? Array.from(value as ArrayLike<number>) : value));
      waiting.values.set(place, () => set?.(place.location, ...values));
    };
  }
  for (const name of DRAWS) {
    const draw = members[name]?.bind(gl);
    members[name] = (...given) => {
      const waiting = current && late.get(current);
      if (current && waiting) link(current, waiting);
      draw?.(...given);
    };
  }
}
