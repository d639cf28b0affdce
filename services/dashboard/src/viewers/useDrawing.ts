import { type RefObject, useEffect, useEffectEvent, useRef, useState } from "react";
import type { ViewerStatus } from "./ViewerFrame";

/** What somebody has who opens a drawing. */
export interface Opening {
  /** Where the canvas goes. */
  element: HTMLElement;
  /** Aborted when nobody waits any more. */
  signal: AbortSignal;
  /** Say what is waited for, and how much of it is there, in [0, 1]. */
  tell: (what: string, fraction: number) => void;
  /** It cannot go on; also later. */
  fail: (error: unknown) => void;
  /** The graphics driver took the picture away. */
  onLost: () => void;
  /** Close something when the drawing ends, however it does; the last one first. Refuses when it has ended. */
  keep: <T extends { close: () => void }>(it: T) => T;
}

interface Opened<T> {
  /** Of the element in which it is drawn. */
  parent: RefObject<HTMLDivElement | null>;
  status: ViewerStatus;
  /** What was opened; there while the status is "ready". */
  drawing: T | null;
  retry: () => void;
}

/** Resolve when the page, as it is now, has been painted; soon also where nothing is, as in a hidden tab. */
function painted(): Promise<unknown> {
  return new Promise((resolve) => {
    requestAnimationFrame(() => setTimeout(resolve));
    setTimeout(resolve, 100);
  });
}

/**
 * Opens a drawing, tells how far it is, and closes it: when its page goes, when it fails, and before the next try. `of`
 * says by identity what is drawn: with another one it is opened anew; null waits.
 */
export function useDrawing<T>(of: unknown, what: string, open: (opening: Opening) => T | Promise<T>): Opened<T> {
  const parent = useRef<HTMLDivElement>(null);
  const [attempt, setAttempt] = useState(0);
  const [state, setState] = useState<{ status: ViewerStatus; drawing: T | null } | null>(null);
  const begin = useEffectEvent(open);
  useEffect(() => {
    const element = parent.current;
    if (!element || of === null) return;
    const controller = new AbortController();
    const { signal } = controller;
    const kept: { close: () => void }[] = [];
    const end = (status: ViewerStatus | null) => {
      if (signal.aborted) return;
      controller.abort();
      for (const it of kept.reverse()) it.close();
      setState(status && { status, drawing: null });
    };
    const fail = (error: unknown) => end({ is: "failed", error });
    const opening: Opening = {
      element,
      signal,
      tell: (what, fraction) => {
        if (!signal.aborted) setState({ status: { is: "loading", what, fraction }, drawing: null });
      },
      fail,
      onLost: () => end({ is: "lost" }),
      keep: (it) => {
        if (signal.aborted) it.close();
        signal.throwIfAborted();
        kept.push(it);
        return it;
      },
    };
    // A browser may stand still while a drawing is made: what is waited for has to be seen before.
    const opened = painted().then(() => {
      signal.throwIfAborted();
      return begin(opening);
    });
    opened.then((drawing) => {
      if (!signal.aborted) setState({ status: { is: "ready" }, drawing });
    }, fail);
    return () => end(null);
  }, [of, attempt]);
  return {
    parent,
    status: state?.status ?? { is: "loading", what, fraction: 0 },
    drawing: state?.drawing ?? null,
    retry: () => {
      setState(null);
      setAttempt((before) => before + 1);
    },
  };
}
