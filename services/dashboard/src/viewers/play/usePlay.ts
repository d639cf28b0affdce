import { useEffect, useEffectEvent } from "react";

interface Playing {
  playing: boolean;
  /** How many frames there are, and how many are shown in a second. */
  count: number;
  fps: number;
  /** The frame that is shown now. */
  shown: () => number;
  /** Goes on with the first frame after the last; otherwise the last one ends it. */
  loop: boolean;
  /** Show a frame; false where the one before is not drawn yet: this one is left out rather than shown late. */
  onFrame: (index: number) => boolean;
  onEnd?: () => void;
}

/** Shows frame after frame in the time they take, from the one that is shown; from the last one it begins anew. */
export function usePlay({ playing, count, fps, shown, loop, onFrame, onEnd }: Playing): void {
  const first = useEffectEvent(() => (shown() >= count - 1 ? 0 : shown()));
  const show = useEffectEvent(onFrame);
  const end = useEffectEvent(() => onEnd?.());
  useEffect(() => {
    if (!playing || count < 2) return;
    const began = performance.now();
    const from = first();
    let before = -1;
    let request = 0;
    const step = (now: number) => {
      const place = Math.floor(from + (Math.max(now - began, 0) / 1000) * fps);
      const index = loop ? place % count : Math.min(place, count - 1);
      if (index !== before && show(index)) before = index;
      if (!loop && before === count - 1) {
        end();
        return;
      }
      request = requestAnimationFrame(step);
    };
    request = requestAnimationFrame(step);
    return () => cancelAnimationFrame(request);
  }, [playing, count, fps, loop]);
}
