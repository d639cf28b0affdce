import type { Graph } from "./graph";

/** The pairing tree of a cluster: section 5.2 of api_schema/smc.md. */
export interface PairingTree {
  /** Nodes of pair i at 2i and 2i + 1; the pair makes node n + i. */
  children: Int32Array;
  levels: Int32Array;
  /** Vertices below each node. */
  sizes: Int32Array;
  /** The pair in which a node is a child; the number of pairs for the last node. */
  parents: Int32Array;
  /** Beside the first child of pair i lie links[linkStarts[2i]] …, beside the second links[linkStarts[2i + 1]] … */
  links: Int32Array;
  linkStarts: Int32Array;
  linkWeights: Float64Array;
  innerWeights: Float64Array;
}

export function pairingTree({ starts, neighbours }: Graph): PairingTree {
  const n = starts.length - 1;
  const pairs = Math.max(n - 1, 0);
  const children = new Int32Array(2 * pairs);
  const levels = new Int32Array(pairs);
  const sizes = new Int32Array(n + pairs).fill(1);
  const linkStarts = new Int32Array(2 * pairs + 1);
  const innerWeights = new Float64Array(pairs);
  const links: number[] = [];
  const linkWeights: number[] = [];
  const position = new Int32Array(n + pairs).fill(-1);
  const partner = new Int32Array(n + pairs).fill(-1);
  const place = new Int32Array(n + pairs);
  const seen = new Int32Array(n + pairs);

  let nodes = Int32Array.from({ length: n }, (_, v) => v);
  let begins = starts;
  let beside = neighbours;
  let weights = new Int32Array(neighbours.length).fill(1);
  let made = 0;
  for (let level = 0; nodes.length > 1; level += 1) {
    const count = nodes.length;
    const before = made;
    nodes.forEach((node, k) => (position[node] = k));
    const matched = match(nodes, sizes, begins, beside, weights, partner);
    if (4 * matched < count) {
      let last = -1;
      for (const node of nodes) {
        if ((partner[node] ?? 0) >= 0) continue;
        if (last < 0) last = node;
        else {
          partner[node] = last;
          partner[last] = node;
          last = -1;
        }
      }
    }
    // Pairs are numbered where their first node comes; `place` tells which node takes a node's place.
    const next: number[] = [];
    nodes.forEach((a, k) => {
      const b = partner[a] ?? -1;
      if (b < 0) {
        place[a] = a;
        next.push(a);
      } else if ((position[b] ?? 0) > k) {
        children[2 * made] = a;
        children[2 * made + 1] = b;
        levels[made] = level;
        sizes[n + made] = (sizes[a] ?? 0) + (sizes[b] ?? 0);
        place[a] = place[b] = n + made;
        next.push(n + made);
        made += 1;
      }
    });
    for (let pair = before; pair < made; pair += 1) {
      for (const side of [0, 1]) {
        const k = position[children[2 * pair + side] ?? 0] ?? 0;
        const other = children[2 * pair + 1 - side];
        for (let e = begins[k] ?? 0; e < (begins[k + 1] ?? 0); e += 1) {
          if (beside[e] === other) innerWeights[pair] = weights[e] ?? 0;
          else {
            links.push(beside[e] ?? 0);
            linkWeights.push(weights[e] ?? 0);
          }
        }
        linkStarts[2 * pair + side + 1] = links.length;
      }
    }
    // The graph of the next level.
    const nextStarts = new Int32Array(next.length + 1);
    const nextBeside: number[] = [];
    const nextWeights: number[] = [];
    seen.fill(-1);
    next.forEach((node, at) => {
      const begin = nextBeside.length;
      const parts = node >= n + before ? [children[2 * (node - n)] ?? 0, children[2 * (node - n) + 1] ?? 0] : [node];
      for (const part of parts) {
        const k = position[part] ?? 0;
        for (let e = begins[k] ?? 0; e < (begins[k + 1] ?? 0); e += 1) {
          const to = place[beside[e] ?? 0] ?? 0;
          if (to === node) continue;
          const known = seen[to] ?? -1;
          if (known >= begin) nextWeights[known] = (nextWeights[known] ?? 0) + (weights[e] ?? 0);
          else {
            seen[to] = nextBeside.length;
            nextBeside.push(to);
            nextWeights.push(weights[e] ?? 0);
          }
        }
      }
      nextStarts[at + 1] = nextBeside.length;
    });
    for (const node of nodes) partner[node] = -1;
    nodes = Int32Array.from(next);
    begins = nextStarts;
    beside = Int32Array.from(nextBeside);
    weights = Int32Array.from(nextWeights);
  }
  const parents = new Int32Array(n + pairs);
  children.forEach((node, at) => (parents[node] = at >> 1));
  parents[n + pairs - 1] = pairs;
  return {
    children,
    levels,
    sizes,
    parents,
    links: Int32Array.from(links),
    linkStarts,
    linkWeights: Float64Array.from(linkWeights),
    innerWeights,
  };
}

/** Small nodes choose first, and take the neighbour to which most edges per vertex lead; gives the number of pairs. */
function match(
  nodes: Int32Array,
  sizes: Int32Array,
  begins: Int32Array,
  beside: Int32Array,
  weights: Int32Array,
  partner: Int32Array,
): number {
  const size = (node: number) => sizes[node] ?? 0;
  const order = Array.from(nodes.keys()).sort((one, two) => size(nodes[one] ?? 0) - size(nodes[two] ?? 0));
  let matched = 0;
  for (const k of order) {
    const a = nodes[k] ?? 0;
    if ((partner[a] ?? 0) >= 0) continue;
    let best = -1;
    let bestWeight = 0;
    for (let e = begins[k] ?? 0; e < (begins[k + 1] ?? 0); e += 1) {
      const b = beside[e] ?? 0;
      const weight = weights[e] ?? 0;
      if ((partner[b] ?? 0) >= 0) continue;
      if (best >= 0) {
        const left = weight * size(best);
        const right = bestWeight * size(b);
        if (left < right || (left === right && b > best)) continue;
      }
      best = b;
      bestWeight = weight;
    }
    if (best < 0) continue;
    partner[a] = best;
    partner[best] = a;
    matched += 1;
  }
  return matched;
}

const NEAREST = 0.1;

/** What predicts a cluster from outside: for each node the edges that lead to earlier clusters, and what is there. */
export interface Outside {
  counts: Float64Array;
  weights: Float64Array;
  means: Float64Array;
}

/** Sums of squared differences along the links of a tree, over the modes decoded so far; by them links are weighted. */
export class LinkWeights {
  readonly links: Float64Array;
  readonly inner: Float64Array;
  readonly #tree: PairingTree;
  readonly #outside: Outside | null;
  readonly #linkSquares: Float64Array;
  readonly #innerSquares: Float64Array;
  readonly #outerSquares: Float64Array;

  constructor(tree: PairingTree, outside: Outside | null) {
    this.#tree = tree;
    this.#outside = outside;
    this.links = Float64Array.from(tree.linkWeights);
    this.inner = Float64Array.from(tree.innerWeights);
    this.#linkSquares = new Float64Array(this.links.length);
    this.#innerSquares = new Float64Array(this.inner.length);
    this.#outerSquares = new Float64Array(outside?.counts.length ?? 0);
  }

  add(means: Float64Array): void {
    const { children, levels, links, linkStarts } = this.#tree;
    const mean = (node: number) => means[node] as number;
    for (let pair = 0; pair < levels.length; pair += 1) {
      for (let at = 2 * pair; at < 2 * pair + 2; at += 1) {
        const node = children[at] as number;
        for (let e = linkStarts[at] as number; e < (linkStarts[at + 1] as number); e += 1) {
          const step = mean(node) - mean(links[e] as number);
          this.#linkSquares[e] = (this.#linkSquares[e] as number) + step * step;
        }
        if (this.#outside) {
          const step = mean(node) - (this.#outside.means[node] as number);
          this.#outerSquares[node] = (this.#outerSquares[node] as number) + step * step;
        }
      }
      const step = mean(children[2 * pair] as number) - mean(children[2 * pair + 1] as number);
      this.#innerSquares[pair] = (this.#innerSquares[pair] as number) + step * step;
    }
  }

  /** Links weigh less the farther apart their ends lie. */
  update(): void {
    const { children, levels, linkStarts, linkWeights, innerWeights } = this.#tree;
    const outside = this.#outside;
    for (let low = 0, high = 0; low < levels.length; low = high) {
      let total = 0;
      let count = 0;
      for (high = low; high < levels.length && levels[high] === levels[low]; high += 1) {
        for (let e = linkStarts[2 * high] as number; e < (linkStarts[2 * high + 2] as number); e += 1) {
          total += Math.sqrt(this.#linkSquares[e] as number);
          count += 1;
        }
      }
      const unit = count > 0 ? total / count : 1;
      if (unit <= 0) continue;
      const lighter = (weight: number, square: number) => {
        const d = Math.max(Math.sqrt(square) / unit, NEAREST);
        return weight / (d * Math.sqrt(d));
      };
      for (let pair = low; pair < high; pair += 1) {
        for (let e = linkStarts[2 * pair] as number; e < (linkStarts[2 * pair + 2] as number); e += 1) {
          this.links[e] = lighter(linkWeights[e] as number, this.#linkSquares[e] as number);
        }
        this.inner[pair] = lighter(innerWeights[pair] as number, this.#innerSquares[pair] as number);
        if (!outside) continue;
        for (let at = 2 * pair; at < 2 * pair + 2; at += 1) {
          const node = children[at] as number;
          const edges = outside.counts[node] as number;
          if (edges > 0) outside.weights[node] = lighter(edges, this.#outerSquares[node] as number);
        }
      }
    }
  }
}
