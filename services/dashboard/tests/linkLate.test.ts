import { describe, expect, it } from "vitest";
import { linkLate } from "@/viewers/volume/linkLate";

/** A context that writes down what it is asked; uniforms are where they are called, unless they are missing. */
class Context {
  readonly LINK_STATUS = 1;
  readonly asked: string[] = [];
  links = true;
  createProgram = (name: string) => ({ name }) as WebGLProgram;
  getAttachedShaders = (program: WebGLProgram) => [`${nameOf(program)}.vert`, `${nameOf(program)}.frag`];
  compileShader = (shader: unknown) => this.#note("compile", shader);
  linkProgram = (program: WebGLProgram) => this.#note("link", nameOf(program));
  getProgramParameter = (program: WebGLProgram, name: number) => {
    this.#note("status", nameOf(program), name);
    return this.links;
  };
  getProgramInfoLog = () => "it does not fit";
  getShaderInfoLog = (shader: string) => `${shader} is fine`;
  isContextLost = () => false;
  getUniformLocation = (program: WebGLProgram, name: string) => {
    this.#note("where", nameOf(program), name);
    return name === "missing" ? null : name;
  };
  useProgram = (program: WebGLProgram | null) => this.#note("use", program && nameOf(program));
  deleteProgram = (program: WebGLProgram | null) => this.#note("delete", program && nameOf(program));
  uniform1i = (place: unknown, value: number) => this.#note("set", place, value);
  uniform4fv = (place: unknown, value: number[]) => this.#note("set", place, ...value);
  uniformMatrix4fv = (place: unknown, transposed: boolean, value: number[]) =>
    this.#note("set", place, transposed, ...value);
  drawArrays = () => this.#note("draw");
  drawElements = () => this.#note("draw");

  #note(...what: unknown[]): void {
    this.asked.push(what.join(" "));
  }
}

function nameOf(program: WebGLProgram): string {
  return (program as { name: string }).name;
}

function late(): { gl: WebGL2RenderingContext; context: Context; made: (name: string) => WebGLProgram } {
  const context = new Context();
  const gl = context as unknown as WebGL2RenderingContext;
  linkLate(gl);
  const made = (name: string) => {
    const program = context.createProgram(name);
    gl.compileShader(`${name}.vert` as WebGLShader);
    gl.linkProgram(program);
    return program;
  };
  return { gl, context, made };
}

describe("linkLate", () => {
  it("asks nothing of a program until something is drawn with it", () => {
    const { gl, context, made } = late();
    const [first, second] = [made("first"), made("second")];
    expect(gl.getProgramParameter(first, gl.LINK_STATUS)).toBe(true);
    const color = gl.getUniformLocation(first, "color");
    const missing = gl.getUniformLocation(first, "missing");
    const matrix = gl.getUniformLocation(second, "matrix");
    const values = [1, 2, 3, 4];
    gl.useProgram(first);
    gl.uniform4fv(color, values);
    gl.uniform1i(missing, 9);
    gl.useProgram(second);
    gl.uniformMatrix4fv(matrix, false, new Float32Array([5]));
    gl.useProgram(first);
    values.fill(0); // what was said is kept as it was
    expect(context.asked).toEqual([]);
    gl.drawArrays(0, 0, 3);
    expect(context.asked).toEqual([
      ...["compile first.vert", "compile first.frag", "link first", "status first 1", "use first"],
      ...["where first color", "where first missing", "set color 1 2 3 4", "set  9", "draw"],
    ]);
  });

  it("lets a linked program alone", () => {
    const { gl, context, made } = late();
    const program = made("one");
    const color = gl.getUniformLocation(program, "color");
    gl.useProgram(program);
    gl.uniform1i(color, 1);
    gl.uniform1i(color, 2); // the last value counts
    gl.drawElements(0, 0, 0, 0);
    expect(context.asked.filter((what) => what.startsWith("set"))).toEqual(["set color 2"]);
    context.asked.length = 0;
    gl.useProgram(null);
    gl.useProgram(program);
    gl.uniform1i(color, 3);
    gl.uniform1i(gl.getUniformLocation(program, "size"), 4);
    gl.drawArrays(0, 0, 3);
    expect(context.asked).toEqual(["use ", "use one", "set color 3", "where one size", "set size 4", "draw"]);
    gl.getProgramParameter(program, gl.LINK_STATUS);
    expect(context.asked.at(-1)).toBe("status one 1");
  });

  it("says at the first drawing why a program cannot be linked", () => {
    const { gl, context, made } = late();
    context.links = false;
    gl.useProgram(made("bad"));
    expect(() => gl.drawArrays(0, 0, 3)).toThrow("it does not fit bad.vert is fine bad.frag is fine");
  });

  it("forgets a program that is deleted before anything was drawn with it", () => {
    const { gl, context, made } = late();
    const program = made("gone");
    gl.useProgram(program);
    gl.deleteProgram(program);
    gl.drawArrays(0, 0, 3);
    expect(context.asked).toEqual(["delete gone", "draw"]);
  });
});
