import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { calmed, createStore } from "@/app/store";

beforeEach(() => vi.useFakeTimers());
afterEach(() => vi.useRealTimers());

it("tells of a first change at once, and of those that follow together", () => {
  const store = createStore(0);
  const calm = calmed(store, 100);
  const told: number[] = [];
  const leave = calm.subscribe(() => told.push(calm.get()));
  for (const value of [1, 2, 3]) store.set(value);
  expect(told).toEqual([1]);
  expect(calm.get()).toBe(1);
  vi.advanceTimersByTime(100);
  expect(told).toEqual([1, 3]);
  vi.advanceTimersByTime(500);
  store.set(4);
  expect(told).toEqual([1, 3, 4]);
  store.set(5);
  leave();
  vi.advanceTimersByTime(500);
  expect(told).toEqual([1, 3, 4]);
  expect(calm.get()).toBe(5);
});

it("begins with what is there when somebody comes back", () => {
  const store = createStore("a");
  const calm = calmed(store, 100);
  calm.subscribe(() => undefined)();
  store.set("b");
  calm.subscribe(() => undefined);
  expect(calm.get()).toBe("b");
});
