/** How far a view was turned from where it began: angles in radians, and how many times farther away it is. */
export interface Turn {
  around: number;
  down: number;
  away: number;
}

export interface LinkedView {
  readonly turn: Turn;
  /** Turn as far from where this view began. */
  follow: (turn: Turn) => void;
}

/** Views that turn together: each begins where it shows most, and who turns one turns all as far. */
export class ViewLink {
  readonly #views = new Set<LinkedView>();

  /** Take a view in; it is turned as far as the others are. */
  join(view: LinkedView): void {
    const [other] = this.#views;
    this.#views.add(view);
    if (other) view.follow(other.turn);
  }

  leave(view: LinkedView): void {
    this.#views.delete(view);
  }

  moved(view: LinkedView): void {
    for (const other of this.#views) if (other !== view) other.follow(view.turn);
  }
}
