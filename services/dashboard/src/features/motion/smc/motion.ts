import { decodeFaces } from "./connectivity";
import { CorruptMotion, type Header, readHeader, SectionReader } from "./container";
import { type Corrections, readCorrections } from "./corrections";
import { type Graph, graphOf } from "./graph";
import { GradientGroup } from "./gradient";
import { TrajectoryGroup } from "./trajectory";

/** A motion file (`.smc`) that gives its frames one by one; api_schema/smc.md describes it. */
export class Motion {
  readonly header: Header;
  readonly faces: Uint32Array;
  readonly #bytes: Uint8Array;
  readonly #graph: Graph;
  #open: { number: number; group: TrajectoryGroup | GradientGroup; corrections: Corrections } | null = null;

  constructor(bytes: Uint8Array) {
    const { header, connectivity } = readHeader(bytes);
    const last = header.groups.at(-1);
    new SectionReader(bytes, last ? last.offset + last.length : 0, bytes.length).next("END ");
    this.header = header;
    this.#bytes = bytes;
    this.faces = decodeFaces(connectivity, header.vertices, header.faces);
    this.#graph = graphOf(this.faces, header.vertices);
  }

  /** The number of the group that a frame lies in. */
  groupOf(frame: number): number {
    return this.header.groups.findLastIndex(({ first }) => first <= frame);
  }

  /** The cluster of each vertex in a group (of the profile `gradient`: that of its first face). */
  labels(group: number): Int32Array {
    return this.#group(group).group.labels;
  }

  /** The vertices (3 n) of a frame; opens its group unless that was the last one asked for. */
  frame(index: number, into = new Float64Array(3 * this.header.vertices)): Float64Array {
    const number = this.groupOf(index);
    const { group, corrections } = this.#group(number);
    const within = index - (this.header.groups[number]?.first ?? 0);
    group.frame(within, into);
    for (const [vertex, x, y, z] of corrections.get(within) ?? []) {
      into[3 * vertex] = (into[3 * vertex] ?? 0) + x;
      into[3 * vertex + 1] = (into[3 * vertex + 1] ?? 0) + y;
      into[3 * vertex + 2] = (into[3 * vertex + 2] ?? 0) + z;
    }
    return into;
  }

  #group(number: number) {
    if (this.#open?.number === number) return this.#open;
    const place = this.header.groups[number];
    if (!place) throw new CorruptMotion("GRPS", "has no such group");
    const { frames, offset, length } = place;
    const { vertices, memory } = this.header;
    const reader = new SectionReader(this.#bytes, offset, offset + length);
    const sections = new Map<string, Uint8Array>();
    while (reader.offset < reader.end) {
      const { tag, payload } = reader.next();
      sections.set(tag, payload);
    }
    const found = sections.get("CORR");
    const corrections = found ? readCorrections(found, frames, vertices) : new Map();
    const group =
      this.header.profile === "gradient"
        ? new GradientGroup(sections, frames, vertices, this.faces, memory)
        : new TrajectoryGroup(sections, frames, vertices, this.#graph, memory);
    this.#open = { number, group, corrections };
    return this.#open;
  }
}
