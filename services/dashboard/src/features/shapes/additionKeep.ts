import type { Addition, AdditionKeep } from "./adding";

const PREFIX = "shapery.addition.";

/** One key for each, so that two tabs never overwrite each other. */
export const additionKeep: AdditionKeep = {
  all() {
    try {
      return Object.keys(localStorage)
        .filter((key) => key.startsWith(PREFIX))
        .map((key) => JSON.parse(localStorage.getItem(key) ?? "") as Addition)
        .sort((one, other) => one.createdAt - other.createdAt);
    } catch {
      return []; // storage is forbidden: nothing was kept
    }
  },
  save(addition) {
    try {
      localStorage.setItem(PREFIX + addition.id, JSON.stringify(addition));
    } catch {
      // Storage is full or forbidden: shapes are added, their progress just does not outlive the page.
    }
  },
  drop(id) {
    try {
      localStorage.removeItem(PREFIX + id);
    } catch {
      // as above
    }
  },
};
