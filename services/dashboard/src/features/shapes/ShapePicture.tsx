import { useQuery } from "@tanstack/react-query";
import { Box } from "lucide-react";
import { useEffect, useRef, useState } from "react";
import { apiFetch } from "@/api/client";
import { session } from "@/api/session";
import type { Shape } from "@/api/types";
import { useStore } from "@/app/store";
import classes from "./shapes.module.css";

interface ShapePictureProps {
  shape: Pick<Shape, "id" | "preview_url" | "indexed_at">;
  size?: number | undefined;
}

/** The picture that was made when the shape was indexed. */
export function ShapePicture({ shape, size }: ShapePictureProps) {
  const { key } = useStore(session);
  const [broken, setBroken] = useState(false);
  return (
    <span className={classes.picture} style={size === undefined ? undefined : { width: size, height: size }}>
      {broken ? (
        <Box size={28} strokeWidth={1.2} aria-hidden="true" />
      ) : key === null ? (
        <img
          src={`${shape.preview_url}?at=${encodeURIComponent(shape.indexed_at)}`}
          alt=""
          decoding="async"
          draggable={false}
          onError={() => setBroken(true)}
        />
      ) : (
        <KeyedPicture shape={shape} onBroken={() => setBroken(true)} />
      )}
    </span>
  );
}

/** With a key the picture is fetched here: what a page names as a source carries none. */
function KeyedPicture({ shape, onBroken }: Pick<ShapePictureProps, "shape"> & { onBroken: () => void }) {
  const image = useRef<HTMLImageElement>(null);
  const { data } = useQuery({
    queryKey: ["shapes", "picture", shape.id, shape.indexed_at],
    staleTime: Number.POSITIVE_INFINITY,
    queryFn: async ({ signal }) => (await apiFetch(shape.preview_url, { signal })).blob(),
  });
  useEffect(() => {
    const element = image.current;
    if (!data || !element) return;
    const url = URL.createObjectURL(data);
    element.src = url;
    return () => URL.revokeObjectURL(url);
  }, [data]);
  return <img ref={image} alt="" decoding="async" draggable={false} onError={onBroken} hidden={!data} />;
}
