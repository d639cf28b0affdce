/** Dependent quantisation: section 5.3 of api_schema/smc.md. */

/** How fast the mixer learns in its streams. */
export const DEPENDENT_PACE = 12;

/** The state after an even and after an odd number. */
const NEXT = [0, 2, 5, 7, 1, 3, 6, 4, 2, 0, 4, 6, 3, 1, 7, 5];

/** Which of two quantisers the next number belongs to, by the numbers before it. */
export class Trellis {
  #state = 0;
  readonly #dependent: boolean;

  constructor(dependent: boolean) {
    this.#dependent = dependent;
  }

  /** 1 for the odd quantiser, else 0. */
  get odd(): number {
    return this.#state & 1;
  }

  restart(): void {
    this.#state = 0;
  }

  /** The level, in half steps, of the number that comes next. */
  level(value: number): number {
    const level = 2 * value - (this.odd ? Math.sign(value) : 0);
    if (this.#dependent) this.#state = NEXT[2 * this.#state + (value & 1)] as number;
    return level;
  }
}
