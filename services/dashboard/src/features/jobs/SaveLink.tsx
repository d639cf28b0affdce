import { Anchor } from "@mantine/core";
import { type MouseEvent, type ReactNode, useState } from "react";
import { apiFetch } from "@/api/client";
import { session } from "@/api/session";
import { sayFailure } from "@/app/say";

/** A download. Without a key it is the browser's own; with one, the file is fetched first, as links carry no header. */
export function SaveLink({ url, name, children }: { url: string; name: string; children: ReactNode }) {
  const [busy, setBusy] = useState(false);
  const save = async (event: MouseEvent) => {
    if (session.get().key === null) return;
    event.preventDefault();
    if (busy) return;
    setBusy(true);
    try {
      const content = URL.createObjectURL(await (await apiFetch(url)).blob());
      const link = document.createElement("a");
      link.href = content;
      link.download = name;
      link.click();
      setTimeout(() => URL.revokeObjectURL(content), 60_000);
    } catch (error) {
      sayFailure(`${name} could not be downloaded`, error);
    } finally {
      setBusy(false);
    }
  };
  return (
    <Anchor href={url} download={name} size="sm" onClick={(event) => void save(event)} aria-busy={busy}>
      {children}
    </Anchor>
  );
}
