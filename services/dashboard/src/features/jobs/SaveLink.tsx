import { Anchor } from "@mantine/core";
import { type MouseEvent, type ReactNode, useState } from "react";
import { apiFetch } from "@/api/client";
import { session } from "@/api/session";
import { save } from "@/app/save";
import { sayFailure } from "@/app/say";

/** A download. Without a key it is the browser's own; with one, the file is fetched first, as links carry no header. */
export function SaveLink({ url, name, children }: { url: string; name: string; children: ReactNode }) {
  const [busy, setBusy] = useState(false);
  const fetchFirst = async (event: MouseEvent) => {
    if (session.get().key === null) return;
    event.preventDefault();
    if (busy) return;
    setBusy(true);
    try {
      save(await (await apiFetch(url)).blob(), name);
    } catch (error) {
      sayFailure(`${name} could not be downloaded`, error);
    } finally {
      setBusy(false);
    }
  };
  return (
    <Anchor href={url} download={name} size="sm" onClick={(event) => void fetchFirst(event)} aria-busy={busy}>
      {children}
    </Anchor>
  );
}
