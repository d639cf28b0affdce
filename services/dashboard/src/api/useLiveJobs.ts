import { useQueryClient } from "@tanstack/react-query";
import { useEffect, useState } from "react";
import { applyEvent, newestEvent } from "./queries";
import { type WatchMode, watchJob } from "./watchJob";

/** Whether the page is in front: a hidden tab listens to nothing, and catches up when it is shown again. */
export function useVisible(): boolean {
  const [visible, setVisible] = useState(() => document.visibilityState === "visible");
  useEffect(() => {
    const update = () => setVisible(document.visibilityState === "visible");
    document.addEventListener("visibilitychange", update);
    return () => document.removeEventListener("visibilitychange", update);
  }, []);
  return visible;
}

/** Follow the events of some jobs into the cache; says whether they are pushed or must be asked for. */
export function useLiveJobs(ids: readonly string[]): WatchMode {
  const client = useQueryClient();
  const visible = useVisible();
  const [mode, setMode] = useState<WatchMode>("stream");
  const wanted = visible ? [...ids].sort().join(" ") : "";
  useEffect(() => {
    if (!wanted) return;
    const controller = new AbortController();
    for (const id of wanted.split(" ")) {
      void watchJob(id, {
        after: newestEvent(client, id),
        onEvent: (event) => applyEvent(client, event),
        onMode: setMode,
        signal: controller.signal,
      });
    }
    return () => controller.abort();
  }, [client, wanted]);
  return mode;
}
