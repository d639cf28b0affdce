import { useSyncExternalStore } from "react";

/** A value that lives outside React, with those who want to hear of its changes. */
export interface Store<T> {
  get: () => T;
  set: (next: T) => void;
  subscribe: (listener: () => void) => () => void;
}

export function createStore<T>(initial: T): Store<T> {
  let value = initial;
  const listeners = new Set<() => void>();
  return {
    get: () => value,
    set(next) {
      if (Object.is(next, value)) return;
      value = next;
      for (const listener of [...listeners]) listener();
    },
    subscribe(listener) {
      listeners.add(listener);
      return () => listeners.delete(listener);
    },
  };
}

export function useStore<T>(store: Store<T>): T {
  return useSyncExternalStore(store.subscribe, store.get, store.get);
}

/** The same value, told of at most once in so many milliseconds: for what takes longer to draw than its changes last. */
export function calmed<T>(store: Store<T>, milliseconds: number): Store<T> {
  const listeners = new Set<() => void>();
  let value = store.get();
  let last = Number.NEGATIVE_INFINITY;
  let timer: ReturnType<typeof setTimeout> | null = null;
  let leave: (() => void) | null = null;
  const tell = () => {
    timer = null;
    last = performance.now();
    value = store.get();
    for (const listener of [...listeners]) listener();
  };
  const hear = () => {
    if (timer !== null) return;
    const wait = last + milliseconds - performance.now();
    if (wait <= 0) tell();
    else timer = setTimeout(tell, wait);
  };
  return {
    // What nobody listens to is asked for as it is.
    get: () => (leave ? value : store.get()),
    set: store.set,
    subscribe(listener) {
      listeners.add(listener);
      if (!leave) {
        value = store.get();
        leave = store.subscribe(hear);
      }
      return () => {
        listeners.delete(listener);
        if (listeners.size > 0) return;
        leave?.();
        leave = null;
        if (timer !== null) clearTimeout(timer);
        timer = null;
      };
    },
  };
}
