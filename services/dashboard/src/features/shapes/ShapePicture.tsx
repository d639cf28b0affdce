import { useQuery } from "@tanstack/react-query";
import { Box } from "lucide-react";
import { useEffect, useEffectEvent, useRef, useState } from "react";
import { apiFetch } from "@/api/client";
import { session } from "@/api/session";
import type { Shape } from "@/api/types";
import { useStore } from "@/app/store";
import classes from "./shapes.module.css";

interface ShapePictureProps {
  shape: Pick<Shape, "id" | "preview_url" | "indexed_at">;
  size?: number | undefined;
}

/** Who scrolls by wants to see nothing: a picture is asked for once its card stays for so many milliseconds. */
const STAYS = 90;
/** Milliseconds until a picture that did not come is asked for again; a server lets only so many be asked at once. */
const AGAIN = [2_000, 6_000, 20_000];

/** The picture that was made when the shape was indexed. */
export function ShapePicture({ shape, size }: ShapePictureProps) {
  const { key } = useStore(session);
  const [attempt, setAttempt] = useState(-1);
  const [broken, setBroken] = useState(false);
  const waits = attempt < 0 ? STAYS : broken ? AGAIN[attempt] : undefined;
  useEffect(() => {
    if (waits === undefined) return;
    const timer = setTimeout(() => {
      setAttempt((before) => before + 1);
      setBroken(false);
    }, waits);
    return () => clearTimeout(timer);
  }, [waits]);
  const fail = () => setBroken(true);
  return (
    <span className={classes.picture} style={size === undefined ? undefined : { width: size, height: size }}>
      {broken ? (
        <Box size={28} strokeWidth={1.2} aria-hidden="true" />
      ) : attempt < 0 ? null : key === null ? (
        <img
          src={`${shape.preview_url}?at=${encodeURIComponent(shape.indexed_at)}`}
          alt=""
          decoding="async"
          draggable={false}
          onError={fail}
        />
      ) : (
        <KeyedPicture shape={shape} onBroken={fail} />
      )}
    </span>
  );
}

/** With a key the picture is fetched here: what a page names as a source carries none. */
function KeyedPicture({ shape, onBroken }: Pick<ShapePictureProps, "shape"> & { onBroken: () => void }) {
  const image = useRef<HTMLImageElement>(null);
  const { data, isError } = useQuery({
    queryKey: ["shapes", "picture", shape.id, shape.indexed_at],
    staleTime: Number.POSITIVE_INFINITY,
    queryFn: async ({ signal }) => (await apiFetch(shape.preview_url, { signal })).blob(),
  });
  const fail = useEffectEvent(onBroken);
  useEffect(() => {
    if (isError) fail();
  }, [isError]);
  useEffect(() => {
    const element = image.current;
    if (!data || !element) return;
    const url = URL.createObjectURL(data);
    element.src = url;
    return () => URL.revokeObjectURL(url);
  }, [data]);
  return <img ref={image} alt="" decoding="async" draggable={false} onError={onBroken} hidden={!data} />;
}
