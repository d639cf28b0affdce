import type { ShapeCanvas } from "./ShapeCanvas";

/** Views that look from one place: who turns one turns all. */
export class ViewLink {
  readonly #views = new Set<Pick<ShapeCanvas, "position" | "follow">>();

  /** Take a view in; true where it now looks from where another does. */
  join(view: Pick<ShapeCanvas, "position" | "follow">): boolean {
    const [other] = this.#views;
    this.#views.add(view);
    if (!other) return false;
    view.follow(other.position);
    return true;
  }

  leave(view: Pick<ShapeCanvas, "position" | "follow">): void {
    this.#views.delete(view);
  }

  moved(view: Pick<ShapeCanvas, "position" | "follow">): void {
    for (const other of this.#views) if (other !== view) other.follow(view.position);
  }
}
