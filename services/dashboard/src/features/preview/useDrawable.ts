import { useEffect, useMemo, useState } from "react";
import { apiFetch } from "@/api/client";
import type { Asset } from "@/api/types";
import type { VolumeFile } from "@/viewers/volume/loadVolume";
import { asNifti } from "./preview";

interface Drawable {
  /** A file that the volume viewer reads; null until it is there. */
  file: VolumeFile | null;
  /** Why there is none. */
  error: unknown;
}

const NOTHING: Drawable = { file: null, error: null };

/** A volume as the viewer reads it, which is NIfTI: the file itself, or what is made of another in the browser. */
export function useDrawable(asset: Pick<Asset, "id" | "format" | "content_url" | "size"> | null): Drawable {
  const { id, format, content_url: url, size } = asset ?? { id: "", format: "", content_url: "", size: 0 };
  const name = format.startsWith("nifti") ? "volume.nii.gz" : null; // also where it is not gzipped
  const [made, setMade] = useState<Drawable & { of: string }>({ of: "", ...NOTHING });
  const converts = asset !== null && name === null;
  useEffect(() => {
    if (!converts) return;
    const controller = new AbortController();
    const { signal } = controller;
    let object: string | null = null;
    const convert = async () => {
      const volume = await asNifti(await (await apiFetch(url, { signal })).blob(), format, signal);
      signal.throwIfAborted();
      object = URL.createObjectURL(volume);
      setMade({ of: id, file: { url: object, name: "volume.nii", size: volume.size }, error: null });
    };
    convert().catch((error: unknown) => {
      if (!signal.aborted) setMade({ of: id, file: null, error });
    });
    return () => {
      controller.abort();
      if (object) URL.revokeObjectURL(object);
    };
  }, [converts, id, format, url]);
  return useMemo(() => {
    if (name) return { file: { url, name, size }, error: null };
    return made.of === id ? made : NOTHING;
  }, [name, url, size, made, id]);
}
