import { useQuery } from "@tanstack/react-query";
import { type ReactNode, useEffect, useRef } from "react";
import { picture } from "./preview";
import classes from "./preview.module.css";

const SIZE = 128;

interface ThumbnailProps {
  /** What tells this file from others. */
  id: string;
  name: string;
  file: Blob;
  /** In its place until it is there, and where there is nothing to see. */
  children: ReactNode;
}

/** A small picture of a file that lies in the browser: a slice of a volume, a mesh, the first frame of a motion. */
export function Thumbnail({ id, name, file, children }: ThumbnailProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const { data } = useQuery({
    queryKey: ["preview", id],
    staleTime: Number.POSITIVE_INFINITY,
    retry: false,
    queryFn: ({ signal }) => picture(file, name, SIZE, signal),
  });
  useEffect(() => {
    const element = canvas.current;
    if (!data || !element) return;
    [element.width, element.height] = [data.width, data.height];
    element.getContext("2d")?.putImageData(new ImageData(data.data, data.width, data.height), 0, 0);
  }, [data]);
  if (!data) return children;
  return (
    <span className={classes.thumbnail}>
      <canvas ref={canvas} role="img" aria-label={`Preview of ${name}`} data-testid="thumbnail" />
    </span>
  );
}
